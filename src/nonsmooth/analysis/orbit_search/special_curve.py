"""A special point of a branch followed over a second parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.orbit_search.special_options import SpecialCurve
from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.two_parameter import two_parameter
from nonsmooth.errors import NonsmoothError, OptionError
from nonsmooth.periodic_orbits.branch_part import BranchPart, ending_of_orbits, kind_of
from nonsmooth.periodic_orbits.branch_tests import WORD_TESTS, BranchTests, Looked
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.runs.progress import HeldInterrupts, Progress

__all__ = ["follow_special"]

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength within which the start itself is seen again


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
            and name.split(":")[0] in WORD_TESTS
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
        changes = point.special.split(":")[0] in WORD_TESTS
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
