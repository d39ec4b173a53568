"""Claims on the two-mass model itself: stiff contacts, symmetry, compact form, decoupling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nonsmooth import simulate
from nonsmooth.models import least_preload
from nonsmooth_chapter.fatigue.printed_phases import (
    STATES,
    printed_rates,
    printed_system,
    with_rates,
)
from nonsmooth_chapter.fatigue.rig_data import (
    SET_24,
    SET_25,
    phase_of_samples,
    rig_system,
    stays,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS"]

_MUCH = 10.0  # an order of magnitude, as for "far below" in F20
_ROUNDING, _AGREE = 1e-10, 1e-9
_DATA = {"Fig. 24": SET_24, "Fig. 25": SET_25}


def _contacts(data: Mapping[str, float] = SET_24) -> Evidence:
    softening = data["eps"] * data["theta"] ** 2
    return {"ratio": 1.0 / softening, "shared": 1.0 - 1.0 / (1.0 + 0.5 * softening)}


def _judge_contacts(evidence: Evidence) -> Finding:
    ratio = evidence["ratio"]
    return Finding(
        ratio >= _MUCH,
        f"k_sc/k_s = 1/(eps theta^2) = {ratio:.2f}, much larger from {_MUCH:g}; two such contacts"
        f" take {evidence['shared']:.1%} off the stiffness that the masses feel",
    )


def _together(periods: int = 100) -> Evidence:
    """Largest difference of the masses with preloads that keep contact, equal and not."""
    rows = []
    for ratio in (1.0, 0.7):
        least = least_preload(rig_system(), ratio=ratio, motion="start-up")
        f1, f2 = 1.1 * least["least_at_ratio"].values
        run = simulate(rig_system(f1=f1, f2=f2), periods=periods)
        rows.append(
            {
                "f1": float(f1),
                "f2": float(f2),
                "phases": sorted({row[0] for row in stays(run)}),
                "apart": float(np.abs(run["X1"] - run["X4"]).max()),
                "amplitude": float(np.abs(run["X1"]).max()),
            }
        )
    return {"rows": rows, "periods": periods}


def _judge_together(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"f1 {row['f1']:.3f}, f2 {row['f2']:.3f}: phases {' '.join(row['phases'])}, apart"
        f" {row['apart']:.0e} at an amplitude of {row['amplitude']:.3f}"
        for row in rows
    )
    return Finding(
        all(row["phases"] == ["i"] and row["apart"] < _ROUNDING * row["amplitude"] for row in rows),
        listed,
    )


def _compact(periods: int = 10) -> Evidence:
    rows = []
    for name, data in _DATA.items():
        run = simulate(with_rates(data), periods=periods, samples_per_period=400)
        other = simulate(printed_system(data), periods=periods, samples_per_period=400)
        phases = phase_of_samples(run)
        printed = printed_rates(data, run, phases)
        off = [
            float(
                np.max(
                    np.abs(run[f"rate_{state}"].values - printed[state])
                    / (1.0 + np.abs(printed[state]))
                )
            )
            for state in STATES
        ]
        apart = max(float(np.abs(run[state] - other[state]).max()) for state in STATES)
        rows.append(
            {
                "set": name,
                "phases": sorted(set(map(str, phases))),
                "rates_apart": max(off),
                "runs_apart": apart,
                "same_word": [s[0] for s in stays(run)] == [s[0] for s in stays(other)],
            }
        )
    return {"rows": rows, "periods": periods}


def _judge_compact(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    seen = {phase for row in rows for phase in row["phases"]}
    same = all(
        row["same_word"] and max(row["rates_apart"], row["runs_apart"]) < _AGREE for row in rows
    )
    listed = "; ".join(
        f"{row['set']} set, phases {' '.join(row['phases'])}: rates differ by"
        f" {row['rates_apart']:.0e}, runs by {row['runs_apart']:.0e}"
        for row in rows
    )
    return Finding(
        same and seen == {"i", "ii", "iii", "iv"},
        f"{listed}; the agreement needs the balance at rest, which the chapter leaves out",
    )


def _decoupled(periods: float = 6.0) -> Evidence:
    """Two starts of equal sums: what the difference does, and whether the sums part."""
    system = rig_system(SET_25, f1=100.0, f2=100.0)
    p = SET_25
    end = periods * 2.0 * np.pi / p["eta"]
    times = np.linspace(0.0, end, 6001)
    even = {"X1": 0.1, "X4": 0.1}
    runs = [simulate(system, start, times=times) for start in (even, {"X1": 0.15, "X4": 0.05})]
    sums = [run["X1"].values + run["X4"].values for run in runs]
    rate = p["xi_Ls"] + p["xi_p1"] * p["lambda1"]
    omega = np.sqrt(1.0 + p["lambda1"] ** 2 + 1.0 / p["eps"] - rate**2)
    found = 0.5 * (runs[1]["X1"].values - runs[1]["X4"].values)
    closed = 0.05 * np.exp(-rate * times) * (
        np.cos(omega * times) + rate / omega * np.sin(omega * times)
    )  # fmt: skip
    return {
        "phases": sorted({row[0] for run in runs for row in stays(run)}),
        "coupling": _coupling(),
        "sums_apart": float(np.abs(sums[0] - sums[1]).max()),
        "specimens_apart": float(np.abs(runs[0]["X3"] - runs[1]["X3"]).max()),
        "rate": rate,
        "difference_off": float(np.abs(found - closed).max()),
        "left": float(np.abs(found[-1000:]).max() / 0.05),
        "periods": periods,
    }


def _coupling(data: Mapping[str, float] = SET_25) -> float:
    """Largest entry of Eq. (38) between (sum, specimen) and difference, in the new variables."""
    p = data
    k = -(1.0 + p["lambda1"] ** 2 + 1.0 / p["eps"])
    c = -2.0 * (p["xi_Ls"] + p["xi_p1"] * p["lambda1"])
    soft = 1.0 / (2.0 * p["eps"] * p["theta"] * p["xi_s"])
    matrix = np.array([
        [0.0, 1.0, 0.0, 0.0, 0.0],
        [k, c, 1.0 / p["eps"], 0.0, 0.0],
        [soft, 0.0, -2.0 * soft - p["theta"] / (2.0 * p["xi_s"]), soft, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0 / p["eps"], k, c],
    ])  # fmt: skip
    # y1 y2 y3 z1 z2 of section 3.4
    change = np.array([
        [0.5, 0.0, 0.0, 0.5, 0.0], [0.0, 0.5, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0, 0.0],
        [0.5, 0.0, 0.0, -0.5, 0.0], [0.0, 0.5, 0.0, 0.0, -0.5],
    ])  # fmt: skip
    new = change @ matrix @ np.linalg.inv(change)
    return float(max(np.abs(new[:3, 3:]).max(), np.abs(new[3:, :3]).max()))


def _judge_decoupled(evidence: Evidence) -> Finding:
    small = max(evidence["sums_apart"], evidence["specimens_apart"], evidence["difference_off"])
    return Finding(
        evidence["coupling"] == 0.0
        and small < _ROUNDING
        and evidence["rate"] > 0.0
        and evidence["phases"] == ["i"],
        f"coupling terms {evidence['coupling']:g}; sums of two starts that differ in the difference"
        f" alone part by {evidence['sums_apart']:.0e}; the difference decays as"
        f" exp(-{evidence['rate']:.4f} tau) (closed form within {evidence['difference_off']:.0e}),"
        f" to {evidence['left']:.0e} of its start in {evidence['periods']:g} periods",
    )


CHECKS = (
    Check("F21", f"Fig. 24 set; much larger: a ratio of {_MUCH:g} at least, as for F20",
          _contacts, _judge_contacts),
    Check("F22", "Fig. 24 set, f1 = f2 and f2 = 0.7 f1, ten per cent above the least forces that"
          " keep contact in the start-up; from zero, 100 periods", _together, _judge_together),
    Check("F23", "sets of Figs. 24 and 25 from zero, 10 periods: rates by Eqs. (38)-(41) and by"
          " (43) along the run, difference over 1 + their size; and runs of both", _compact,
          _judge_compact),
    Check("F31", "Fig. 25 set with forces that keep contact: the matrix of Eq. (38) in the"
          " variables of (44), and two runs of equal sum", _decoupled, _judge_decoupled),
)  # fmt: skip
