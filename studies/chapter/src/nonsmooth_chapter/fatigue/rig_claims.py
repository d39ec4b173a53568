"""Claims on the equations of the rig, dimensionless and in SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nonsmooth import simulate
from nonsmooth.fatigue import Specimen, aluminium_2024_t351
from nonsmooth.models import FatigueRig, least_preload, one_mass, reduction_error
from nonsmooth_chapter.fatigue.rig import (
    SET_24,
    SET_25,
    STATES,
    phase_of_samples,
    printed_rates,
    printed_system,
    rig_system,
    start_up,
    stays,
    steady,
    with_rates,
)
from nonsmooth_chapter.judgement import Evidence, Finding

__all__ = ["rig_of_fig_25"]


# Claims on the two-mass model itself: stiff contacts, symmetry, compact form, decoupling.

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


# Claims on the rig in SI units: what the data of Fig. 25 make of it, preloads, and one mass.

_GRAVITY = 9.80665
_STEP = 1e-4  # above and below a least preload
_LADDER = (0.02012, 0.002012, 0.0002012, 0.00002012)


def rig_of_fig_25() -> FatigueRig:
    """Rig that has the parameters of Fig. 25 at 19.15 Hz and 2.8 mm with the chapter's specimen.

    Returns
    -------
    FatigueRig

    Examples
    --------
    >>> round(rig_of_fig_25().mass, 2)
    8.29
    """
    return FatigueRig.from_dimensionless(frequency=19.15, base_amplitude=2.8, **SET_25)


def _histories() -> Evidence:
    rig = rig_of_fig_25()
    run = rig.to_si(steady(rig.system()))
    first = rig.to_si(start_up(rig.system()))
    names = ("base", "acceleration1", "acceleration2", "X1", "X3", "X4")
    period = float(run.attrs["rig_frequency"]) ** -1
    durations: dict[str, float] = {}
    rows = stays(run)
    for phase, begin, end in rows:
        durations[phase] = durations.get(phase, 0.0) + end - begin
    whole = rows[-1][2] - rows[0][1]
    return {
        "amplitudes": {n: 0.5 * float(np.ptp(run[n].values)) for n in names},
        "units": {n: str(run[n].attrs["units"]) for n in names},
        "shares": {phase: value / whole for phase, value in durations.items()},
        "start_up": sorted({row[0] for row in stays(first)}),
        "word": str(run.attrs["phase_word"]),
        "period": period,
    }


def _judge_histories(evidence: Evidence) -> Finding:
    listed = ", ".join(
        f"{name} {value:.3g} {evidence['units'][name]}"
        for name, value in evidence["amplitudes"].items()
    )
    shares = ", ".join(f"({phase}) {value:.1%}" for phase, value in evidence["shares"].items())
    return Finding(
        None,
        f"half ranges in steady motion: {listed}; phases {shares} of the time, so the theory loses"
        " contact where section 3.5 says that the tests did not; there is no record to compare",
    )


def _derived() -> Evidence:
    rig = rig_of_fig_25()
    s = Specimen()
    load = float(rig.to_si(start_up(rig.system()))["load"][0])
    motion = rig.to_si(steady(rig.system()))
    ligament = s.width - s.notch
    largest = float(np.abs(motion["load"]).max())
    # bending stress in the ligament under the notch, without concentration
    stress = 1.5 * largest * s.span / (s.thickness * ligament**2)
    return {
        "mass": rig.mass,
        "leaf_stiffness": rig.leaf_stiffness,
        "contact_stiffness": rig.contact_stiffness,
        "specimen_stiffness": rig.specimen_stiffness,
        "cylinder_stiffness": rig.cylinder_stiffness_1,
        "P1": rig.cylinder_force_1,
        "P2": rig.cylinder_force_2,
        "static_load": load,
        "largest_load": largest,
        "stress": stress,
        "yield_strength": float(aluminium_2024_t351()["yield_strength"]),
        "base_acceleration": float(np.abs(motion["base"]).max()),
        "natural_frequency": rig.natural_frequency,
        "recomputed": rig.parameters(),
        "printed": dict(SET_25),
        "weight": rig.mass * _GRAVITY,
    }


def _judge_derived(evidence: Evidence) -> Finding:
    e = evidence
    positive = all(
        e[name] > 0.0
        for name in ("mass", "leaf_stiffness", "contact_stiffness", "P1", "P2", "static_load")
    )
    consistent = all(
        abs(e["recomputed"][name] / value - 1.0) < 1e-9 for name, value in e["printed"].items()
    )
    sizes = e["stress"] < e["yield_strength"] and 1.0 < e["mass"] < 100.0
    return Finding(
        positive and consistent and sizes,
        "the printed numbers fix the rig, so they cannot contradict each other (put back, the data"
        " give them again, an identity); what could fail are signs and sizes:"
        f" m = {e['mass']:.2f} kg, k_Ls = {e['leaf_stiffness'] / 1e3:.1f} kN/m (alone"
        f" {e['natural_frequency']:.2f} Hz), k_sc = {e['contact_stiffness'] / 1e6:.2f} MN/m, k_s ="
        f" {e['specimen_stiffness'] / 1e3:.0f} kN/m, k_p = {e['cylinder_stiffness'] / 1e3:.0f}"
        f" kN/m, P1 = {e['P1']:.0f} N, P2 = {e['P2']:.0f} N (weight of a mass {e['weight']:.0f} N);"
        f" load at rest {e['static_load']:.1f} N, at most {e['largest_load']:.0f} N, bending stress"
        f" in the ligament {e['stress']:.0f} MPa of {e['yield_strength']:.0f} MPa at yield; base"
        f" {e['base_acceleration']:.1f} m/s^2",
    )


def _preloads(periods: int = 60) -> Evidence:
    system = rig_system(SET_25)
    rows = []
    for motion in ("steady", "start-up"):
        found = least_preload(system, motion=motion)
        f1, f2 = map(float, found["least_at_ratio"].values)
        lost = {}
        for name, factor in (("above", 1.0 + _STEP), ("below", 1.0 - _STEP)):
            changed = system.with_parameters(f1=factor * f1, f2=factor * f2)
            run = steady(changed) if motion == "steady" else start_up(changed, periods)
            lost[name] = sorted({row[0] for row in stays(run)} - {"i"})
        rows.append(
            {
                "motion": motion,
                "f1": f1,
                "f2": f2,
                "f2_alone": float(found["least_alone"][1]),
                "margins": [float(value) for value in found["margin"]],
                "lost": lost,
            }
        )
    return {"rows": rows, "printed": [SET_25["f1"], SET_25["f2"]]}


def _judge_preloads(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['motion']}: f1 {row['f1']:.3f} with f2 {row['f2']:.3f} at their ratio, or f2"
        f" {row['f2_alone']:.3f} alone (simulated just above: no loss, just below: phase"
        f" {' '.join(row['lost']['below']) or 'i'})"
        for row in rows
    )
    margins = ", ".join(f"{value:+.3f}" for value in rows[0]["margins"])
    return Finding(
        all(np.isfinite(row["f1"]) and not row["lost"]["above"] for row in rows),
        f"least forces that keep contact, {listed}; the printed forces do not: least contact forces"
        f" of masses 1 and 2 {margins} in steady motion",
    )


def _reduction(ladder: Sequence[float] = _LADDER, periods: int = 60) -> Evidence:
    """Closed-form errors over eps, and one pair of runs at the printed eps."""
    system = rig_system(SET_25, f1=100.0, f2=100.0)
    found = reduction_error(system, list(ladder))
    errors = {
        str(version): found["error"].sel(version=version).values.tolist()
        for version in found["version"].values
    }
    orders = {
        name: [float(x) for x in np.diff(np.log(each)) / np.diff(np.log(ladder))]
        for name, each in errors.items()
    }
    whole = simulate(system, periods=periods, samples_per_period=200)
    late = slice(-201, None)
    masses = 0.5 * (whole["X1"] + whole["X4"]).values[late]
    runs = {}
    for version in errors:
        # the keys are the two versions, which typing takes for any text
        made = one_mass(system, version=version)  # type: ignore[arg-type]
        run = simulate(made.system(), periods=periods, samples_per_period=200)
        off = np.abs(run["y"].values[late] - masses).max() / np.abs(masses).max()
        runs[version] = float(off)
    return {"eps": list(ladder), "errors": errors, "orders": orders, "simulated": runs,
            "printed": SET_25["eps"]}  # fmt: skip


def _judge_reduction(evidence: Evidence) -> Finding:
    errors, eps = evidence["errors"], evidence["eps"]
    at = eps.index(evidence["printed"])
    vanish = all(
        all(np.diff(each) < 0.0) and evidence["orders"][name][-1] > 0.9
        for name, each in errors.items()
    )
    listed = "; ".join(
        f"{name}: "
        + ", ".join(f"{e:.1e} at {x:g}" for x, e in zip(eps, each, strict=True))
        + f" (simulated at {eps[at]:g}: {evidence['simulated'][name]:.1e})"
        for name, each in errors.items()
    )
    return Finding(
        vanish,
        f"relative error of the masses' motion over eps, {listed}; falls as eps to the power"
        f" {evidence['orders']['chapter'][-1]:.2f} and {evidence['orders']['repaired'][-1]:.2f}",
    )
