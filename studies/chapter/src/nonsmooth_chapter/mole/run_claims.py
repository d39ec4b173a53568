"""Claims on simulated histories: the experiment's sets, settling, and the best progression."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import simulate
from nonsmooth.models import moling, progression
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.model_claims import STATIC_FORCES
from nonsmooth_chapter.mole.regime import (
    STARTS,
    bounded_states,
    primitive_period,
    regimes_from,
    settled_regime,
)

__all__ = ["CHECKS"]

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


CHECKS = (
    Check("M05", "from rest, 300 periods dropped, 50 kept", _first_test, _judge_history),
    Check("M06", "from rest, 300 periods dropped, 50 kept", _second_test, _judge_history),
    Check(
        "M15",
        "six b, from rest; attractor from 750 points at the same phase after 750 periods; steady"
        " means within a hundredth of its extent at tau = 800, where the figure begins; the largest"
        " distance in the periods up to 1200 is told beside it",
        _settling,
        _judge_settling,
    ),
    Check(
        "M16",
        "six b, from rest: drift at tau = 1200, progression per period and regime over 400 periods"
        " after 600 dropped; the same from 12 other starts",
        _best_drift,
        _judge_best,
    ),
)
