"""The best orbit of a branch: the best of its points, then the extremum between its neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.orbit_search.best_options import WantedBest
from nonsmooth.analysis.orbit_search.extremum import largest_inside
from nonsmooth.analysis.orbit_search.orbits_between import OrbitsBetween, orbit_of_point

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Best", "best_along"]

Floats = npt.NDArray[np.float64]

_WITHIN = ("flip", "torus", "branch_point")  # points that unstable orbits pass smoothly
_AT_END = 1e-7  # part of the distance of two points within which an extremum is at a special point
_REFINED = 3  # runs of allowed points that are looked at between their points


@dataclass(frozen=True)
class Best:
    """The orbit that is best, as a dataset."""

    orbit: xr.Dataset
    value: float  # of the parameter
    quantity: float
    limited_by: str


@dataclass(frozen=True)
class _Run:
    """Points in a row that are allowed, special ones at most at its ends."""

    points: list[int]
    before: str  # what limits it there
    after: str


def best_along(wanted: WantedBest) -> Best | str:
    """Best orbit among those that are allowed; where there are none, why."""
    branch = wanted.branch
    values = wanted.sign * _values(wanted)
    specials = {
        int(place): str(kind)
        for place, kind in zip(
            branch["special_point"].values, branch["special_kind"].values, strict=True
        )
        if not (wanted.unstable and str(kind) in _WITHIN)
    }
    runs = _runs(wanted, values, specials)
    if not runs:
        return _why_none(wanted, values)

    def best_of(run: _Run) -> float:
        return float(np.nanmax(values[run.points]))

    runs = sorted(runs, key=best_of, reverse=True)[:_REFINED]
    found = [_refined(wanted, run, values) for run in runs]
    return max(found, key=lambda each: wanted.sign * each.quantity)


def _why_none(wanted: WantedBest, values: Floats) -> str:
    """What is wrong with all points of a branch."""
    if not np.any(np.isfinite(values)):
        return (
            "the quantity is nowhere a number along the branch: it is nan or infinite at each of"
            f" its {len(values)} points; give another variable, or a function that is finite"
        )
    free = (("stable", wanted.unstable), ("a motion", wanted.inadmissible))
    allowed = " and ".join(word for word, given in free if not given) or "no special point"
    finite = "" if np.all(np.isfinite(values)) else ", with a quantity that is a number"
    return (
        f"none of the {len(values)} orbits of the branch is {allowed}{finite};"
        " follow it further, or allow others: unstable=True, inadmissible=True"
    )


def _values(wanted: WantedBest) -> Floats:
    branch = wanted.branch
    if isinstance(wanted.quantity, str):
        return np.asarray(branch[wanted.quantity].values, float)
    return np.array(
        [wanted.quantity(orbit_of_point(branch, k)) for k in range(branch.sizes["point"])], float
    )


def _runs(wanted: WantedBest, values: Floats, specials: dict[int, str]) -> list[_Run]:
    branch = wanted.branch
    allowed = np.isfinite(values)
    if not wanted.unstable:
        allowed &= branch["stable"].values
    if not wanted.inadmissible:
        allowed &= branch["admissible"].values
    last = len(values) - 1
    runs, begin = [], 0
    while begin <= last:
        if begin in specials or not allowed[begin]:
            begin += 1
            continue
        end = begin
        while end < last and end + 1 not in specials and allowed[end + 1]:
            end += 1
        points = list(range(begin, end + 1))
        reasons = []
        for outer, edge in ((begin - 1, "end_first"), (end + 1, "end_last")):
            if 0 <= outer <= last and outer in specials and np.isfinite(values[outer]):
                points.append(outer)
                reasons.append(specials[outer])
            elif 0 <= outer <= last:
                reasons.append(
                    "stability" if branch["admissible"].values[outer] else "inadmissible"
                )
            else:
                reasons.append(str(branch.attrs[edge]))
        runs.append(_Run(sorted(points), *reasons))
        begin = end + 1
    return runs


def _refined(wanted: WantedBest, run: _Run, values: Floats) -> Best:
    """The extremum beside the best point of a run."""
    branch, points = wanted.branch, run.points
    parameter = branch[wanted.parameter].values
    k = int(np.nanargmax(values[points]))
    sides = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
    low, high = sorted(sides, key=lambda each: float(parameter[each]))
    a, b = float(parameter[low]), float(parameter[high])
    if not a < b or wanted.quantity == wanted.parameter:
        return _at_point(wanted, points[k], values, _limit(run, points[k]))
    between = OrbitsBetween(wanted, [points[k], *sides])
    ends = float(values[low]), float(values[high])
    found = largest_inside(lambda p: wanted.sign * between.quantity(p), a, b, ends)
    for place, end in ((low, a), (high, b)):
        near = _AT_END * (b - a) if place in _special_ends(wanted, run) else 0.0
        if abs(found.place - end) <= near:
            return _at_point(wanted, place, values, _limit(run, place))
    orbit = between.dataset(found.place)
    if orbit is None or not found.value > values[points[k]]:
        inner = 0 < k < len(points) - 1
        limit = "interior" if inner else _limit(run, points[k])
        return _at_point(wanted, points[k], values, limit)
    return Best(orbit, found.place, wanted.sign * found.value, "interior")


def _special_ends(wanted: WantedBest, run: _Run) -> list[int]:
    chosen = wanted.branch["special_point"].values
    return [each for each in (run.points[0], run.points[-1]) if each in chosen]


def _limit(run: _Run, point: int) -> str:
    if point == run.points[0]:
        return run.before
    return run.after if point == run.points[-1] else "interior"


def _at_point(wanted: WantedBest, point: int, values: Floats, limit: str) -> Best:
    """A point of the branch as it is."""
    branch: Any = wanted.branch
    value = float(branch[wanted.parameter].values[point])
    return Best(orbit_of_point(branch, point), value, wanted.sign * float(values[point]), limit)
