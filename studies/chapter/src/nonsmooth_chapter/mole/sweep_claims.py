"""Claims on diagrams of the mole over the static force: windows, cascades, progression."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram, continue_orbit, simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Evidence, Finding, agreed, agrees
from nonsmooth_chapter.mole.sweeps import (
    AMPLITUDES,
    CHAOTIC,
    PROTOCOLS,
    Sweep,
    at_the_end,
    even_forces,
    first_fifty,
    force_sweep,
    main_window,
    order_of_labels,
    stretches,
    widest,
)

__all__ = ["cascade"]


# Claims on windows of periodic motion over the static force: Figs. 7 and 8(a)-(c).

_COLUMNS = 200


def _windows(
    amplitudes: Sequence[float] = AMPLITUDES,
    columns: int = _COLUMNS,
    protocols: Sequence[str] = PROTOCOLS,
) -> Evidence:
    rows = []
    for a in amplitudes:
        for start in protocols:
            sweep = force_sweep(a, even_forces(a, columns), start)
            parts = stretches(sweep)
            rows.append(
                {
                    "a": a,
                    "start": start,
                    "step": sweep.step,
                    "stretches": parts,
                    "main": widest(parts),
                    "chaotic_share": float(np.mean(sweep.labels == CHAOTIC)),
                    "least_aperiodic": _least_share(sweep),
                    "periodic_share": float(np.mean(sweep.labels > 0)),
                }
            )
    return {"rows": rows}


def _least_share(sweep: Sweep, shortest: float = 0.25) -> list[float]:
    """Least share of aperiodic columns in any range from 0 to part of the sweep, and its end."""
    counts = np.arange(1, sweep.labels.size + 1)
    shares = np.cumsum(sweep.labels <= CHAOTIC) / counts
    long = counts >= shortest * counts[-1]
    return [float(shares[long].min()), float(sweep.b[long][shares[long].argmin()])]


def _lowest() -> Evidence:
    return _windows((0.1,))


def _highest() -> Evidence:
    return _windows((0.9,))


def _listed(rows: list[Evidence], key: str) -> str:
    return ", ".join(f"{row['start']} {row[key]:.3f}" for row in rows)


def _judge_chaos(evidence: Evidence) -> Finding:
    """Columns near a bifurcation may need longer than others to show that they are chaotic."""
    rows = [row | {"aperiodic_share": 1.0 - row["periodic_share"]} for row in evidence["rows"]]
    least = ", ".join(
        f"{row['start']} {row['least_aperiodic'][0]:.3f} (b to {row['least_aperiodic'][1]:.3g})"
        for row in rows
    )
    text = (
        f"share of aperiodic columns in 0 < b <= {rows[0]['a']:g}:"
        f" {_listed(rows, 'aperiodic_share')}; of those with a positive exponent:"
        f" {_listed(rows, 'chaotic_share')}; the range of b is not printed: in any range from 0"
        f" that ends between a/4 and a the aperiodic share is at least {least}; wide means that"
        " more than half are aperiodic in any of them, and most of these chaotic"
    )
    return Finding(
        agreed(
            row["least_aperiodic"][0] > 0.5 and row["chaotic_share"] > 0.5 * row["aperiodic_share"]
            for row in rows
        ),
        text,
    )


def _small_forces(
    amplitudes: Sequence[float] = AMPLITUDES, columns: int = _COLUMNS, fine: int = 600
) -> Evidence:
    """Windows below the main one, on a grid of their own; there a period is all that is asked."""
    rows = []
    for a in amplitudes:
        main = main_window(a, force_sweep(a, even_forces(a, columns)))
        top = main["low"]
        forces = even_forces(top, fine + 1)[:-1]
        diagram = bifurcation_diagram(moling(a=a), "b", forces, transient=300, record=128)
        periods = diagram["period"].values[:, 0]
        edges = np.diff(np.concatenate([[0], periods > 0, [0]]).astype(int))
        widths = np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)
        rows.append(
            {
                "a": a,
                "below": top,
                "windows": int(widths.size),
                "widest": float(widths.max(initial=0) * top / (fine + 1)),
                "main_width": main["high"] - main["low"] + a / columns,
                "periodic_share": float(np.mean(periods > 0)),
            }
        )
    return {"columns": fine, "rows": rows}


def _judge_small_forces(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [
        row["windows"] > 0
        and row["periodic_share"] < 0.5
        and row["widest"] < 0.5 * row["main_width"]
        for row in rows
    ]
    listed = "; ".join(
        f"a {row['a']:g}, b below {row['below']:.4g}: {row['windows']} windows, the widest"
        f" {row['widest']:.2g} (main one {row['main_width']:.3g}), {row['periodic_share']:.1%} of"
        f" {evidence['columns']} columns periodic"
        for row in rows
    )
    failing = [f"{row['a']:g}" for row, each in zip(rows, true, strict=True) if not each]
    return Finding(all(true), listed + (f"; not so at a = {', '.join(failing)}" * bool(failing)))


def _judge_main_window(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    starts = list(dict.fromkeys(row["start"] for row in rows))
    rising = []
    for start in starts:
        widths = [r["main"]["high"] - r["main"]["low"] for r in rows if r["start"] == start]
        rising.append(bool(np.all(np.diff(widths) > 0)))
    listed = "; ".join(
        f"a {row['a']:g} {row['start']} {row['main']['low']:.4g} to {row['main']['high']:.4g}"
        for row in rows
    )
    return Finding(agreed(rising), f"widest periodic window: {listed}")


def _judge_above(evidence: Evidence) -> Finding:
    true, listed = [], []
    for row in evidence["rows"]:
        above = [part for part in row["stretches"] if part["low"] > row["main"]["high"]]
        windows = sum(bool(part["periods"]) for part in above)
        true.append(windows >= 2 and len(above) - windows >= 2)
        listed.append(
            f"a {row['a']:g} {row['start']} {len(above) - windows} aperiodic and {windows} periodic"
        )
    failing = sorted(
        {row["a"] for row, each in zip(evidence["rows"], true, strict=True) if not each}
    )
    text = "stretches above the main window: " + "; ".join(listed)
    if failing:
        text += f"; no series at a = {', '.join(f'{a:g}' for a in failing)}"
    return Finding(all(true), text)


def _judge_most(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    a, low = rows[0]["a"], max(row["main"]["low"] for row in rows)
    text = (
        f"share of periodic columns in 0 < b <= {a:g}: {_listed(rows, 'periodic_share')}; more than"
        f" half for every range from 0 that ends above b = {2.0 * low:.3g}"
    )
    return Finding(agreed(row["periodic_share"] > 0.5 for row in rows), text)


def _judge_from(evidence: Evidence) -> Finding:
    true, listed = [], []
    for row in evidence["rows"]:
        last = row["stretches"][-1]
        from_b = last["low"] if last["periods"] else np.inf
        true.append(agrees(from_b, "0.225", about=0.02, step=row["step"]))
        listed.append(f"{row['start']} {from_b:.4g}")
    text = (
        f"every column up to b = {evidence['rows'][0]['a']:g} is periodic from b ="
        f" {', '.join(listed)}; allowed 2 % or a step of {evidence['rows'][0]['step']:.3g}"
    )
    return Finding(agreed(true), text)


def _order(first: float = 0.095, last: float = 0.19, columns: int = 96) -> Evidence:
    forces = tuple(np.linspace(first, last, columns).round(12).tolist())
    rows = []
    for start in PROTOCOLS:
        sweep = force_sweep(0.3, forces, start)
        chaos = np.flatnonzero(sweep.labels == CHAOTIC)
        rows.append(
            {
                "start": start,
                "order": order_of_labels(sweep),
                "chaos_from": float(sweep.b[chaos[0]]) if chaos.size else None,
                "stretches": stretches(sweep),
            }
        )
    return {"rows": rows}


def _judge_order(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [row["order"][:4] == [4, 2, 1, CHAOTIC] for row in rows]
    listed = "; ".join(
        f"{row['start']} {' '.join(str(label) if label else 'chaos' for label in row['order'])}"
        for row in rows
    )
    return Finding(agreed(true), f"periods in order of b: {listed}; the first four decide")


# Claim on the period halvings of Fig. 7: on which side of each flip the doubled orbit lies.

_RANGE = (0.09, 0.2)
_NEAR = 1e-3  # of b, from the flip, within which the doubled orbit tells


@lru_cache(maxsize=1)
def cascade(doublings: int = 2) -> tuple[xr.Dataset, ...]:
    """Branches of period one, two, ... over b for the other parameters of Fig. 7.

    Parameters
    ----------
    doublings : int, optional
        How many times to change to the doubled orbit.

    Returns
    -------
    tuple of xarray.Dataset

    Examples
    --------
    >>> [branch.attrs["period"] for branch in cascade()]
    [1, 2, 4]
    """
    mole = moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    branches = [continue_orbit(mole, "b", _RANGE)]
    for _ in range(doublings):
        last = branches[-1]
        flip = int(np.flatnonzero(last["special_kind"].values == "flip")[0])
        branches.append(continue_orbit(mole, "b", _RANGE, initial=last, special=flip))
    return tuple(branches)


def _flips(reach: float = 2e-3, points: int = 17) -> Evidence:
    branches = cascade()
    rows = []
    for single, double in pairwise(branches):
        k = int(np.flatnonzero(single["special_kind"].values == "flip")[0])
        flip, place = float(single["special_value"][k]), int(single["special_point"][k])
        near = np.abs(double["b"].values - flip) < _NEAR
        near &= np.abs(double["b"].values - flip) > 1e-9  # not the flip itself
        rows.append(
            {
                "period": int(single.attrs["period"]),
                "b": flip,
                "doubled_points": int(near.sum()),
                "doubled_below": int((double["b"].values[near] < flip).sum()),
                "doubled_stable": int(double["stable"].values[near].sum()),
                "single_stable": _beside(single, place, flip),
                **_normal_form(single.isel(point=place), flip, reach, points),
            }
        )
    return {"rows": rows}


def _beside(branch: xr.Dataset, place: int, flip: float) -> dict[str, bool]:
    """Whether the orbits next to a flip are stable, below and above it."""
    sides = {}
    for k in (place - 1, place + 1):
        side = "below" if float(branch["b"][k]) < flip else "above"
        sides[side] = bool(branch["stable"][k])
    return sides


def _normal_form(orbit: xr.Dataset, b: float, reach: float, points: int) -> Evidence:
    """Derivatives of the return map along its one direction, by a polynomial through motions.

    The phases of a turn contract all other directions to nothing, so that from the first return
    on motions lie on a curve, and the map is one of the velocity alone.
    """
    mole = moling(b=b)
    turns = round(float(orbit["length"]) / (2.0 * np.pi / mole.parameter_values["omega"]))
    middle = {name: float(orbit[name]) for name in "pyq"}
    steps = reach * np.cos(np.pi * (np.arange(points) + 0.5) / points)
    before, behind = [], []
    for step in steps:
        start = {**middle, "y": middle["y"] + step}
        run = simulate(
            mole, start, periods=2 * turns, samples_per_period=1, events=False, mode=_mode(orbit)
        )
        before.append(float(run["y"][turns]))
        behind.append(float(run["y"][2 * turns]))
    away = np.array(before) - middle["y"]
    scale = np.abs(away).max()
    fit = np.polynomial.Polynomial.fit(away / scale, np.array(behind) - middle["y"], 6)
    first, second, third = (float(fit.deriv(n)(0.0)) / scale**n for n in (1, 2, 3))
    return {"slope": float(first), "coefficient": float(0.5 * second**2 + third / 3.0)}


def _mode(orbit: xr.Dataset) -> str:
    names = orbit["leg_mode"].attrs["flag_meanings"].split()
    return str(names[int(orbit["leg_mode"].values[0])])


def _judge_flips(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    by_branch = [row["doubled_stable"] == 0 for row in rows]  # subcritical: unstable
    by_form = [row["coefficient"] < 0.0 for row in rows]
    listed = "; ".join(
        f"{2 * row['period']} to {row['period']} at b = {row['b']:.9f}: the orbit of twice the"
        f" period lies below it at {row['doubled_below']} of {row['doubled_points']} places and is"
        f" stable at {row['doubled_stable']}, the single one is unstable"
        f" {' and '.join(side for side, stable in row['single_stable'].items() if not stable)};"
        " slope of the return map"
        f" {row['slope']:.4f}, coefficient {row['coefficient']:+.3g}"
        for row in rows
    )
    true = all(by_branch) and all(by_form)
    text = "" if true else "; supercritical: read with b falling, stable orbits of twice the period"
    return Finding(true, listed + text)


# Claims on the best progression over static force and amplitude: Figs. 7 and 8(d)-(f).

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
    low = main_window(a, force_sweep(a, forces))["low"]
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
