"""A periodic orbit that was found, or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.admissibility import Admissibility, check_admissible
from nonsmooth.periodic_orbits.cycle_plane import spread_of
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.multipliers import Floquet, floquet
from nonsmooth.periodic_orbits.newton import AT_ZERO, Solution
from nonsmooth.periodic_orbits.strobes import NO_STROBES, Strobes, strobes_of
from nonsmooth.periodic_orbits.symmetric import Reflection, reflection
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.runs.whole_turns import whole_turns
from nonsmooth.system.system import System

__all__ = ["Orbit", "OrbitRequest", "OrbitResult", "make_orbit", "primitive_parts"]

Floats = npt.NDArray[np.float64]

_NEUTRAL = 1e-10  # distance from the unit circle that rounding may make
_MOST_TURNS = 1200  # of a cycle: as many as its guess can have
_PRIMES = np.array(
    [k for k in range(2, _MOST_TURNS) if all(k % d for d in range(2, math.isqrt(k) + 1))]
)
_SAME = 1e-7  # part of the size of a state within which parts of an orbit are the same


@dataclass(frozen=True)
class Orbit:
    """An orbit of one word for one set of parameter values."""

    word: Word
    turn: Turn
    end: Floats  # (n,) state at the end of the turn, drifts included
    values: Floats  # of all parameters
    period: int
    phase: float
    autonomous: bool
    window: float
    residual: float
    iterations: int
    multipliers: Floquet
    admissibility: Admissibility
    primitive: int = 1  # how often the turn repeats a shorter orbit
    drifting: npt.NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    in_family: bool = False  # whether cycles of other sizes lie beside it
    reflection: Reflection | None = None  # under the declared symmetry
    strobes: Strobes = NO_STROBES

    @property
    def length(self) -> float:
        """Time of one turn."""
        return float(self.turn.instants[-1] - self.turn.instants[0])

    @property
    def drift(self) -> Floats:
        """Change of each state over the turn, zero but for drifts, angles and rounding."""
        return np.asarray(self.end - self.turn.states[0])

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the unit circle."""
        if self.in_family:
            return False  # one is 1, whatever rounding makes of it
        values = self.multipliers.multipliers
        return bool(np.all(np.isfinite(values)) and np.all(np.abs(values) < 1.0 - _NEUTRAL))


@dataclass(frozen=True)
class OrbitRequest:
    """What orbit is looked for."""

    system: System
    initial: Any
    period: int
    phase: float
    transient: int
    mode: str | None
    words: tuple[Word, ...]  # none where the word is that of the motion
    tolerance: float
    longest: int = 0  # transient, where the motion has not settled by the first one


@dataclass(frozen=True)
class OrbitResult:
    """An orbit with the equations that it solves, or a status and what to try."""

    orbit: Orbit | None
    equations: OrbitEquations | None
    status: str
    message: str
    transient: int | None = None  # behind which it was found, where that is not the one asked for


def make_orbit(
    equations: OrbitEquations, solution: Solution, tolerance: float, *, check: bool = True
) -> Orbit:
    """Orbit of a solution, with multipliers and, with ``check``, its admissibility."""
    turn = equations.unpack(solution.unknowns.copy())
    legs = equations.legs
    found = legs.follow(equations.word, turn.states, turn.instants)
    turn = Turn(found.starts.copy(), turn.instants)
    end = found.nexts[-1].copy()
    multipliers = floquet(equations, found)
    admissibility = Admissibility(True)
    if check:
        admissibility = check_admissible(equations, turn, tolerance)
    return Orbit(
        equations.word, turn, end, legs.values.copy(), equations.period, equations.phase,
        equations.autonomous, legs.window, solution.residual, solution.iterations, multipliers,
        admissibility, primitive_parts(equations, turn), equations.drifting,
        reflection=reflection(equations, turn), strobes=strobes_of(equations, turn),
    )  # fmt: skip


def primitive_parts(equations: OrbitEquations, turn: Turn, within: float = _SAME) -> int:
    """How many times a turn passes through the same shorter orbit, or nearly the same one."""
    word, count = equations.word, equations.word.n_events
    if equations.is_smooth_cycle:
        return _turns_of_cycle(equations, turn, within)
    if not equations.autonomous:
        parts = [d for d in range(equations.period, 1, -1) if equations.period % d == 0]
    else:
        parts = [d for d in range(count, 1, -1) if count % d == 0]
    drifts = equations.drifting
    states = np.where(drifts, 0.0, turn.states)
    size = np.abs(states).max(axis=0)
    largest = float(size.max(initial=0.0))
    # a state that is zero at all events, or all of them
    size = np.maximum(size, 1e-6 * largest if largest > AT_ZERO else 1.0)
    length = float(turn.instants[-1] - turn.instants[0])
    first = 0 if word.closes_at_event else 1  # the leg at the section is cut by it
    for part in parts:
        if count % part:
            continue
        step = count // part
        if count == 0:
            if _repeats_smoothly(equations, turn, part, within * size):
                return part
            continue
        starts = np.arange(first, first + count)
        later = first + (starts - first + step) % count
        if any(word.modes[i] != word.modes[k] for i, k in zip(starts, later, strict=True)):
            continue
        times = turn.instants[starts]
        gaps = (turn.instants[later] - times) % length
        near_time = np.abs(gaps - length / part) <= within * length
        apart = states[later] - states[starts]
        near = np.abs(apart - whole_turns(apart, equations.angle_periods)) <= within * size
        if np.all(near) and np.all(near_time):
            return part
    return 1


def _repeats_smoothly(equations: OrbitEquations, turn: Turn, part: int, off: Floats) -> bool:
    """Whether an orbit without events is back where it began after a part of its turn."""
    return bool(np.all(_gaps_after(equations, turn, np.array([part]))[0] <= off))


def _gaps_after(equations: OrbitEquations, turn: Turn, parts: npt.NDArray[np.int64]) -> Floats:
    """How far an orbit without events is from where it began after some parts of its turn, (K, n).

    A part of 3 is a third of the turn.
    """
    begins = np.full(parts.size, turn.instants[0])
    ends = begins + (turn.instants[-1] - turn.instants[0]) / parts
    word = Word(equations.word.modes[:1] * parts.size, ((),) * parts.size)
    states = np.tile(turn.states[0], (parts.size, 1))
    gaps = equations.legs.follow_each(word, states, begins, ends).ends - turn.states[0]
    return np.abs([gap - equations.carried(gap) for gap in gaps])


def _turns_of_cycle(equations: OrbitEquations, turn: Turn, within: float) -> int:
    """How often a cycle without events passes where it began, beside by how much it varies.

    It is back after each part of the turn whose number divides this one: the parts of all primes
    take little longer to look at than the turn itself, and together they are all around it.
    """
    gaps = _gaps_after(equations, turn, _PRIMES)
    off = within * spread_of(np.vstack([np.zeros(gaps.shape[1]), gaps]))
    parts = 1
    for prime in _PRIMES[np.all(gaps <= off, axis=1)].tolist():
        while _repeats_smoothly(equations, turn, parts * prime, off):
            parts *= prime
            if parts > _MOST_TURNS:
                return 1  # it does not move
    return parts
