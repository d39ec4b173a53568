"""Smoothed attractors and branches beside the exact ones."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.attractors import attractors
from nonsmooth.analysis.continue_orbit import continue_orbit
from nonsmooth.analysis.smoothing.attractor_distances import far_from_all, point_sets, spread_of
from nonsmooth.analysis.smoothing.ladder import Ladder
from nonsmooth.analysis.smoothing.special_shifts import matched, specials_of
from nonsmooth.errors import OptionError, RunWarning
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["compared_attractors", "compared_branches", "read_branches", "read_sets"]


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


def read_sets(region: Any, starts: Any, near: Any) -> Sets | None:
    """Check the options of the search for attractors; None where there is none."""
    count, distance = whole_number("starts", starts), finite_number("near", near)
    if not distance > 0.0:
        raise OptionError(f"near = {distance:g} must be positive")
    if region is None:
        return None
    if not isinstance(region, Mapping):
        raise OptionError(f"region = {region!r:.60}: give ranges of states, as {{'x': (-1, 1)}}")
    return Sets(dict(region), count, distance)


def read_branches(system: System, parameter: Any, between: Any, period: Any) -> Branches | None:
    """Check the options of the branches; None where there are none."""
    count = whole_number("period", period)
    if (parameter is None) != (between is None):
        raise OptionError("give both parameter= and between=, or neither")
    return None if parameter is None else Branches(parameter, between, count)


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
