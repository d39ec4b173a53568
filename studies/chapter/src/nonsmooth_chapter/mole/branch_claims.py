"""Claims on Fig. 10: progression along branches of period-one orbits.

The chapter prints neither the amplitudes nor the static forces of the curves, so each claim is
judged for every one of those stated here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import xarray as xr

from nonsmooth import regime
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agreed
from nonsmooth_chapter.mole.orbit_branches import (
    best_stable,
    first_sheet,
    four_phase_branch,
    observed,
)

__all__ = ["CHECKS"]

_BY_OMEGA = (0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6)  # those with stable orbits at b = 0.15
_BY_A = (0.1, 0.15, 0.2, 0.25, 0.3)
_BY_B = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
_OMEGAS, _AMPLITUDES = (0.03, 0.5), (0.05, 1.0)
_CLOSE = 0.1  # of b: how near the end of the branch "close" is
# A curve has one value for each parameter: it is the sheet between folds on which the branch began.
_READINGS: dict[str, Callable[[xr.Dataset], np.ndarray]] = {
    "stable": observed,
    "every motion": lambda branch: np.asarray(branch["admissible"].values, bool),
}


def _slopes(
    parameter: str, between: tuple[float, float], curve: str, values: Sequence[float]
) -> Evidence:
    """Part of the range of a parameter on which progression rises along each branch."""
    rows = []
    for value in values:
        branch = first_sheet(four_phase_branch(parameter, between, **{curve: value}))
        x, y = branch[parameter].values, branch["v_per_period"].values
        for reading, chosen in _READINGS.items():
            inside = chosen(branch)
            both = inside[1:] & inside[:-1] & (np.diff(x) != 0.0)
            lengths = np.abs(np.diff(x)[both])
            slopes = np.diff(y)[both] / np.diff(x)[both]
            rows.append(
                {
                    "value": value,
                    "reading": reading,
                    "steps": int(both.sum()),
                    "rising": float(lengths[slopes > 0.0].sum() / lengths.sum())
                    if slopes.size
                    else None,
                    "slopes": [float(slopes.min()), float(slopes.max())] if slopes.size else None,
                    "from": float(x[inside].min()) if inside.any() else None,
                    "to": float(x[inside].max()) if inside.any() else None,
                }
            )
    return {"over": parameter, "curve": curve, "rows": rows}


def _judge_slopes(rising: bool) -> Callable[[Evidence], Finding]:
    def judge(evidence: Evidence) -> Finding:
        rows = [row for row in evidence["rows"] if row["steps"]]
        true = [row["rising"] == float(rising) for row in rows]
        over, curve = evidence["over"], evidence["curve"]
        values = sorted({row["value"] for row in rows})
        listed = "; ".join(
            f"{curve} {row['value']:g} {row['reading']} {over} {row['from']:.4g} to"
            f" {row['to']:.4g}: {row['slopes'][0]:.3g} to {row['slopes'][1]:.3g} per unit of"
            f" {over}, rising on {row['rising']:.1%} of it"
            for row in rows
        )
        found = agreed(true)
        return Finding(found, listed, for_all=_each(found, curve, values))

    return judge


def _each(found: bool | None, name: str, values: Sequence[float]) -> str:
    """Range of the missing data for which a finding was shown, value by value."""
    if found is None:
        return ""
    return f"{name} = {', '.join(f'{value:g}' for value in values)}, each with its own branch"


def _order(
    parameter: str, between: tuple[float, float], curve: str, values: Sequence[float]
) -> Evidence:
    """Least gain from one curve to the next at the same parameter, where both are there."""
    grid = np.linspace(*between, 400)
    rows = []
    for reading, chosen in _READINGS.items():
        heights = {v: _upper(parameter, between, curve, v, grid, chosen) for v in values}
        for low, high in pairwise(values):
            gain = heights[high] - heights[low]
            common = np.isfinite(gain)
            rows.append(
                {
                    "reading": reading,
                    "low": low,
                    "high": high,
                    "common": int(common.sum()),
                    "least_gain": float(gain[common].min()) if common.any() else None,
                    "range": [float(grid[common].min()), float(grid[common].max())]
                    if common.any()
                    else None,
                }
            )
    return {"over": parameter, "curve": curve, "values": list(values), "rows": rows}


def _upper(
    parameter: str, between: tuple[float, float], curve: str, value: float, grid: np.ndarray,
    chosen: Callable[[xr.Dataset], np.ndarray],
) -> np.ndarray:  # fmt: skip
    """Progression of the chosen orbits of a sheet at each value of a grid, nan without one."""
    branch = first_sheet(four_phase_branch(parameter, between, **{curve: value}))
    x, y, inside = branch[parameter].values, branch["v_per_period"].values, chosen(branch)
    best = np.full(grid.size, np.nan)
    for k in np.flatnonzero(inside[1:] & inside[:-1]):
        (low, first), (high, second) = sorted([(x[k], y[k]), (x[k + 1], y[k + 1])])
        here = (grid >= low) & (grid <= high)
        if high > low and here.any():
            best[here] = np.fmax(best[here], np.interp(grid[here], [low, high], [first, second]))
    return best


def _judge_order(evidence: Evidence) -> Finding:
    rows = [row for row in evidence["rows"] if row["common"]]
    true = [row["least_gain"] > 0.0 for row in rows]
    curve = evidence["curve"]
    listed = "; ".join(
        f"{curve} {row['high']:g} above {row['low']:g} ({row['reading']},"
        f" {evidence['over']} {row['range'][0]:.3g} to {row['range'][1]:.3g}) by"
        f" {row['least_gain']:.3g} at least"
        for row in rows
    )
    found = agreed(true)
    return Finding(found, listed, for_all=_each(found, curve, evidence["values"]))


def _maxima(amplitudes: Sequence[float] = _BY_B) -> Evidence:
    """Maximum of progression over b inside the stable part of each branch, and where that ends."""
    rows = []
    for a in amplitudes:
        branch = four_phase_branch("b", (0.02, a), a=a)
        b, gain, solid = branch["b"].values, branch["v_per_period"].values, observed(branch)
        k = best_stable(branch)
        inner = (gain[1:-1] > gain[:-2]) & (gain[1:-1] > gain[2:]) & solid[1:-1]
        end = k
        while end + 1 < b.size and solid[end + 1]:
            end += 1
        while end - 1 >= 0 and solid[end - 1] and b[end - 1] > b[end]:
            end -= 1
        near = branch["special_kind"].values[np.abs(branch["special_point"].values - end) <= 1]
        rows.append(
            {
                "a": a,
                "at": float(b[k]),
                "per_period": float(gain[k]),
                "inner_maxima": [float(each) for each in b[1:-1][inner]],
                "end": float(b[end]),
                "ends_in": str(near[0]) if near.size else "guard",
                "at_end": float(gain[end]),
            }
        )
    return {"rows": rows}


def _judge_maxima(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [bool(row["inner_maxima"]) for row in rows]
    listed = "; ".join(
        f"a {row['a']:g}: {row['per_period']:.4g} at b = {row['at']:.4f}" + _inner(row)
        for row in rows
    )
    found = agreed(true)
    return Finding(found, f"largest along the stable part, b up to a: {listed}",
                   for_all=_each(found, "a", [row["a"] for row in rows]))  # fmt: skip


def _inner(row: Evidence) -> str:
    if not row["inner_maxima"]:
        return " (at the end, no maximum inside)"
    if min(abs(each - row["at"]) for each in row["inner_maxima"]) > 1e-9:
        return f" (at the end; a maximum inside at {row['inner_maxima'][0]:.4f})"
    return ""


def _judge_breakdown(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = [
        row["ends_in"] != "bound" and abs(row["end"] - row["at"]) <= _CLOSE * row["end"]
        for row in rows
    ]
    listed = "; ".join(
        f"a {row['a']:g}: best at b = {row['at']:.4f}, "
        + (
            "stable up to b = a"
            if row["ends_in"] == "bound"
            else f"ends at {row['end']:.4f} ({row['ends_in']}), {1.0 - row['at'] / row['end']:.1%}"
            " further"
        )
        for row in rows
    )
    found = agreed(true)
    return Finding(found, f"{listed}; close: within {_CLOSE:.0%} of b",
                   for_all=_each(found, "a", [row["a"] for row in rows]))  # fmt: skip


def _dashed(amplitudes: Sequence[float] = _BY_B, per_part: int = 4) -> Evidence:
    """Regimes from rest and from the construction, at some places of the dashed parts.

    A curve of the figure has one value for each b, so the sheets behind folds are left out.
    """
    rows = []
    for a in amplitudes:
        branch = first_sheet(four_phase_branch("b", (0.02, a), a=a))
        b, solid = branch["b"].values, observed(branch)
        top = float(b[solid].max())
        for part, inside in {
            "below the stable part": ~solid & (b < b[solid].min()),
            "beside it": ~solid & (b >= b[solid].min()) & (b <= top),
            "above it": ~solid & (b > top),
        }.items():
            places = np.flatnonzero(inside)
            if not places.size:
                continue
            chosen = places[np.linspace(0, places.size - 1, per_part + 2).astype(int)[1:-1]]
            periods = [_periods_at(branch.isel(point=int(k)), a) for k in np.unique(chosen)]
            rows.append(
                {
                    "a": a,
                    "part": part,
                    "places": len(periods),
                    "admissible": int(branch["admissible"].values[np.unique(chosen)].sum()),
                    "periodic_from_rest": sum(bool(rest) for rest, _ in periods),
                    "periodic_from_orbit": sum(bool(orbit) for _, orbit in periods),
                }
            )
    return {"rows": rows}


def _periods_at(orbit: xr.Dataset, a: float) -> tuple[int, int]:
    system = moling(a=a, b=float(orbit["b"]), xi=0.01)
    start = {name: float(orbit["leg_states"][0].sel(state=name)) for name in "py"}
    start["q"] = max(0.0, start["p"] - system.parameter_values["g"])
    return int(regime(system)["period"]), int(regime(system, start)["period"])


def _judge_dashed(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    readings = {
        "from rest": [row["periodic_from_rest"] == 0 for row in rows],
        "from the construction": [row["periodic_from_orbit"] == 0 for row in rows],
    }
    listed = "; ".join(
        f"a {row['a']:g} {row['part']}: {row['places'] - row['periodic_from_rest']} of"
        f" {row['places']} not periodic from rest"
        f" ({row['places'] - row['periodic_from_orbit']} from the construction;"
        f" {row['admissible']} constructions are motions)"
        for row in rows
    )
    by_amplitude = [
        all(each for each, row in zip(true, rows, strict=True) if row["a"] == a)
        for true in readings.values()
        for a in dict.fromkeys(row["a"] for row in rows)
    ]
    found = agreed(by_amplitude)
    return Finding(found, listed,
                   for_all=_each(found, "a", sorted({row["a"] for row in rows})))  # fmt: skip


_ON = (
    "period-one orbits with the four phases of Fig. 9 on their branch, xi .01; stable ones, and all"
    " that are motions"
)

CHECKS = (
    Check("M35", f"{_ON}, between folds; b .15, omega from .03 to .5",
          lambda: _slopes("omega", _OMEGAS, "a", _BY_OMEGA), _judge_slopes(rising=False)),
    Check("M36", f"{_ON}, between folds; b .15, omega from .03 to .5",
          lambda: _order("omega", _OMEGAS, "a", _BY_OMEGA), _judge_order),
    Check("M37", f"{_ON}, between folds; omega .1, a from .05 to 1",
          lambda: _slopes("a", _AMPLITUDES, "b", _BY_A), _judge_slopes(rising=True)),
    Check("M38", f"{_ON}, between folds; omega .1, a from .05 to 1",
          lambda: _order("a", _AMPLITUDES, "b", _BY_A), _judge_order),
    Check("M39", f"{_ON}; omega .1, b from .02 to a", _maxima, _judge_maxima),
    Check("M40", f"{_ON}; omega .1, b from .02 to a; from the best stable orbit to the end of the"
          " stable part", _maxima, _judge_breakdown),
    Check("M41", f"{_ON}, between folds; omega .1, b from .02 to a; regime from rest and from the"
          " orbit, at four places of each dashed part", _dashed, _judge_dashed),
)  # fmt: skip
