"""Claims on the best progression over static force and amplitude: Figs. 7 and 8(d)-(f)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import bifurcation_diagram
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed
from nonsmooth_chapter.mole.cascade_claims import cascade
from nonsmooth_chapter.mole.static_force_sweeps import (
    AMPLITUDES,
    CHAOTIC,
    PROTOCOLS,
    even_forces,
    first_fifty,
    force_sweep,
)
from nonsmooth_chapter.mole.windows import at_the_end, stretches, widest

__all__ = ["CHECKS"]

_COLUMNS = 200
_PROTOCOL = (
    f"xi .05, omega .1, b from a/{_COLUMNS} to a in {_COLUMNS} columns (range not printed); first"
    " 50 periods from rest, beside settled progression by restart from rest and follow up and down"
    " (600 periods dropped, 128 kept)"
)
_GRID = tuple(round(0.1 * k, 1) for k in range(1, 11))


def _end_of_best(columns: int = _COLUMNS) -> Evidence:
    rows = []
    for start in PROTOCOLS:
        sweep = force_sweep(0.3, even_forces(0.3, columns), start)
        window = widest(stretches(sweep))
        ones = (sweep.labels == 1) & (sweep.b >= window["low"]) & (sweep.b <= window["high"])
        last = int(np.flatnonzero(ones)[-1])
        best = int(sweep.per_period.argmax())
        rows.append(
            {
                "start": start,
                "interval": [float(sweep.b[ones][0]), float(sweep.b[last])],
                "next_label": int(sweep.labels[last + 1]),
                "before": float(sweep.per_period[last]),
                "after": float(sweep.per_period[last + 1]),
                "best_above": float(sweep.per_period[last + 1 :].max()),
                "best_b": float(sweep.b[best]),
                "best": float(sweep.per_period[best]),
            }
        )
    return {"rows": rows, "step": 0.3 / columns, "branch": _end_of_branch()}


def _end_of_branch() -> Evidence:
    """Where the period-one orbit of Fig. 7(d) ends as b rises, and its best progression."""
    branch = cascade()[0]
    kinds, places = branch["special_kind"].values, branch["special_point"].values
    fold = int(places[kinds == "fold"][0])
    solid = np.asarray(branch["stable"].values & branch["admissible"].values, bool)
    best = int(np.where(solid, branch["v_per_period"].values, -np.inf).argmax())
    return {
        "end": float(branch["b"][fold]),
        "stable_before": bool(solid[fold - 2]),
        "stable_behind": bool(solid[fold + 2]),
        "at_end": float(branch["v_per_period"][fold]),
        "best_b": float(branch["b"][best]),
        "best": float(branch["v_per_period"][best]),
    }


def _judge_end_of_best(evidence: Evidence) -> Finding:
    rows, branch = evidence["rows"], evidence["branch"]
    # columns end within 2 % or a step of the fold, and what is best on the branch is best of all
    ends = branch["stable_before"] and not branch["stable_behind"]
    true = [
        row["next_label"] == CHAOTIC
        and row["after"] < row["before"]
        and row["best_above"] < row["before"]
        and row["interval"][0] <= row["best_b"] <= row["interval"][1]
        and ends
        and at_the_end(row["interval"][1], {"high": branch["end"]}, evidence["step"])
        and row["best_above"] < branch["best"]
        for row in rows
    ]
    text = (
        f"the branch of the orbit ends in a fold at b = {branch['end']:.9f}, progression per period"
        f" {branch['at_end']:.3f} there and {branch['best']:.3f} at most, at b ="
        f" {branch['best_b']:.4f}; "
    )
    listed = "; ".join(
        f"{row['start']}: period one for b from {row['interval'][0]:.4g} to"
        f" {row['interval'][1]:.4g}, progression per period {row['before']:.2f} at its end,"
        f" {row['after']:.2f} behind it ({row['best_above']:.2f} at most up to b = 0.3), best"
        f" {row['best']:.2f} at b = {row['best_b']:.4g}"
        for row in rows
    )
    return Finding(agreed(true), text + listed)


def _best(a: float = 0.1, columns: int = _COLUMNS) -> Evidence:
    forces = even_forces(a, columns)
    rows = []
    for start in PROTOCOLS:
        sweep = force_sweep(a, forces, start)
        window = widest(stretches(sweep))
        if start == "restart":
            rows.append(_maximum("first 50", 1.0, forces, first_fifty(a, forces), window))
        rows.append(_maximum(start, 50.0, forces, sweep.per_period, window))
    return {"a": a, "step": a / columns, "rows": rows}


def _maximum(
    name: str, factor: float, forces: Sequence[float], values: np.ndarray, window: Evidence
) -> Evidence:
    best = int(values.argmax())
    return {
        "reading": name,
        "best_b": float(forces[best]),
        "best": factor * float(values[best]),
        "window": window,
        "ends": window["high"] < forces[-1],
    }


def _best_middle() -> Evidence:
    return _best(0.3)


def _best_large() -> Evidence:
    return _best(0.9)


def _said_best(evidence: Evidence) -> str:
    return "; ".join(
        f"{row['reading']}: {row['best']:.5g} in 50 periods at b = {row['best_b']:.4g}, window"
        f" {row['window']['low']:.4g} to {row['window']['high']:.4g}"
        + ("" if row["ends"] else " without an end")
        for row in evidence["rows"]
    )


def _judge_best(evidence: Evidence) -> Finding:
    true = [
        row["ends"] and at_the_end(row["best_b"], row["window"], evidence["step"])
        for row in evidence["rows"]
    ]
    return Finding(agreed(true), _said_best(evidence) + "; within 2 % or a step")


def _judge_best_or_special(evidence: Evidence) -> Finding:
    true = [
        not row["ends"] or at_the_end(row["best_b"], row["window"], evidence["step"])
        for row in evidence["rows"]
    ]
    special = all(not row["ends"] for row in evidence["rows"])
    text = "; the special case: the window does not end up to b = a" if special else ""
    return Finding(agreed(true), _said_best(evidence) + text)


def _rise(a: float = 0.9, columns: int = _COLUMNS) -> Evidence:
    forces = even_forces(a, columns)
    b, values = np.array(forces), first_fifty(a, forces)
    low = widest(stretches(force_sweep(a, forces)))["low"]
    beyond = b >= low
    b, values = b[beyond], values[beyond]
    falls = np.flatnonzero(np.diff(values) <= 0)
    return {
        "from": float(low),
        "first": float(values[0]),
        "rises_to": float(b[falls[0]]) if falls.size else float(b[-1]),
        "peak": float(values[falls[0]]) if falls.size else float(values[-1]),
        "falls_until": float(b[falls[-1] + 1]) if falls.size else None,
        "least_after": float(values[falls[-1] + 1]) if falls.size else None,
        "last": [float(b[-1]), float(values[-1])],
    }


def _judge_rise(evidence: Evidence) -> Finding:
    text = (
        f"in 50 periods from rest it rises from {evidence['first']:.0f} at b ="
        f" {evidence['from']:.4g} to {evidence['peak']:.0f} at b = {evidence['rises_to']:.4g}"
    )
    if evidence["falls_until"] is None:
        return Finding(True, text)
    text += (
        f", falls to {evidence['least_after']:.0f} at b = {evidence['falls_until']:.4g} and is"
        f" {evidence['last'][1]:.0f} at b = {evidence['last'][0]:.4g}; the chapter does not print"
        f" the range of b of Fig. 8(f): true of every range that ends below"
        f" {evidence['rises_to']:.4g}, false of every one that ends above"
    )
    # at once there is no range left in which it could rise
    return Finding(None if evidence["rises_to"] > evidence["from"] else False, text)


def _falls(amplitudes: Sequence[float] = AMPLITUDES, columns: int = _COLUMNS) -> Evidence:
    rows = []
    for a in amplitudes:
        forces = even_forces(a, columns)
        readings = {"first 50": first_fifty(a, forces)} | {
            start: 50.0 * force_sweep(a, forces, start).per_period for start in PROTOCOLS
        }
        for name, values in readings.items():
            fall = np.maximum.accumulate(values) - values
            rows.append(
                {
                    "a": a,
                    "reading": name,
                    "largest_fall": float(fall.max()),
                    "at": float(forces[int(fall.argmax())]),
                    "share": float(fall.max() / values.max()),
                }
            )
    return {"rows": rows}


def _judge_falls(evidence: Evidence) -> Finding:
    listed = "; ".join(
        f"a {row['a']:g} {row['reading']}: {row['share']:.0%} of the maximum at b = {row['at']:.4g}"
        for row in evidence["rows"]
    )
    true = [row["share"] > 0.01 for row in evidence["rows"]]
    return Finding(agreed(true), f"largest fall below the best of all lower b: {listed}")


def _best_regimes(
    amplitudes: Sequence[float] = _GRID,
    columns: int = 60,
    protocols: Sequence[str] = PROTOCOLS,
) -> Evidence:
    rows = []
    for a in amplitudes:
        for start in protocols:
            diagram = bifurcation_diagram(
                moling(a=a), "b", even_forces(min(a, 0.95), columns), start=start,
                transient=300, record=100,
            )  # fmt: skip
            gain = diagram["v_per_period"].values[:, 0]
            best = int(gain.argmax())
            rows.append(
                {
                    "a": a,
                    "start": start,
                    "b": float(diagram["parameter"][best]),
                    "per_period": float(gain[best]),
                    "period": int(diagram["period"][best, 0]),
                }
            )
    return {"rows": rows}


def _judge_best_regimes(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [row["period"] == 1 for row in rows]
    best = max(rows, key=lambda row: row["per_period"])
    listed = ", ".join(
        f"a {row['a']:g} {row['per_period']:.3g} at b {row['b']:.3g}"
        f" (period {row['period'] or 'none'})"
        for row in rows
        if row["start"] == "restart"
    )
    text = (
        f"best progression per period, restart: {listed}; period one in {sum(true)} of {len(rows)}"
        f" with follow up and down; over the plane {best['per_period']:.4g} at a = {best['a']:g},"
        f" b = {best['b']:.3g} (period {best['period'] or 'none'})"
    )
    return Finding(all(true), text)


CHECKS = (
    Check(
        "M17", _PROTOCOL + "; the branch of the orbit beside it", _end_of_best, _judge_end_of_best
    ),
    Check("M24", _PROTOCOL, _rise, _judge_rise),
    Check("M25", _PROTOCOL, _best, _judge_best),
    Check("M26", _PROTOCOL, _best_middle, _judge_best),
    Check("M27", _PROTOCOL, _best_large, _judge_best_or_special),
    Check("M28", _PROTOCOL + "; a fall counts from 1 % of the maximum", _falls, _judge_falls),
    Check(
        "M29",
        "xi .05, omega .1, a from .1 to 1 in steps of .1, b in 60 columns up to a (at most .95),"
        " restart from rest and follow up and down, 300 periods dropped, 100 kept",
        _best_regimes,
        _judge_best_regimes,
    ),
)
