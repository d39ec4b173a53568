"""Periodic orbits built leg by leg from closed forms, in 60 digits: no step, no tangent flow.

A *leg* is a stay in one mode: its flow, the guard that ends it, and what happens there. A *turn*
follows all legs once, each for the time after which its guard is zero. Newton's method closes it,
with central differences of 20 digits' step for derivatives: 40 digits remain, so multipliers come
by a route that knows nothing of saltation. A turn takes the word that it is given and does not ask
whether other guards are passed on the way.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from mpmath import matrix, mp, mpf

DIGITS = 60  # to be set by those who call, with mp.workdps


def step() -> mpf:
    """Of central differences: a third of the digits, so that two thirds remain."""
    return mpf(10) ** -(mp.dps // 3)


def closed() -> mpf:
    """How small Newton's last change must be."""
    return mpf(10) ** -(2 * mp.dps // 3)


State = tuple[mpf, ...]


class NoOrbit(ArithmeticError):
    """Newton's method does not converge, or a guard has no zero near its guess."""


class Leg(NamedTuple):
    """``flow(state, time, duration)``; ``guard(state, time)`` is zero at the end of the leg."""

    mode: str
    flow: Callable[[State, mpf, mpf], State]
    guard: Callable[[State, mpf], mpf] | None = None  # None: ends at the section
    after: Callable[[State, mpf], State] | None = None


@dataclass(frozen=True)
class Course:
    """Legs in order from the section at time ``start``; ``span`` is the time of a turn.

    ``onto`` makes a full state of the free ones, ``off`` takes these from a full state. A span of
    None is that of an autonomous system, whose last leg ends at a guard too.
    """

    legs: Sequence[Leg]
    onto: Callable[[State], State]
    off: Callable[[State], State]
    span: mpf | None
    start: mpf = field(default_factory=lambda: mpf(0))


class Turn(NamedTuple):
    """Durations and first states of the legs, and the state at the end."""

    durations: tuple[mpf, ...]
    states: tuple[State, ...]
    end: State


class Orbit(NamedTuple):
    """A closed turn; ``free`` are the unknowns on the section, ``tangent`` is their derivative."""

    course: Course
    free: State
    turn: Turn
    tangent: matrix

    @property
    def multipliers(self) -> list[mpf]:
        """Eigenvalues by size, largest first, those of the contracted directions left out."""
        return sorted(mp.eig(self.tangent, left=False, right=False), key=lambda m: -abs(m))


def take_turn(course: Course, free: Sequence[mpf], guesses: Sequence[mpf]) -> Turn:
    """Follow the legs; ``guesses`` are the durations of all of them (that of the last may lack)."""
    state, time = course.onto(tuple(free)), course.start
    durations, states = [], []
    for i, leg in enumerate(course.legs):
        states.append(state)
        if leg.guard is None:
            duration = course.start + course.span - time
        else:
            duration = _until(leg, state, time, mpf(guesses[i]))
        state = leg.flow(state, time, duration)
        time += duration
        if leg.after is not None:
            state = leg.after(state, time)
        durations.append(duration)
    return Turn(tuple(durations), tuple(states), state)


def _until(leg: Leg, state: State, time: mpf, guess: mpf) -> mpf:
    """The zero of the guard near the guess, by secants."""

    def gap(s: mpf) -> mpf:
        return leg.guard(leg.flow(state, time, s), time + s)

    old, new = guess, guess * (1 + mpf(10) ** -10)
    before, now = gap(old), gap(new)
    for _ in range(60):
        if now == before:
            return new
        old, new = new, new - now * (new - old) / (now - before)
        if abs(new - old) < mpf(10) ** (-mp.dps + 6):
            return new
        before, now = now, gap(new)
    raise NoOrbit(f"the guard that ends {leg.mode} has no zero near {mp.nstr(guess, 10)}")


def tangent(course: Course, free: State, guesses: Sequence[mpf]) -> matrix:
    """Derivative of the free states after a turn by those before it."""
    columns = []
    for j in range(len(free)):
        ends = [
            course.off(take_turn(course, _moved(free, j, sign * step()), guesses).end)
            for sign in (1, -1)
        ]
        columns.append([(a - b) / (2 * step()) for a, b in zip(*ends, strict=True)])
    return matrix(columns).T


def _moved(free: State, j: int, by: mpf) -> State:
    return tuple(x + by if i == j else x for i, x in enumerate(free))


def close(course: Course, free: Sequence, guesses: Sequence, steps: int = 30) -> Orbit:
    """The periodic orbit near ``free``."""
    free, guesses = tuple(map(mpf, free)), tuple(map(mpf, guesses))
    for _ in range(steps):
        turn = take_turn(course, free, guesses)
        if min(turn.durations) <= 0:
            raise NoOrbit("a leg of negative duration")
        miss = matrix([a - b for a, b in zip(course.off(turn.end), free, strict=True)])
        slope = tangent(course, free, turn.durations)
        change = mp.lu_solve(slope - mp.eye(len(free)), -miss)
        free = tuple(x + c for x, c in zip(free, change, strict=True))
        guesses = turn.durations
        if mp.norm(change) < closed():
            return Orbit(course, free, take_turn(course, free, guesses), slope)
        if mp.norm(change) > 10**6:
            break
    raise NoOrbit("Newton's method does not converge")


def where(
    make: Callable[[mpf], Course],
    test: Callable[[Orbit], mpf],
    near: Sequence,
    orbit: Orbit | tuple[Sequence, Sequence],
) -> tuple[mpf, Orbit]:
    """The parameter at which ``test`` of the orbit is zero, by secants from two values ``near``."""
    free, guesses = (orbit.free, orbit.turn.durations) if isinstance(orbit, Orbit) else orbit
    old, new = map(mpf, near)
    found = close(make(old), free, guesses)
    before = test(found)
    for _ in range(40):
        found = close(make(new), found.free, found.turn.durations)
        now = test(found)
        old, new = new, new - now * (new - old) / (now - before)
        if abs(new - old) < mpf(10) ** -35:
            return new, close(make(new), found.free, found.turn.durations)
        before = now
    raise NoOrbit("the secants do not converge")


def characteristic(orbit: Orbit, at: int) -> mpf:
    """det(tangent - at): zero where a multiplier is ``at``."""
    return mp.det(orbit.tangent - at * mp.eye(len(orbit.free)))


def fold(
    make: Callable[[mpf], Course], near: mpf, free: Sequence, guesses: Sequence
) -> tuple[mpf, Orbit]:
    """The parameter at which a multiplier is 1, with the orbit: Newton in orbit and parameter."""
    unknown = (*map(mpf, free), mpf(near))
    guesses = tuple(map(mpf, guesses))

    def miss(values: State) -> list[mpf]:
        course, free = make(values[-1]), values[:-1]
        turn = take_turn(course, free, guesses)
        slope = tangent(course, free, turn.durations)
        gaps = [a - b for a, b in zip(course.off(turn.end), free, strict=True)]
        return [*gaps, mp.det(slope - mp.eye(len(free)))]

    small = mpf(10) ** -18
    for _ in range(40):
        here = miss(unknown)
        columns = [
            [(a - b) / small for a, b in zip(miss(_moved(unknown, j, small)), here, strict=True)]
            for j in range(len(unknown))
        ]
        change = mp.lu_solve(matrix(columns).T, -matrix(here))
        unknown = tuple(x + c for x, c in zip(unknown, change, strict=True))
        course = make(unknown[-1])
        guesses = take_turn(course, unknown[:-1], guesses).durations
        if mp.norm(change) < mpf(10) ** -30:
            slope = tangent(course, unknown[:-1], guesses)
            turn = take_turn(course, unknown[:-1], guesses)
            return unknown[-1], Orbit(course, unknown[:-1], turn, slope)
    raise NoOrbit("Newton's method does not converge to a fold")


def lasting(
    make: Callable[[mpf], Course], leg: int, duration, near, free: Sequence, guesses: Sequence
) -> tuple[mpf, Orbit]:
    """The parameter for which a leg lasts so long, and the orbit: regular at folds and grazing.

    The unknowns are the free states, the other durations and the parameter; each guard is zero
    at the end of its leg.
    """
    n, legs = len(free), len(make(mpf(near)).legs)
    unknown = (*map(mpf, free), *map(mpf, guesses[: legs - 1]), mpf(near))
    small = mpf(10) ** -25

    def miss(values: State) -> list[mpf]:
        course, lasts = make(values[-1]), values[n:-1]
        turn, gaps = _timed_turn(course, values[:n], lasts)
        closing = [a - b for a, b in zip(course.off(turn.end), values[:n], strict=True)]
        return [*closing, *gaps, lasts[leg] - mpf(duration)]

    for _ in range(60):
        here = miss(unknown)
        columns = [
            [(a - b) / small for a, b in zip(miss(_moved(unknown, j, small)), here, strict=True)]
            for j in range(len(unknown))
        ]
        change = mp.lu_solve(matrix(columns).T, -matrix(here))
        unknown = tuple(x + c for x, c in zip(unknown, change, strict=True))
        if mp.norm(change) < mpf(10) ** -32:
            course = make(unknown[-1])
            turn, _ = _timed_turn(course, unknown[:n], unknown[n:-1])
            slope = tangent(course, unknown[:n], turn.durations)
            return unknown[-1], Orbit(course, unknown[:n], turn, slope)
    raise NoOrbit("Newton's method does not converge to an orbit with this duration")


def _timed_turn(
    course: Course, free: Sequence[mpf], lasts: Sequence[mpf]
) -> tuple[Turn, list[mpf]]:
    """A turn whose legs last so long, whatever their guards are then, and those guards."""
    state, time = course.onto(tuple(free)), course.start
    durations, states, gaps = [], [], []
    for i, leg in enumerate(course.legs):
        states.append(state)
        duration = lasts[i] if leg.guard else course.start + course.span - time
        state = leg.flow(state, time, duration)
        time += duration
        if leg.guard:
            gaps.append(leg.guard(state, time))
        if leg.after is not None:
            state = leg.after(state, time)
        durations.append(duration)
    return Turn(tuple(durations), tuple(states), state), gaps


def repeated(course: Course, times: int) -> Course:
    """The same course several times over, as one turn; its legs at the section stay apart."""
    legs = []
    for k in range(1, times + 1):
        last = k == times
        for leg in course.legs:
            if leg.guard is None and not last:
                end = course.start + k * course.span
                legs.append(replace_guard(leg, end))
            else:
                legs.append(leg)
    return replace(course, legs=legs, span=times * course.span)


def replace_guard(leg: Leg, end: mpf) -> Leg:
    """The leg, to end at a time."""
    return leg._replace(guard=lambda state, time: time - end)
