"""`continue_special`: a curve of special points of periodic orbits over two parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.normal_forms.along_curve import CHANGES, CriticalityAlong
from nonsmooth.analysis.options import SharedOptions
from nonsmooth.analysis.orbit_search.branches import (
    branch_dataset,
    check_way,
    read_bounds,
    read_steps,
)
from nonsmooth.errors import (
    ModelError,
    NonsmoothError,
    OptionError,
    is_known,
    quote,
    unknown_name,
)
from nonsmooth.periodic_orbits.branch_part import BranchPart, kind_of
from nonsmooth.periodic_orbits.branch_tests import what_of
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.special_condition import OF_UNIT_CIRCLE, CurveOptions
from nonsmooth.periodic_orbits.special_curve import SpecialCurve
from nonsmooth.periodic_orbits.stretch import BranchOptions
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.part_names import OF_BRANCHES, check_part_names
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["continue_special"]

_KINDS = (
    "fold", "flip", "torus", "grazing", "corner", "border_collision", "gained", "lost",
    "crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding",
)  # fmt: skip

_RESONANT = {"1_1": "fold", "1_2": "flip"}  # curves on which a torus curve ends


def continue_special(
    branch: xr.Dataset,
    special: int,
    parameter: str,
    between: tuple[float, float],
    *,
    direction: str = "both",
    steps: int = 200,
    step: float = 0.01,
    largest_step: float = 0.02,
    smallest_step: float = 1e-7,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow a fold, flip, torus or grazing point of a branch over a second parameter.

    Parameters
    ----------
    branch : xarray.Dataset
        Result of `continue_orbit`; or one of `continue_special`, from whose points of codimension
        two the other curve is followed that passes there.
    special : int
        Number of one of its special points, of a kind that is located by one condition: ``fold``,
        ``flip``, ``torus``, ``grazing``, ``corner``, ``gained``, ``lost``, and the four kinds
        of sliding, such as ``grazing_sliding``.
    parameter : str
        The second parameter; the first is that of the branch, and keeps its bounds.
    between : (float, float)
        Lowest and highest value of the second parameter.

    Other Parameters
    ----------------
    direction : {"both", "up", "down"}, optional
        Whether the second parameter grows or falls at first.
    steps, step, largest_step, smallest_step : optional
        As for `continue_orbit`.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        As of `continue_orbit`, with both parameters over ``point``: orbits on which the condition
        holds. ``special_value`` is that of the second parameter. The attribute ``special_kind``
        says what they have in common. ``special_kind`` over ``special`` names points of codimension
        two: ``cusp``, ``fold_flip``, ``fold_torus``, ``flip_torus``, ``resonance_1_1`` to
        ``resonance_1_4``, ``grazing_fold``, ``grazing_flip``, ``grazing_torus``,
        ``double_grazing``, and others of the same form; ``generalised_flip`` and ``chenciner``
        where flips or tori change between super- and subcritical; ``turning_point`` where the
        second parameter turns back.

    Raises
    ------
    OptionError
        When the branch has no such point, or none that can be followed.

    See Also
    --------
    continue_orbit : what gives the branch.
    continuation.two_parameter : the same for any equations.

    Notes
    -----
    The equations of the orbit and one condition more, in one unknown more: that the Jacobian is
    singular (a fold), also for perturbations that come back with the other sign (a flip), or that
    the function vanishes by which `continue_orbit` has located the point, such as the lowest value
    of a guard in a leg. Where another of the functions that keep the word valid vanishes too, the
    curve goes on with the changed word if the same condition can be met by motions there, and ends
    if not. Along flips and tori the coefficient of the cube is computed as in `criticality`, by
    fewer differences, and times what vanishes at its poles.

    Examples
    --------
    Where the soft impact oscillator first touches its stop, over amplitude and frequency:

    >>> import nonsmooth as ns
    >>> branch = ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.05, 0.6))
    >>> kinds = branch["special_kind"].values.tolist()
    >>> curve = ns.continue_special(branch, kinds.index("grazing"), "omega", (0.8, 0.9))
    >>> a, omega = curve["a"].values, curve["omega"].values
    >>> exact = 1.26 * ((1 - omega**2) ** 2 + (0.02 * omega) ** 2) ** 0.5 / omega**2
    >>> bool(abs(a - exact).max() < 1e-10)
    True
    """
    wanted = read_special_options(
        branch, special, parameter, between, direction=direction, steps=steps, step=step,
        largest_step=largest_step, smallest_step=smallest_step,
        shared=SharedOptions(tolerance=tolerance),
    )  # fmt: skip
    parts, said = follow_special(wanted, direction)
    asked, options = wanted.asked, wanted.asked.options
    attrs: dict[str, Any] = {
        "period": options.period,
        "phase_of_period": options.phase,
        "special_kind": asked.kind,
        "first_parameter": asked.first,
        "first_between": "{:.17g} {:.17g}".format(*asked.first_bounds),
        "between": "{:.17g} {:.17g}".format(*options.bounds),
    }
    data = branch_dataset(options, parts, attrs | said)
    place = list(options.system.parameters).index(asked.first)
    values = [float(part.looked.values[place]) for part in parts]
    words = {"long_name": options.system.describe.get(asked.first, asked.first)}
    return data.assign({asked.first: ("point", values, words)})


@dataclass(frozen=True)
class _Wanted:
    """What is followed, and where it begins."""

    asked: CurveOptions
    guess: Guess
    test: str  # what vanishes, as `BranchTests` names it


@dataclass(frozen=True)
class _SpecialPoint:
    """A special point of a branch, or of another curve."""

    kind: str  # of the curve that is followed from there
    test: str
    orbit: xr.Dataset
    parameters: tuple[str, ...]  # those that vary: of the branch or of both of the curve
    bounds: tuple[float, float]  # of the first of them


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
    shared: SharedOptions,
) -> _Wanted:
    """The point that is meant, and how it is followed."""
    place = _special_point(branch, special)
    first = place.parameters[0]
    try:
        system = shared.system_of(System.from_toml(branch.attrs["system"]))
        values = {name: float(place.orbit[name]) for name in place.parameters}
        system = system.with_parameters(**values)
    except (KeyError, ModelError) as fault:
        raise OptionError(f"branch: its attributes do not give its system: {fault}") from None
    bounds = _second_bounds(system, first, parameter, between)
    check_way(direction)
    shortest, begin, longest = read_steps(smallest_step, step, largest_step)
    options = BranchOptions(
        system, parameter, bounds, int(branch.attrs["period"]),
        float(branch.attrs["phase_of_period"]), not is_driven(build_tables(system)),
        whole_number("steps", steps), begin, longest, shortest, float(shared.tolerance), False,
    )  # fmt: skip
    watched = None
    if place.kind in CHANGES:
        watched = CHANGES[place.kind], CriticalityAlong(system, first, place.kind)
    asked = CurveOptions(options, place.kind, first, place.bounds, watched)
    return _Wanted(asked, guess_of_dataset(system, place.orbit), place.test)


def _special_point(branch: Any, special: Any) -> _SpecialPoint:
    """A special point that can be followed."""
    if not hasattr(branch, "data_vars") or "special_test" not in branch:
        raise OptionError("branch: give a result of continue_orbit, or of continue_special")
    count = branch.sizes["special"]
    number = finite_number("special", special)
    if number != int(number) or not 0 <= number < count:
        raise OptionError(
            f"special = {quote(special)}: the branch has {count} special points, numbered from 0"
        )
    row = branch.isel(special=int(number))
    kind, test = str(row["special_kind"].values), str(row["special_test"].values)
    of_curve = "first_parameter" in branch.attrs
    followed = _other_condition(test) if of_curve else kind
    if followed not in _KINDS:
        raise OptionError(
            f"special = {int(number)} is a {kind} point, from which no curve is followed; curves"
            f" are followed of the kinds {', '.join(_KINDS)}"
        )
    if what_of(test) in ("", "motion"):
        raise OptionError(
            f"special = {int(number)}: only the motions beyond tell of this {kind} point, so there"
            " is no number that vanishes there and could be followed"
        )
    if what_of(test) == "rest":
        raise OptionError(
            f"special = {int(number)}: rounding of the last rebounds leaves too few digits to"
            " follow where they no longer end before the release; give branches at some values of"
            " the second parameter, each ends there"
        )
    names = (branch.attrs["first_parameter"],) if of_curve else ()
    bounds = branch.attrs["first_between" if of_curve else "between"]
    low, high = (float(text) for text in str(bounds).split())
    orbit = branch.isel(point=int(row["special_point"]))
    return _SpecialPoint(
        followed, test if test not in _RESONANT else followed, orbit,
        (*names, str(branch.attrs["parameter"])), (low, high),
    )  # fmt: skip


def _other_condition(test: str) -> str:
    """Kind of the curve that crosses another one, by what vanishes beside its own condition."""
    return _RESONANT.get(test, test if test in OF_UNIT_CIRCLE else kind_of(test))


def _second_bounds(system: System, first: str, parameter: Any, between: Any) -> tuple[float, float]:
    """Lowest and highest value of the second parameter."""
    known = [name for name in system.parameters if name != first]
    if is_known(parameter, (first,)):
        raise OptionError(
            f"parameter = {first!r} is that of the branch, the first one already; give another one"
            f" of the system: {', '.join(known) or 'it has none'}"
        )
    if not is_known(parameter, known):
        raise OptionError(unknown_name("second parameter", parameter, known))
    check_part_names(system, OF_BRANCHES, parameters=(parameter,))
    low, high = read_bounds(between)
    value = float(system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the branch has {parameter} = {value:g}, which lies"
            " outside"
        )
    return low, high


def follow_special(wanted: _Wanted, direction: str) -> tuple[list[BranchPart], dict[str, Any]]:
    """Points of the curve in order, and attributes that say how it ended."""
    ways = {"both": (-1, 1), "up": (1,), "down": (-1,)}[direction]
    asked, steps = wanted.asked, wanted.asked.options.steps
    found: dict[int, list[BranchPart]] = {-1: [], 1: []}
    said: dict[str, Any] = {"status": "completed", "end_first": "start", "end_last": "start"}
    messages = []
    try:
        with HeldInterrupts() as held, Progress("following", len(ways) * steps) as progress:
            for number, way in enumerate(ways):

                def report(done: int, number: int = number) -> None:
                    progress.update(number * steps + min(done, steps))
                    held.check()

                legs = Legs(asked.options.system, (asked.first, asked.options.parameter))
                legs.set_values(asked.options.system.parameter_values)
                curve = SpecialCurve(asked, legs, report, found[way])
                name = "first" if way < 0 else "last"
                try:
                    curve.follow(wanted.guess, wanted.test, way)
                except NonsmoothError as fault:
                    raise OptionError(f"the special point cannot be followed: {fault}") from None
                said[f"end_{name}"] = curve.ended
                messages.append(f"{name} end: {curve.message}")
                if curve.ended == "closed":  # this way all of it has been seen
                    said["end_first"] = said["end_last"] = "closed"
                    found[-way].clear()
                    messages = [curve.message]
                    break
    except KeyboardInterrupt:
        if not any(found.values()):
            raise  # there is not even the first point to keep
        said["status"] = "interrupted"
        messages.append("interrupted by the user")
    said["message"] = "; ".join(messages)
    down = found[-1]
    return [*reversed(down), *found[1][bool(down) :]], said
