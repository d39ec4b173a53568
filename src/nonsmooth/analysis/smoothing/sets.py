"""Smoothed attractors and branches beside the exact ones."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.attractors import attractors
from nonsmooth.analysis.basins.region import read_box
from nonsmooth.analysis.continue_orbit import continue_orbit
from nonsmooth.analysis.orbit_search.branches import read_bounds
from nonsmooth.analysis.smoothing.motions import Ladder
from nonsmooth.errors import OptionError, RunWarning, is_known, unknown_name
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["compared_attractors", "compared_branches", "read_branches", "read_sets"]

_MOST = 1000  # points of one attractor that are compared

Floats = npt.NDArray[np.float64]

# those that branches of smooth systems have too; others are of an event
SMOOTH = ("fold", "flip", "torus", "symmetry_breaking", "branch_point")


@dataclass(frozen=True)
class Sets:
    """Where attractors are searched for, and which are the same."""

    region: dict[str, tuple[float, float]]
    starts: int
    near: float


@dataclass(frozen=True)
class Branches:
    """What is followed."""

    parameter: str
    between: tuple[float, float]
    period: int


def read_sets(system: System, region: Any, starts: Any, near: Any) -> Sets | None:
    """Check the options of the search for attractors; None where there is none."""
    count, distance = whole_number("starts", starts), finite_number("near", near)
    if not distance > 0.0:
        raise OptionError(f"near = {distance:g} must be positive")
    if region is None:
        return None
    read_box(system, region, None)  # refused here, before the motions are compared
    return Sets(dict(region), count, distance)


def read_branches(system: System, parameter: Any, between: Any, period: Any) -> Branches | None:
    """Check the options of the branches; None where there are none."""
    count = whole_number("period", period)
    if (parameter is None) != (between is None):
        raise OptionError("give both parameter= and between=, or neither")
    if parameter is None:
        return None
    if not is_known(parameter, system.parameters):
        raise OptionError(unknown_name("parameter", parameter, system.parameters))
    low, high = read_bounds(between)
    value = float(system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the orbit is found at {parameter} = {value:g}, which"
            " lies outside; give a range around it, or another value by parameters="
        )
    return Branches(parameter, (low, high), count)


def compared_attractors(ladder: Ladder, sets: Sets, tolerance: float) -> dict[str, Any]:
    """Variables of the report that come from attractors."""

    def found(system: System) -> list[Any]:
        result = attractors(system, sets.region, samples=sets.starts, tolerance=tolerance)
        return point_sets(system, result)

    exact = found(ladder.exact)
    numbers = np.zeros((3, ladder.epsilons.size), np.int64)
    for i, epsilon in enumerate(ladder.epsilons):
        soft = found(ladder.at(epsilon))
        spread = spread_of(exact + soft, ladder.exact, sets.region)
        numbers[:, i] = (
            len(soft),
            far_from_all(soft, exact, spread, sets.near),
            far_from_all(exact, soft, spread, sets.near),
        )
    return {
        "attractors_exact": ((), len(exact)),
        "attractors": ("epsilon", numbers[0]),
        "only_smoothed": ("epsilon", numbers[1]),
        "only_exact": ("epsilon", numbers[2]),
    }


def compared_branches(
    ladder: Ladder,
    branches: Branches,
    run: xr.Dataset,
    runs: list[xr.Dataset],
    tolerance: float,
) -> dict[str, Any]:
    """Variables of the report that come from branches of orbits."""
    count = ladder.epsilons.size
    exact = specials_of(_branch(ladder.exact, branches, run, tolerance))
    values = np.full((count, len(exact)), np.nan)
    extra, width = np.zeros(count, np.int64), np.full(count, np.nan)
    for i, (epsilon, soft) in enumerate(zip(ladder.epsilons, runs, strict=True)):
        if soft.attrs["status"] != "completed":
            continue
        branch = _branch(ladder.at(epsilon), branches, soft, tolerance)
        values[i], left = matched(exact, specials_of(branch))
        extra[i] = left.size
        width[i] = np.ptp(left) if left.size > 1 else np.nan
    there = np.array([one.value for one in exact], float)
    over = ("epsilon", "special")
    return {
        "special_kind": ("special", np.array([one.kind for one in exact], str)),
        "special_value_exact": ("special", there),
        "special_value": (over, values),
        "special_shift": (over, values - there),
        "extra_specials": ("epsilon", extra),
        "extra_width": ("epsilon", width),
    }


def _branch(system: System, branches: Branches, run: xr.Dataset, tolerance: float) -> xr.Dataset:
    """Branch through the orbit to which a run has settled."""
    end = {name: float(run[name].values[-1]) for name in system.states}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        return continue_orbit(
            system,
            branches.parameter,
            branches.between,
            initial=end,
            period=branches.period,
            tolerance=tolerance,
        )


def point_sets(system: System, found: xr.Dataset) -> list[Floats]:
    """Points of each attractor, without drifting states."""
    kept = [i for i, name in enumerate(system.states) if name not in system.drift_states]
    sets = []
    for points in found["points"].values:
        finite = points[np.isfinite(points).all(axis=1)][:, kept]
        sets.append(finite[:: -(-len(finite) // _MOST) or 1])
    return sets


def spread_of(sets: list[Floats], system: System, region: dict[str, tuple[float, float]]) -> Floats:
    """Size of each state: the larger of its range in the region and over the attractors."""
    names = [name for name in system.states if name not in system.drift_states]
    wide = np.array([abs(np.diff(region.get(name, (0.0, 0.0)))[0]) for name in names])
    if sets:
        wide = np.maximum(wide, np.ptp(np.concatenate(sets), axis=0))
    return np.where(wide > 0.0, wide, 1.0)


def far_from_all(sets: list[Floats], others: list[Floats], spread: Floats, near: float) -> int:
    """Number of sets with a point that is farther than ``near`` from each of the others."""
    from scipy.spatial import cKDTree

    trees = [cKDTree(other / spread) for other in others]
    return sum(
        all(tree.query(points / spread)[0].max() > near for tree in trees) for points in sets
    )


@dataclass(frozen=True)
class Special:
    """A special point: its kind and the value of the parameter."""

    kind: str
    value: float


def specials_of(branch: xr.Dataset) -> list[Special]:
    """Special points of a branch that have a counterpart on smooth ones."""
    pairs = zip(branch["special_kind"].values, branch["special_value"].values, strict=True)
    return [Special(str(kind), float(value)) for kind, value in pairs if kind in SMOOTH]


def matched(exact: list[Special], smooth: list[Special]) -> tuple[Floats, Floats]:
    """Value of the counterpart of each exact point, nan without one; and those that are left.

    Of all pairs of one kind the closest one belongs together, then the closest of the rest.
    """
    pairs = sorted(
        (abs(one.value - other.value), i, j)
        for i, one in enumerate(exact)
        for j, other in enumerate(smooth)
        if one.kind == other.kind
    )
    values = np.full(len(exact), np.nan)
    left = set(range(len(smooth)))
    for _, i, j in pairs:
        if np.isnan(values[i]) and j in left:
            values[i] = smooth[j].value
            left.discard(j)
    return values, np.array([smooth[j].value for j in sorted(left)])
