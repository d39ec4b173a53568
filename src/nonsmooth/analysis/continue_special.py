"""`continue_special`: a curve of special points of periodic orbits over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.analysis.orbit_search.branches import (
    branch_dataset,
    check_way,
    read_bounds,
    read_steps,
)
from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.two_parameter import two_parameter
from nonsmooth.errors import ModelError, NonsmoothError, OptionError, is_known, unknown_name
from nonsmooth.periodic_orbits.branch_part import BranchPart, ending_of_orbits, kind_of
from nonsmooth.periodic_orbits.branch_tests import BranchTests, Looked, is_of_word
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.stretch import BranchOptions
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.progress import HeldInterrupts, Progress
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["continue_special"]

_KINDS = (
    "fold", "flip", "torus", "grazing", "corner", "gained", "lost",
    "crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding",
)  # fmt: skip

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength within which the start itself is seen again


def continue_special(
    branch: xr.Dataset,
    special: int,
    parameter: str,
    between: tuple[float, float],
    *,
    direction: str = "both",
    steps: int = 100,
    step: float = 0.01,
    largest_step: float = 0.05,
    smallest_step: float = 1e-7,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow a fold, flip, torus or grazing point of a branch over a second parameter.

    Parameters
    ----------
    branch : xarray.Dataset
        Result of `continue_orbit`.
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
        says what they have in common.

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
    singular (a fold), or that the function vanishes by which `continue_orbit` has located the
    point, such as det(M + 1) or the lowest value of a guard in a leg. The curve ends where another
    of the functions that keep the word valid vanishes too: two things happen at once there.

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
    attrs: dict[str, Any] = {
        "period": wanted.options.period,
        "special_kind": wanted.kind,
        "first_parameter": wanted.first,
        "between": f"{wanted.options.bounds[0]:g} {wanted.options.bounds[1]:g}",
    }
    data = branch_dataset(wanted.options, parts, attrs | said)
    place = list(wanted.options.system.parameters).index(wanted.first)
    values = [float(part.looked.values[place]) for part in parts]
    words = {"long_name": wanted.options.system.describe.get(wanted.first, wanted.first)}
    return data.assign({wanted.first: ("point", values, words)})


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
    shared: SharedOptions,
) -> SpecialCurve:
    """The point that is meant, and how it is followed."""
    number, kind, point = _special_point(branch, special)
    first = str(branch.attrs["parameter"])
    try:
        system = shared.system_of(System.from_toml(branch.attrs["system"]))
        system = system.with_parameters(**{first: float(point[first])})
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
    ends = [float(text) for text in str(branch.attrs["between"]).split()]
    return SpecialCurve(
        options, guess_of_dataset(system, point), kind,
        str(branch["special_test"].values[number]), first, (ends[0], ends[1]),
    )  # fmt: skip


def _special_point(branch: Any, special: Any) -> tuple[int, str, xr.Dataset]:
    """Number and kind of a special point that can be followed, and the orbit there."""
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
    place = int(branch["special_point"].values[int(number)])
    return int(number), kind, branch.isel(point=place)


def _second_bounds(system: System, first: str, parameter: Any, between: Any) -> tuple[float, float]:
    """Lowest and highest value of the second parameter."""
    known = [name for name in system.parameters if name != first]
    if is_known(parameter, (first,)):
        raise OptionError(
            f"parameter = {first!r} is that of the branch, the first one already; give another one"
            f" of the system: {', '.join(known) or 'it has none'}"
        )
    if not is_known(parameter, known):
        raise OptionError(unknown_name("second parameter", str(parameter), known))
    low, high = read_bounds(between)
    value = float(system.parameter_values[parameter])
    if not low <= value <= high:
        raise OptionError(
            f"between = ({low:g}, {high:g}): the branch has {parameter} = {value:g}, which lies"
            " outside"
        )
    return low, high


class _Condition:
    """Equations of the orbit in both parameters, and the number that vanishes on the curve."""

    def __init__(self, wanted: SpecialCurve) -> None:
        options = wanted.options
        names = list(options.system.parameters)
        self.wanted = wanted
        self.legs = Legs(options.system, (wanted.first, options.parameter))
        self.legs.set_values(options.system.parameter_values)
        self.equations = OrbitEquations(
            self.legs, wanted.guess.word, period=options.period, phase=options.phase,
            autonomous=options.autonomous, origin=wanted.guess.turn.states[0],
            reference=wanted.guess.turn.states[0].copy(),
        )  # fmt: skip
        self.unknowns = self.equations.pack(wanted.guess.turn)
        self._values = self.legs.values.copy()
        self._places = [names.index(wanted.first), names.index(options.parameter)]
        self._number = BranchTests(
            self.equations, options.tolerance, whole=False, grows=wanted.test
        )
        self._tests = BranchTests(self.equations, options.tolerance, grows=wanted.test)

    def _set(self, p: float, q: float) -> None:
        values = self._values.copy()
        values[self._places] = p, q
        self.legs.set_values(values)

    def residual(self, u: Floats, p: float, q: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Equations with their derivatives by unknowns and both parameters."""
        self._set(p, q)
        residual, jacobian, moved = self.equations.evaluate(u)
        return residual, jacobian, moved[:, 0], moved[:, 1]

    def number(self, u: Floats, p: float, q: float) -> float:
        """What vanishes on the curve."""
        self._set(p, q)
        return self._number.look(u).tests.get(self.wanted.test, np.nan)

    def look(self, point: Point) -> Looked:
        """The orbit of a point of the curve."""
        self._set(float(point.u[-1]), point.p)
        return self._tests.look(point.u[:-1].copy())

    def others(self, point: Point) -> Mapping[str, float]:
        """What else keeps the word valid, but the condition itself."""
        driven = not self.equations.word.closes_at_event
        return {
            name: value
            for name, value in self.look(point).tests.items()
            if name != self.wanted.test
            and is_of_word(name)
            # on a curve of grazes the engine sees what rounding makes of them; where an event
            # passes the section nothing happens
            and name not in ("motion", "leg:last", "leg:0" if driven else "")
        }


def follow_special(wanted: SpecialCurve, direction: str) -> tuple[list[BranchPart], dict[str, Any]]:
    """Points of the curve in order, and attributes that say how it ended."""
    ways = {"both": (-1, 1), "up": (1,), "down": (-1,)}[direction]
    found: dict[int, list[BranchPart]] = {-1: [], 1: []}
    said: dict[str, Any] = {"status": "completed", "end_first": "start", "end_last": "start"}
    messages, steps = [], wanted.options.steps
    try:
        with HeldInterrupts() as held, Progress("following", len(ways) * steps) as progress:
            for number, way in enumerate(ways):

                def report(done: int, number: int = number) -> None:
                    progress.update(number * steps + done)
                    held.check()

                name = "first" if way < 0 else "last"
                said[f"end_{name}"], message = _one_way(wanted, way, found[way], report)
                messages.append(f"{name} end: {message}")
    except KeyboardInterrupt:
        said["status"] = "interrupted"
        messages.append("interrupted by the user")
    said["message"] = "; ".join(messages)
    down = found[-1]
    return [*reversed(down), *found[1][bool(down) :]], said


def _one_way(
    wanted: SpecialCurve, way: int, found: list[BranchPart], report: Callable[[int], None]
) -> tuple[str, str]:
    """Follow the curve in one direction; why it ends there, as a word and as a sentence."""
    condition, options = _Condition(wanted), wanted.options
    for point in (curve := _curve(condition, way)):
        report(len(found))
        try:
            looked = condition.look(point)
        except LegError:
            continue
        changes = is_of_word(point.special)
        if changes and point.arclength <= _AGAIN:
            continue
        special = kind_of(point.special) if changes else point.special
        detail = "two things happen at once" if changes else ""
        found.append(
            BranchPart(
                condition.equations.word, looked, point.p, way * point.arclength, special, detail,
                point.special,
            )
        )  # fmt: skip
        if changes:
            return special, (
                f"at {options.parameter} = {point.p:.10g} something else happens too ({special}),"
                " and the orbits beyond have another word"
            )
    return curve.ended, _says(wanted, curve, point)


def _says(wanted: SpecialCurve, curve: Branch, last: Point) -> str:
    """Why the curve ends at this point, by the names of both parameters."""
    options, first = wanted.options, float(last.u[-1])
    if curve.ended == "bound" and first in wanted.first_bounds:
        return (
            f"{wanted.first} reached its bound {first:.10g}, which is that of the branch, at"
            f" {options.parameter} = {last.p:.10g}; for more give a branch over a wider range"
        )
    if curve.ended == "bound":
        return (
            f"{options.parameter} reached its bound {last.p:.10g}, at {wanted.first} = {first:.10g}"
        )
    return ending_of_orbits(curve.ended, curve.message, options.parameter, last.p)


def _curve(condition: _Condition, way: int) -> Branch:
    wanted, options = condition.wanted, condition.wanted.options
    (low, high), (lowest, highest) = wanted.first_bounds, options.bounds
    values = options.system.parameter_values
    try:
        return two_parameter(
            condition.residual, "fold" if wanted.test == "fold" else condition.number,
            condition.unknowns, float(values[wanted.first]), float(values[options.parameter]),
            direction=way, step=options.step, smallest_step=options.smallest_step,
            largest_step=options.largest_step, bounds=(low, high), second_bounds=options.bounds,
            steps=options.steps, tests=condition.others, parameter_scale=high - low,
            scale=scale_of(condition.equations, condition.unknowns),
            second_scale=highest - lowest,
        )  # fmt: skip
    except NonsmoothError as fault:
        raise OptionError(f"the special point cannot be followed: {fault}") from None
