"""Options of `continue_special`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.orbit_search.branch_options import check_way, read_bounds, read_steps
from nonsmooth.errors import ModelError, OptionError, unknown_name
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.stretch import BranchOptions
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

__all__ = ["SpecialCurve", "read_special_options"]

_KINDS = (
    "fold", "flip", "torus", "grazing", "corner", "gained", "lost",
    "crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding",
)  # fmt: skip


@dataclass(frozen=True)
class SpecialCurve:
    """A special point and the parameters over which it is followed."""

    options: BranchOptions  # over the second parameter
    guess: Guess
    kind: str
    test: str  # what vanishes, as `BranchTests` names it
    first: str  # parameter of the branch
    first_bounds: tuple[float, float]


def read_special_options(
    branch: Any,
    special: Any,
    parameter: Any,
    between: Any,
    *,
    direction: Any,
    steps: Any,
    step: Any,
    largest_step: Any,
    smallest_step: Any,
    tolerance: float,
) -> SpecialCurve:
    """The point that is meant, and how it is followed."""
    if not hasattr(branch, "data_vars") or "special_test" not in branch:
        raise OptionError("branch: give a result of continue_orbit")
    count = branch.sizes["special"]
    number = finite_number("special", special)
    if number != int(number) or not 0 <= number < count:
        raise OptionError(
            f"special = {special!r:.60}: the branch has {count} special points, numbered from 0"
        )
    kind = str(branch["special_kind"].values[int(number)])
    if kind not in _KINDS:
        raise OptionError(
            f"special = {int(number)} is a {kind} point; curves are followed of the kinds"
            f" {', '.join(_KINDS)}"
        )
    point = branch.isel(point=int(branch["special_point"].values[int(number)]))
    first = str(branch.attrs["parameter"])
    try:
        system = System.from_toml(branch.attrs["system"])
        system = system.with_parameters(**{first: float(point[first])})
    except (KeyError, ModelError) as fault:
        raise OptionError(f"branch: its attributes do not give its system: {fault}") from None
    known = [name for name in system.parameters if name != first]
    if parameter == first:
        raise OptionError(
            f"parameter = {first!r} is that of the branch, the first one already; give another one"
            f" of the system: {', '.join(known) or 'it has none'}"
        )
    if parameter not in known:
        raise OptionError(unknown_name("second parameter", str(parameter), known))
    low, high = read_bounds(between)
    value = float(system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the branch has {parameter} = {value:g}, which lies"
            " outside"
        )
    check_way(direction)
    shortest, begin, longest = read_steps(smallest_step, step, largest_step)
    options = BranchOptions(
        system, parameter, (low, high), int(branch.attrs["period"]),
        float(branch.attrs["phase_of_period"]), not is_driven(build_tables(system)),
        whole_number("steps", steps), begin, longest, shortest, tolerance, False,
    )  # fmt: skip
    ends = [float(text) for text in str(branch.attrs["between"]).split()]
    return SpecialCurve(
        options, guess_of_dataset(system, point), kind,
        str(branch["special_test"].values[int(number)]), first, (ends[0], ends[1]),
    )  # fmt: skip
