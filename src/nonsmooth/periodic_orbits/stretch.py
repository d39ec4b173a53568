"""A stretch of a branch of orbits that has one word: what the continuation is asked with."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.follow import follow
from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.branch_tests import (
    BranchTests,
    Looked,
    is_of_word,
    largest_along,
    states_along,
    what_of,
)
from nonsmooth.periodic_orbits.cycle_plane import spread_of, spread_of_cycle
from nonsmooth.periodic_orbits.cycle_size import scale_of_cycle, size_of_cycle
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.multipliers import UNBOUNDED
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.trail import Trail
from nonsmooth.system.system import System

__all__ = [
    "MODULUS",
    "BranchOptions",
    "BranchStart",
    "BranchStretch",
    "scale_along",
    "spread_along",
]

Floats = npt.NDArray[np.float64]

# test of one multiplier by its size: several that cross the unit circle at once may leave the signs
# of all products as they are
MODULUS = "modulus"
_OUTGROWN = 2.0  # times the size at the start of a stretch
_FARTHEST = 2.0  # times the largest step that a cycle may change by both of its measures
_ALWAYS = ("leg", "short")  # changes of the word behind which its equations mean nothing


@dataclass(frozen=True)
class BranchOptions:
    """How a branch is followed."""

    system: System
    parameter: str
    bounds: tuple[float, float]
    period: int
    phase: float
    autonomous: bool
    steps: int
    step: float
    largest_step: float
    smallest_step: float
    tolerance: float
    inadmissible: bool  # go on with the word where its orbit is no motion


@dataclass
class BranchStart:
    """Where a stretch begins; ``grows`` is the test that is zero there.

    ``way`` is the sign of the parameter along the first orbits, 0 where they were not tried. The
    direction does not tell it where the parameter changes with the square of what grows.
    """

    equations: OrbitEquations
    unknowns: Floats
    value: float
    direction: tuple[Floats, float]
    grows: str = ""
    kind: str = ""
    detail: str = ""
    located: bool = False  # whether the change itself is located behind the start
    way: float = 0.0


class BranchStretch:
    """A stretch of a branch with one word."""

    def __init__(
        self, options: BranchOptions, legs: Legs, equations: OrbitEquations, grows: str = "",
        least: Floats | None = None, trail: Trail | None = None,
    ) -> None:  # fmt: skip
        """``least``: sizes of the states below which no step is measured, (n,)."""
        self.trail = Trail() if trail is None else trail
        self.least = np.zeros(legs.n) if least is None else least
        self.options, self.legs, self.equations = options, legs, equations
        self.tests = BranchTests(equations, options.tolerance, grows=grows)
        self.scale = np.ones(equations.size)
        self._is_small = False  # a cycle beside the states that it lies at
        self._values = legs.values.copy()
        # whether the sizes of multipliers are looked at, the largest, the second largest and so on
        self.each_multiplier = False
        self.place = list(legs.system.parameters).index(options.parameter)

    def set_parameter(self, p: float) -> None:
        """Let the legs stand for a value of the parameter."""
        values = self._values.copy()
        values[self.place] = p
        self.legs.require(values)
        self.legs.set_values(values)

    def residual(self, u: Floats, p: float) -> tuple[Floats, Floats, Floats]:
        """Equations of the orbit with their derivatives by the unknowns and the parameter."""
        self.set_parameter(p)
        residual, jacobian, moved = self.equations.evaluate(u)
        return residual, jacobian, moved[:, 0]

    def look(self, point: Point) -> Looked:
        """The orbit of a point, with its multipliers and tests."""
        self.set_parameter(point.p)
        return self.tests.look(point.u)

    def asked(self, point: Point) -> Mapping[str, float | Callable[[], float]]:
        """Tests of a point; without most of those of the word where it need not be a motion."""
        looked = self.look(point)
        tests: dict[str, float | Callable[[], float]] = {
            name: value
            for name, value in looked.tests.items()
            if not self.options.inadmissible or what_of(name) in _ALWAYS or not is_of_word(name)
        }
        sizes = np.sort(np.abs(looked.multipliers.multipliers))[::-1]
        tests |= {f"{MODULUS}:{k}": partial(self._outside, size) for k, size in enumerate(sizes)}
        if not self.options.inadmissible:
            tests |= {name: partial(self._since, name, v) for name, v in looked.quiet.items()}
        return tests

    def _since(self, name: str, value: float) -> float:
        """A test of a start that lies at its zero; nan as long as it is zero all along."""
        return value if self.tests.counts(name) else np.nan

    def _outside(self, size: float) -> float:
        """How far outside the unit circle a multiplier is; nan while nobody has to know."""
        return float(size) - 1.0 if self.each_multiplier and size <= UNBOUNDED else np.nan

    def remember(self, point: Point) -> None:
        """A point becomes one of those where the branch has been."""
        low, high = self.options.bounds
        self.trail.add(self.equations.word, point, self.scale, high - low)

    def outgrown(self, point: Point) -> bool:
        """Whether an orbit has another size, or length, than that by which steps are measured."""
        n_states = len(self.equations.word) * self.legs.n
        scale = self._scale_of(point.u, point.p, (point.tangent_u, point.tangent_p))
        share = scale / self.scale
        sizes, lengths = share[:n_states].max(), share[n_states:].max(initial=1.0)
        return any(not 1.0 / _OUTGROWN <= largest <= _OUTGROWN for largest in (sizes, lengths))

    def changes_too_much(self, first: Point, last: Point) -> bool:
        """Whether a step changes a cycle more than both of its measures allow.

        Steps are measured by what changed where the stretch began, which may turn on the way.
        """
        if not self._is_small:
            return False
        try:
            self.set_parameter(first.p)
            before = size_of_cycle(self.equations, first.u)
            self.set_parameter(last.p)
            place, form = before.change_to(size_of_cycle(self.equations, last.u))
        except LegError:
            return False
        change = np.sqrt(np.mean(place**2 + form**2))
        return bool(change > _FARTHEST * self.options.largest_step)

    def _scale_of(self, unknowns: Floats, value: float, direction: tuple[Floats, float]) -> Floats:
        """What counts as large for each unknown, for an orbit and the direction of the branch."""
        scale, count = scale_along(self.equations, unknowns), len(self.equations.word)
        states = slice(0, count * self.legs.n)
        if self.equations.autonomous:
            found = scale_of_cycle(
                self.equations, unknowns, value, direction, self.options.bounds, self.set_parameter
            )
            scale[states] = np.tile(found, count)
        scale[states] = np.maximum(scale[states], np.tile(self.least, count))
        return scale

    def branch(
        self, start: BranchStart, steps: int, accept: Callable[[Sequence[Point]], bool],
        home: BranchStart,
    ) -> Branch:  # fmt: skip
        """The branch from a start, of steps that are accepted.

        It is closed where it comes to ``home``, at which its first stretch began.
        """
        low, high = self.options.bounds
        self.set_parameter(start.value)
        self.scale = self._scale_of(start.unknowns, start.value, start.direction)
        spread = scale_along(self.equations, start.unknowns)
        self._is_small = self.equations.autonomous and not np.array_equal(spread, self.scale)
        branch = follow(
            self.residual, start.unknowns, start.value, direction=start.direction,
            step=self.options.step, smallest_step=self.options.smallest_step,
            largest_step=self.options.largest_step, bounds=self.options.bounds, steps=steps,
            tests=self.asked, scale=self.scale, parameter_scale=high - low, accept=accept,
        )  # fmt: skip
        if self.equations.angle_periods.any():
            branch.repeats(self.equations.whole_turns)
        # of cycles without events it is told on the plane of this stretch
        there = self._as_begun_here(home) if home is not start else None
        if there is not None:
            branch.begun_at(there[0], home.value, there[1])
        return branch

    def _as_begun_here(self, home: BranchStart) -> tuple[Floats, tuple[Floats, float]] | None:
        """Unknowns and direction of an orbit, begun at an event where it has the word of this one.

        A cycle that nothing drives may begin at any of its events; None where it has another word.
        """
        word, (du, dp) = home.equations.word, home.direction
        if word == self.equations.word:
            return home.unknowns, home.direction
        n, count = self.legs.n, len(word)
        same = [k for k in range(1, count) if word.begun_at(k) == self.equations.word]
        if not same or not word.closes_at_event:
            return None
        k, turn = same[0], home.equations.unpack(home.unknowns)
        self.set_parameter(home.value)
        ends = self.legs.follow(word, turn.states, turn.instants).nexts[-1]
        states = np.roll(turn.states, -k, axis=0)
        states[count - k :] += home.equations.carried(ends - turn.states[0])
        states -= np.where(self.equations.drifting, states[0] - self.equations.origin, 0.0)
        durations, change = turn.durations, np.diff(du[count * n :], prepend=0.0)
        unknowns = self.equations.pack(Turn(states, _instants(np.roll(durations, -k))))
        moved = Turn(
            np.roll(du[: count * n].reshape(count, n), -k, axis=0), _instants(np.roll(change, -k))
        )
        return unknowns, (self.equations.pack(moved), dp)


def _instants(durations: Floats) -> Floats:
    return np.concatenate([[0.0], np.cumsum(durations)])


def scale_along(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """What counts as large for each unknown, states within the legs included.

    Where an orbit grazes, its velocity at the events is small and not so in between: steps of a
    branch that were measured by it would be tiny. A cycle of a system that nothing drives may be
    small beside the state that it surrounds: steps that were measured by that would lead past its
    end.
    """
    scale, count = scale_of(equations, unknowns), len(equations.word)
    n_states = count * equations.legs.n
    if equations.autonomous:
        scale[:n_states] = np.tile(spread_along(equations, unknowns), count)
        return scale
    size = largest_along(equations, equations.unpack(unknowns))
    scale[:n_states] = np.maximum(scale[:n_states], np.tile(size, count))
    return scale


def spread_along(equations: OrbitEquations, unknowns: Floats) -> Floats:
    """By how much each state varies along an orbit, wherever its middle is; (n,), positive."""
    if equations.is_smooth_cycle:
        return spread_of_cycle(equations, unknowns)
    return spread_of(states_along(equations, equations.unpack(unknowns)))
