"""A condition that orbits of one word meet on a curve over two parameters, and what else happens.

Beside the tests of the word, numbers are watched whose zeros are points of codimension two: another
multiplier at 1 or -1, another pair on the unit circle, on a torus curve the angle of the pair, and
the coefficient that tells what begins at a flip or a torus.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.extended import Held, Scalar, extended, point_of_curve
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.two_parameter import two_parameter
from nonsmooth.periodic_orbits.branch_tests import (
    BranchTests,
    Looked,
    is_of_word,
    tests_of_multipliers,
    what_of,
)
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.multipliers import Floquet, floquet
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.stretch import BranchOptions

__all__ = ["OF_UNIT_CIRCLE", "CurveOptions", "CurveStart", "SpecialCondition", "pair_on_circle"]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

OF_UNIT_CIRCLE = ("fold", "flip", "torus")
_STEP = 6e-6  # scaled, of central differences: the cube root of rounding
_SHORT = 30.0  # times the part of the turn that the shortest leg lasts: part of the usual step
_LEAST = 1e-4  # of the usual step
# sum of a pair on the unit circle, twice the cosine of its angle, at each strong resonance
_RESONANCES = {"1_1": 2.0, "1_2": -2.0, "1_3": -1.0, "1_4": 0.0}


@dataclass(frozen=True)
class CurveOptions:
    """What is followed over two parameters, and how."""

    options: BranchOptions  # over the second parameter
    kind: str
    first: str  # the other parameter
    first_bounds: tuple[float, float]
    # what happens where the criticality changes along the curve, and a number that vanishes there:
    # of equations, unknowns and values of all parameters
    criticality: tuple[str, Callable[[OrbitEquations, Floats, Floats], float]] | None = None

    @property
    def ranges(self) -> Floats:
        """Widths of the bounds of both parameters."""
        return np.array([high - low for low, high in (self.first_bounds, self.options.bounds)])


@dataclass(frozen=True)
class CurveStart:
    """A point of a curve; ``direction`` as `two_parameter` takes it."""

    unknowns: Floats
    p: float
    q: float
    direction: int | tuple[Floats, float]


class SpecialCondition:
    """Equations of the orbits of a word in both parameters, and the number that vanishes."""

    def __init__(
        self, asked: CurveOptions, legs: Legs, equations: OrbitEquations, test: str
    ) -> None:
        """``legs`` have derivatives by both parameters; ``test`` is as `BranchTests` names it."""
        options = asked.options
        names = list(options.system.parameters)
        self.asked, self.legs, self.equations, self.test = asked, legs, equations, test
        self._values = legs.values.copy()
        self._places = [names.index(asked.first), names.index(options.parameter)]
        self._ranges = asked.ranges
        self._of_word = BranchTests(equations, options.tolerance, whole=False, grows=test)
        self._tests = BranchTests(equations, options.tolerance, grows=test)

    def set_parameters(self, p: float, q: float) -> None:
        """Let the legs stand for values of both parameters."""
        self.legs.set_values(self._with(p, q))

    def _with(self, p: float, q: float) -> Floats:
        values = self._values.copy()
        values[self._places] = p, q
        return values

    def residual(self, u: Floats, p: float, q: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Equations with their derivatives by unknowns and both parameters."""
        self.legs.require(self._with(p, q))
        self.set_parameters(p, q)
        residual, jacobian, moved = self.equations.evaluate(u)
        return residual, jacobian, moved[:, 0], moved[:, 1]

    def number(self, u: Floats, p: float, q: float) -> tuple[float, Floats, float, float]:
        """What vanishes on the curve, and its derivatives by the unknowns and both parameters.

        They are central differences, with steps that are small beside the shortest leg.
        """
        if what_of(self.test) == "graze":
            self.set_parameters(p, q)
            self._of_word.follow_graze(u, *map(int, self.test.split(":")[1:]))
        value = self._number(u, p, q)
        z = np.concatenate([u, [p, q]])
        gradient = np.zeros(z.size)
        durations = self.equations.unpack(u).durations
        shortest = float(durations.min() / durations.sum())
        part = _STEP * min(1.0, max(_SHORT * shortest, _LEAST))
        steps = part * np.append(scale_of(self.equations, u), self._ranges)
        for i in [*self._places_of_test(), z.size - 2, z.size - 1]:
            beside = []
            for step in (steps[i], -steps[i]):
                moved = z.copy()
                moved[i] += step
                beside.append(self._number(moved[:-2], float(moved[-2]), float(moved[-1])))
            gradient[i] = (beside[0] - beside[1]) / (2.0 * steps[i])
        return value, gradient[:-2], float(gradient[-2]), float(gradient[-1])

    def _number(self, u: Floats, p: float, q: float) -> float:
        self.set_parameters(p, q)
        if self.test in OF_UNIT_CIRCLE:  # the word need not be looked at
            turn = self.equations.unpack(u)
            found = self.legs.follow(self.equations.word, turn.states, turn.instants)
            return _of_circle(floquet(self.equations, found)).get(self.test, np.nan)
        return self._of_word.look(u).tests.get(self.test, np.nan)

    def _places_of_test(self) -> list[int]:
        """Unknowns that the test depends on: of the leg that it names and the next one, or all.

        Its size is measured by other legs too, which counts for nothing where it is zero.
        """
        count, n = len(self.equations.word), self.legs.n
        if self.test in OF_UNIT_CIRCLE:
            return list(range(self.equations.size))
        number = self.test.split(":")[1]
        k = count - 1 if number == "last" else int(number)
        legs = [k, (k + 1) % count]
        instants = [count * n - 1 + j for j in (k, k + 1, k + 2) if 1 <= j <= count]
        of_states = [leg * n + i for leg in legs for i in range(n)]
        return [*of_states, *(j for j in instants if j < self.equations.size)]

    def look(self, point: Point) -> Looked:
        """The orbit of a point of the curve."""
        self.set_parameters(float(point.u[-1]), point.p)
        return self._tests.look(point.u[:-1].copy())

    def others(self, point: Point) -> Mapping[str, Any]:
        """What else may vanish: tests of the word, and ``also:...`` of codimension two."""
        looked = self.look(point)
        found = {
            name: value
            for name, value in looked.tests.items()
            if name != self.test
            and is_of_word(name)
            # on a curve of grazes the engine sees what rounding makes of them
            and (name != "motion" or self.test in OF_UNIT_CIRCLE)
        }
        also: dict[str, Any] = {**self._also(looked)}
        if also and self.asked.criticality is not None:
            name, number = self.asked.criticality
            values = self.legs.values.copy()
            also[name] = partial(number, self.equations, point.u[:-1].copy(), values)  # it is dear
        return found | {f"also:{name}": value for name, value in also.items()}

    def _also(self, looked: Looked) -> dict[str, float]:
        values = looked.multipliers.multipliers
        if not (values.size and np.all(np.isfinite(values))):
            return {}
        if self.test == "torus":
            i, j = pair_on_circle(values)
            pair = float((values[i] + values[j]).real)
            found = {name: pair - at for name, at in _RESONANCES.items()}
            values = np.delete(values, [i, j])
            return found | {"fold": _product(values - 1.0), "flip": _product(values + 1.0)}
        found = _of_circle(looked.multipliers)
        return {name: value for name, value in found.items() if name != self.test}

    def curve(self, start: CurveStart, steps: int, grows: str = "") -> Branch:
        """The curve from a start; with ``grows`` only that test is looked at."""
        looks = BranchTests(self.equations, self.asked.options.tolerance, whole=False, grows=grows)

        def tests(point: Point) -> Mapping[str, Any]:
            if not grows:
                return self.others(point)
            self.set_parameters(float(point.u[-1]), point.p)
            return {grows: looks.look(point.u[:-1].copy()).tests.get(grows, np.nan)}

        options, bounds = self.asked.options, self.asked.first_bounds
        return two_parameter(
            self.residual, self._scalar(), start.unknowns, start.p, start.q,
            direction=start.direction, step=options.step, smallest_step=options.smallest_step,
            largest_step=options.largest_step, bounds=bounds, second_bounds=options.bounds,
            steps=steps, tests=tests, parameter_scale=self._ranges[0],
            scale=scale_of(self.equations, start.unknowns), second_scale=self._ranges[1],
        )  # fmt: skip

    def point_near(self, unknowns: Floats, p: float, q: float, held: Floats) -> Held | None:
        """The point of the curve near a guess where a coordinate is what it is there.

        By multipliers alone: where an excursion is short the equations are nearly singular too.
        """
        sizes = np.append(scale_of(self.equations, unknowns), self._ranges)
        together = extended(self.residual, self.number, sizes, self.asked.options.bounds)
        return point_of_curve(together, unknowns, p, q, held)

    def _scalar(self) -> Scalar | str | Floats:
        if self.test == "fold":
            return "fold"
        return self._antiperiodic() if self.test == "flip" else self.number

    def _antiperiodic(self) -> Floats:
        """What is added to the Jacobian so that perturbations come back with the other sign.

        Its last rows are what the states become after a turn minus those at its start.
        """
        count, n = len(self.equations.word), self.legs.n
        added = np.zeros((self.equations.size, self.equations.size))
        for i in np.flatnonzero(~self.equations.drifting):
            added[(count - 1) * n + i, i] = 2.0
        return added


def _of_circle(multipliers: Floquet) -> dict[str, float]:
    """What vanishes where multipliers are on the unit circle, by the kind of point."""
    values = multipliers.multipliers
    if not np.all(np.isfinite(values)):
        return {}
    fold = _product(values - 1.0) * multipliers.poles.determinant
    return {"fold": fold} | tests_of_multipliers(multipliers)


def _product(values: Complexes) -> float:
    return float(np.prod(values).real)


def pair_on_circle(values: Complexes) -> tuple[int, int]:
    """The two multipliers whose product is nearest to one."""
    i, j = np.triu_indices(values.size, 1)
    best = int(np.argmin(np.abs(values[i] * values[j] - 1.0)))
    return int(i[best]), int(j[best])
