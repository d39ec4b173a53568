"""Claims on single motions of the mole, simulated and settled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import StroboscopicMap, attractors, power_spectrum, simulate
from nonsmooth.models import moling, progression
from nonsmooth_chapter.judgement import Evidence, Finding
from nonsmooth_chapter.mole.model_claims import STATIC_FORCES
from nonsmooth_chapter.mole.sweeps import (
    STARTS,
    bounded_states,
    primitive_period,
    regimes_from,
    settled_regime,
)

# Claims on simulated histories: the experiment's sets, settling, and the best progression.

_VISIBLE = 0.01  # of the height of a plot: about the width of a printed line


def _history(a: float, b: float, xi: float, omega: float, kept: int = 50) -> Evidence:
    """What a history of the mole consists of once it has settled."""
    system = moling(a=a, b=b, xi=xi, omega=omega)
    run = simulate(system, periods=300 + kept)
    late = run["event_time"].values >= 300 * run.attrs["period"]
    impacts = int(np.sum(run["event_name"].values[late] == "impact"))
    return {
        "parameters": system.parameter_values,
        "regime": settled_regime(system),
        "impacts_per_period": impacts / kept,
        "progression_per_period": float(progression(run, periods=kept)["per_period"]),
        "largest_p": float(run["p"].values.max()),
        "least_p": float(run["p"].values.min()),
        "word": run.attrs["phase_word"],
    }


def _first_test() -> Evidence:
    return _history(a=0.5, b=0.456, xi=0.35, omega=0.11)


def _second_test() -> Evidence:
    return _history(a=0.5, b=0.48, xi=0.11, omega=0.1)


def _judge_history(evidence: Evidence) -> Finding:
    text = (
        f"{_regime_name(evidence['regime']['period'])}, impacts per period"
        f" {evidence['impacts_per_period']:g}, progression per period"
        f" {evidence['progression_per_period']:.4g}, p between"
        f" {evidence['least_p']:.3g} and {evidence['largest_p']:.3g}"
    )
    # nothing to compare it with
    return Finding(
        None,
        f"{text}; the measured record with its scales would decide: impacts per period, and the"
        " progression per period and the range of p in units of P_f/k",
    )


def _settling(
    forces: Sequence[float] = STATIC_FORCES,
    span: tuple[float, float] = (800.0, 1200.0),
    turns: int = 1500,
) -> Evidence:
    rows = []
    for b in forces:
        system = moling(b=b)
        period = 2.0 * np.pi / system.parameter_values["omega"]
        points = bounded_states(simulate(system, times=span[0] + period * np.arange(turns)))
        late = bounded_states(simulate(system, periods=turns // 2))[-100 * 100 :]
        extent = np.ptp(late, axis=0)
        settled = points[turns // 2 :] / extent
        apart = [
            float(np.abs(settled - point).max(axis=1).min())
            for point in points[: int((span[1] - span[0]) // period) + 1] / extent
        ]
        found, _ = primitive_period(points[turns // 2 :])
        rows.append(
            {
                "b": b,
                "period": found,
                "at_start": apart[0],
                "largest": max(apart),
                "spacing": 0.0 if found else _spacing(settled),
            }
        )
    return {"span": list(span), "rows": rows}


def _spacing(points: np.ndarray) -> float:
    """Largest distance of a point from the nearest other one: what a point more would have."""
    distances = np.abs(points[:, None] - points).max(axis=2)
    np.fill_diagonal(distances, np.inf)
    return float(distances.min(axis=1).max())


def _judge_settling(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    allowed = [max(_VISIBLE, row["spacing"]) for row in rows]
    at_start = [row["at_start"] <= limit for row, limit in zip(rows, allowed, strict=True)]
    throughout = [row["largest"] <= limit for row, limit in zip(rows, allowed, strict=True)]
    listed = ", ".join(
        f"b {row['b']:g} {row['at_start']:.1e} ({row['largest']:.1e} at most)" for row in rows
    )
    text = (
        f"distance from the attractor, as a share of its extent, at tau = {evidence['span'][0]:g}"
        f" (and in the periods up to {evidence['span'][1]:g}): {listed}; within {_VISIBLE:g}, or"
        f" among the points of an aperiodic one, at the start {sum(at_start)} of {len(rows)},"
        f" throughout {sum(throughout)}"
    )
    return Finding(all(at_start), text)


def _best_drift(forces: Sequence[float] = STATIC_FORCES, span: float = 1200.0) -> Evidence:
    rows = []
    for b in forces:
        system = moling(b=b)
        row = {"b": b, **settled_regime(system)}
        row["drift"] = float(simulate(system, times=[0.0, span])["v"][-1])
        row["other_starts"] = regimes_from(system)
        rows.append(row)
    return {"span": span, "n_starts": len(STARTS), "rows": rows}


def _judge_best(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    by_span = max(rows, key=lambda row: row["drift"])
    by_period = max(rows, key=lambda row: row["per_period"])
    others = [(found, row["b"]) for row in rows for found in row["other_starts"]]
    by_start, its_b = max(others, key=lambda pair: pair[0]["per_period"])
    readings = {by_span["period"] == 1, by_period["period"] == 1, by_start["period"] == 1}
    listed = ", ".join(
        f"b {row['b']:g}: {row['drift']:.1f} ({_regime_name(row['period'])})" for row in rows
    )
    coexisting = [f"{row['b']:g}" for row in rows if len(row["other_starts"]) > 1]
    text = (
        f"drift at tau = {evidence['span']:g} {listed}; most per period"
        f" {by_period['per_period']:.3f} at b = {by_period['b']:g}, from any of"
        f" {evidence['n_starts']} other starts {by_start['per_period']:.3f} at b = {its_b:g}"
        + (f"; other attractors found at b = {', '.join(coexisting)}" if coexisting else "")
    )
    return Finding(readings.pop() if len(readings) == 1 else None, text)


def _regime_name(period: int) -> str:
    return f"period {period}" if period else "aperiodic"


# Claims on the four steady motions of Fig. 7(b)-(e): their regimes, and what coexists.

# Wide enough for the flights of all four motions, which reach p = -113 and abs(y) = 7.2.
_WINDOW = {"p": (-120.0, 3.0), "y": (-8.0, 8.0)}
_SECTION = {"q": "max(0, p - g)"}
_STARTS = 300
_ERRORS = 3.0  # standard errors
_CLOSES = 1e-8  # largest difference of strobes that counts as none
_HIGH = 5.5  # times the frequency of the excitation: above half of the contact's, 10 times it
_CLEARLY = 2.0  # times the share of each periodic motion of the figure


def _steady(b: float, starts: int = _STARTS) -> Evidence:
    """Regime from rest with its evidence, and the attractors that random starts find."""
    system = moling(b=b)
    found = attractors(
        StroboscopicMap(system), _WINDOW, completion=_SECTION, samples=starts, seed=0
    )
    coexisting = [
        {
            "period": int(found["period"].sel(attractor=k)),
            "kind": str(found["kind"].sel(attractor=k).item()),
            "fraction": float(found["fraction"].sel(attractor=k)),
        }
        for k in found["attractor"].values
    ]
    unsettled = int(found.attrs["unsettled_starts"] + found.attrs["ended_starts"])
    return {
        "b": b,
        **settled_regime(system),
        "starts": starts,
        "unsettled": unsettled,
        "attractors": coexisting,
    }


def _judge_period(evidence: Evidence, printed: int) -> Finding:
    periodic = evidence["period"] and evidence["residual"] <= _CLOSES
    told = (
        f"period {evidence['period']}, strobes repeat to {evidence['residual']:.1e}, largest"
        f" multiplier {evidence['multiplier']:.3f}"
        if periodic
        else f"no period up to 64, least difference of strobes {evidence['residual']:.1e}"
    )
    true = bool(periodic) and evidence["period"] == printed and evidence["multiplier"] < 1.0
    return Finding(true, f"b {evidence['b']:g} from rest: {told}; {_coexistence(evidence)}")


def _coexistence(evidence: Evidence) -> str:
    listed = ", ".join(
        f"{'period ' + str(each['period']) if each['period'] else each['kind']}"
        f" ({100.0 * each['fraction']:.3g} %)"
        for each in evidence["attractors"]
    )
    left = f", {evidence['unsettled']} unsettled" if evidence["unsettled"] else ""
    return f"{evidence['starts']} random starts find {listed}{left}"


def _spectrum(b: float, transient: int = 200, record: int = 400) -> Evidence:
    """Share of the power of y at high frequency, and impacts per period, from rest."""
    run = simulate(moling(b=b), periods=transient + record, samples_per_period=512)
    found = power_spectrum(run, "y", transient=transient, window="hann", segments=20)
    power, harmonic = found["power_density"].values, found["harmonic"].values
    late = run["event_time"].values >= transient * run.attrs["period"]
    impacts = int(np.sum(run["event_name"].values[late] == "impact"))
    return {
        "b": b,
        "high_share": float(power[harmonic > _HIGH].sum() / power[1:].sum()),
        "impacts_per_period": impacts / record,
    }


def _chaos(
    b: float = 0.19, periodic: Sequence[float] = (0.095, 0.1, 0.15), starts: int = _STARTS
) -> Evidence:
    return _steady(b, starts) | {"spectra": [_spectrum(each) for each in (b, *periodic)]}


def _judge_chaos(evidence: Evidence) -> Finding:
    own, *others = evidence["spectra"]
    exponent, error = evidence.get("exponent", 0.0), evidence.get("exponent_error", 0.0)
    chaotic = not evidence["period"] and exponent > _ERRORS * error
    high = all(own["high_share"] > _CLEARLY * each["high_share"] for each in others)
    told = (
        f"no period up to 64, largest exponent per period {exponent:.3f} +- {error:.3f}"
        if chaotic
        else f"period {evidence['period']}, largest exponent per period {exponent:.3f}"
    )
    listed = ", ".join(f"{each['high_share']:.2%} at b {each['b']:g}" for each in others)
    text = (
        f"b {evidence['b']:g} from rest: {told}; {own['high_share']:.2%} of the power of y above"
        f" {_HIGH:g} times the frequency of the excitation, {listed};"
        f" {own['impacts_per_period']:.3g} impacts per period; {_coexistence(evidence)}"
    )
    return Finding(chaotic and high and own["impacts_per_period"] > 1.0, text)
