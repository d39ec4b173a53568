"""Options of `continue_orbit`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.analysis.orbit_search.options import period_of, read_wanted
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.restart import is_orbit
from nonsmooth.periodic_orbits.stretch import BranchOptions
from nonsmooth.runs.options import check_flag, finite_number, whole_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

__all__ = ["Beginning", "check_way", "read_bounds", "read_branch_options", "read_steps"]

_WAYS = ("both", "up", "down")


class Beginning(NamedTuple):
    """Where a branch begins: with an orbit, or at a special point of another branch."""

    kind: str = "orbit"  # or "flip", "crossing"
    neighbour: Any = None  # of a crossing: the next point of the known branch with the same word


def read_branch_options(
    system: Any,
    parameter: Any,
    between: Any,
    *,
    initial: Any,
    period: Any,
    special: Any,
    direction: Any,
    steps: Any,
    step: Any,
    largest_step: Any,
    smallest_step: Any,
    inadmissible: Any,
    parameters: Mapping[str, float] | None,
    **rest: Any,
) -> tuple[BranchOptions, OrbitRequest, tuple[str, ...], Beginning]:
    """Options of a branch, its first orbit, the word given, and where it begins."""
    base = getattr(system, "system", system)
    if isinstance(base, System) and parameter not in base.parameters:
        raise OptionError(unknown_name("parameter", str(parameter), base.parameters))
    beginning = Beginning()
    if special is not None:
        initial, beginning = _at_special(initial, special, parameter)
        parameters = {**(parameters or {}), parameter: float(initial[parameter])}
    elif is_orbit(initial) and parameter in initial and initial[parameter].ndim == 0:
        parameters = {**(parameters or {}), parameter: float(initial[parameter])}
    if is_orbit(initial) and whole_number("period", period) == 1:
        period = period_of(initial) * (2 if beginning.kind == "flip" else 1)
    wanted, names = read_wanted(
        system, initial, period=period, parameters=parameters, verb="continue_orbit", **rest
    )
    low, high = read_bounds(between)
    value = float(wanted.system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the branch begins at {parameter} = {value:g}, which"
            " lies outside; give the system, or parameters=, a value within"
        )
    check_way(direction)
    smallest, first, largest = read_steps(smallest_step, step, largest_step)
    options = BranchOptions(
        wanted.system, parameter, (low, high), wanted.period, wanted.phase,
        not is_driven(build_tables(wanted.system)), whole_number("steps", steps), first, largest,
        smallest, wanted.tolerance, check_flag("inadmissible", inadmissible),
    )  # fmt: skip
    return options, wanted, names, beginning


def check_way(direction: Any) -> None:
    """A direction in which a parameter goes at first."""
    if direction not in _WAYS:
        raise OptionError(f"direction = {direction!r:.60}: give one of {', '.join(_WAYS)}")


def read_steps(smallest: Any, first: Any, largest: Any) -> tuple[float, float, float]:
    """Smallest, first and largest step of a branch."""
    low, begin = _length("smallest_step", smallest), _length("step", first)
    high = _length("largest_step", largest)
    if not low <= begin <= high:
        raise OptionError(
            f"smallest_step = {low:g}, step = {begin:g} and largest_step = {high:g} must be in"
            " this order"
        )
    return low, begin, high


def read_bounds(between: Any) -> tuple[float, float]:
    """Lowest and highest value of a parameter."""
    try:
        low, high = (finite_number("between", float(each)) for each in between)
    except (TypeError, ValueError) as fault:
        if isinstance(fault, OptionError):
            raise
        raise OptionError(
            f"between = {between!r:.60}: give the lowest and the highest value, such as (0.1, 0.2)"
        ) from None
    if not low < high:
        raise OptionError(f"between = ({low:g}, {high:g}): the first must be below the second")
    return low, high


def _length(name: str, value: Any) -> float:
    number = finite_number(name, value)
    if not 0.0 < number <= 1.0:
        raise OptionError(f"{name} = {number:g} must lie above 0, at most 1")
    return number


def _at_special(branch: Any, special: Any, parameter: str) -> tuple[Any, Beginning]:
    """The orbit at a special point of a branch, and what begins there."""
    if not hasattr(branch, "data_vars") or "special_point" not in branch:
        raise OptionError("special= needs initial=, a branch that continue_orbit has given")
    count = branch.sizes["special"]
    number = finite_number("special", special)
    if number != int(number) or not 0 <= number < count:
        raise OptionError(
            f"special = {special!r:.60}: the branch has {count} special points, numbered from 0"
        )
    if branch.attrs.get("parameter") != parameter:
        raise OptionError(
            f"special: the branch is one over {branch.attrs.get('parameter')!r}; follow it over"
            " the same parameter"
        )
    kind = str(branch["special_kind"].values[int(number)])
    if kind not in ("flip", "branch_point", "symmetry_breaking"):
        raise OptionError(
            f"special = {int(number)}: no other branch begins at a {kind} point; take one of the"
            " kinds flip, branch_point and symmetry_breaking"
        )
    place = int(branch["special_point"].values[int(number)])
    point = branch.isel(point=place)
    if kind == "flip":
        return point, Beginning("flip")
    return point, Beginning("crossing", _neighbour(branch, place))


def _neighbour(branch: Any, place: int) -> Any:
    """The next point of a branch, or the one before, with the same word; None where neither has."""
    here = branch.isel(point=place)
    for other in (place + 1, place - 1):
        if 0 <= other < branch.sizes["point"]:
            there = branch.isel(point=other)
            if all(np.array_equal(here[name], there[name]) for name in ("leg_mode", "leg_path")):
                return there
    return None
