"""A branch of orbits as a dataset: orbits over ``point``, special points over ``special``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.periodic_orbits.branch_part import BranchPart
from nonsmooth.periodic_orbits.multipliers import UNBOUNDED
from nonsmooth.periodic_orbits.orbit import Orbit
from nonsmooth.periodic_orbits.orbit_dataset import common, orbit_variables
from nonsmooth.periodic_orbits.stretch import BranchOptions
from nonsmooth.runs.labels import Columns
from nonsmooth.runs.options import finite_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["branch_dataset", "check_way", "read_bounds", "read_steps"]

_WAYS = ("both", "up", "down")


def check_way(direction: Any) -> None:
    """A direction in which a parameter goes at first."""
    if not is_known(direction, _WAYS):
        raise OptionError(f"direction = {quote(direction)}: give one of {', '.join(_WAYS)}")


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
    except (TypeError, ValueError, OverflowError) as fault:
        if isinstance(fault, OptionError):
            raise
        raise OptionError(
            f"between = {quote(between)}: give the lowest and the highest value, such as (0.1, 0.2)"
        ) from None
    if not low < high:
        raise OptionError(f"between = ({low:g}, {high:g}): the first must be below the second")
    return low, high


def _length(name: str, value: Any) -> float:
    number = finite_number(name, value)
    if not 0.0 < number <= 1.0:
        raise OptionError(f"{name} = {number:g} must lie above 0, at most 1")
    return number


def branch_dataset(
    options: BranchOptions, parts: Sequence[BranchPart], attrs: dict[str, Any]
) -> xr.Dataset:
    """Dataset of the points of a branch in order."""
    import xarray as xr

    system, name = options.system, options.parameter
    over = ("point",)
    variables = orbit_variables(system, [_orbit(options, part) for part in parts], over)
    variables[name] = (
        over, np.array([part.value for part in parts]),
        {"long_name": system.describe.get(name, name)},
    )  # fmt: skip
    variables["arclength"] = (
        over, np.array([part.arclength for part in parts]), {"long_name": "length of the branch"},
    )  # fmt: skip
    variables |= _specials(parts)
    coords: dict[str, Any] = {
        "state": (("state",), np.array(system.states)),
        "point": (over, np.arange(len(parts)), {"long_name": "point of the branch"}),
        "time": (over, np.array([part.looked.turn.instants[0] for part in parts])),
    }
    if system.drift:
        coords["drift_state"] = (("drift_state",), np.array(tuple(system.drift)))
    return xr.Dataset(variables, coords, common(system) | {"parameter": name} | attrs)


def _orbit(options: BranchOptions, part: BranchPart) -> Orbit:
    looked, system = part.looked, options.system
    drifting = np.array([name in system.drift_states for name in system.states])
    return Orbit(
        part.word, looked.turn, looked.end, looked.values, options.period, options.phase,
        options.autonomous, looked.window, looked.residual, 0, looked.multipliers,
        looked.admissibility, 1, drifting, reflection=looked.reflection, strobes=looked.strobes,
    )  # fmt: skip


def _specials(parts: Sequence[BranchPart]) -> Columns:
    """The table of special points."""
    chosen = [k for k, part in enumerate(parts) if part.special]
    over = ("special",)
    multipliers = [_telling(parts[k]) for k in chosen]
    return {
        "special_kind": (
            over, np.array([parts[k].special for k in chosen], str), {"long_name": "what happens"},
        ),
        "special_value": (
            over, np.array([parts[k].value for k in chosen], float),
            {"long_name": "value of the parameter"},
        ),
        "special_point": (
            over, np.array(chosen, np.int64), {"long_name": "its number among the points"},
        ),
        "special_test": (
            over, np.array([parts[k].test for k in chosen], str), {"long_name": "what is zero"},
        ),
        "special_detail": (
            over, np.array([parts[k].detail for k in chosen], str), {"long_name": "in words"},
        ),
        "special_multiplier": (
            over, np.array(multipliers, complex), {"long_name": "multiplier that tells"},
        ),
    }  # fmt: skip


def _telling(part: BranchPart) -> complex:
    """The multiplier that makes a point special, or the largest one."""
    values = part.looked.multipliers.multipliers
    if part.unbounded and values.size:
        return complex(np.inf)
    if part.special == "grazing" and np.any(np.abs(values) > UNBOUNDED):
        return complex(np.inf)  # the rate of the guard is zero but for rounding, of either sign
    values = values[np.isfinite(values)]
    if not values.size:
        return complex(np.nan)
    critical = {"flip": -1.0, "fold": 1.0, "branch_point": 1.0, "symmetry_breaking": 1.0}
    if part.special in critical:
        return complex(values[np.argmin(np.abs(values - critical[part.special]))])
    if part.special == "torus":
        pairs = values[values.imag > 0.0] if np.any(values.imag > 0.0) else values
        return complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1.0))])
    return complex(values[0])
