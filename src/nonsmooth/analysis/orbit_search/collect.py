"""All orbits that can be found from the close returns of some motions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.region import Box
from nonsmooth.analysis.orbit_search.motions import (
    PointsOfMotion,
    Return,
    close_returns,
    drawn_states,
    first_motion,
    returns_in_turn,
    sampled_motions,
    spread_of,
    states_around,
)
from nonsmooth.engine.status import Status
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.guess import Guess, cycle_guesses, part_of_turn
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest
from nonsmooth.periodic_orbits.search import equations_for, is_autonomous, solve_guess
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns

__all__ = ["Collected", "HowToCollect", "collect_orbits"]

_SHORTEST = {True: 32, False: 64}  # periods, or windows, of a motion from a start
_PER_PERIOD = {True: 4, False: 16}  # of an orbit
_PATIENCE = 10  # guesses of one word in a row that lead to nothing new
_STEPS = 20  # of Newton's method: guesses that need more seldom lead to an orbit
_SMOOTH = 20  # starts from which a cycle without events is looked for

Floats = npt.NDArray[np.float64]

_AROUND = 256  # points of a cycle without events, between which another's start is looked for
_CORRECTIONS = 4


@dataclass(frozen=True)
class HowToCollect:
    """How orbits are looked for."""

    longest: int
    record: int
    samples: int
    guesses: int
    seed: int
    match: float
    inadmissible: bool
    box: Box | None


@dataclass
class Collected:
    """Orbits, and what was tried for them."""

    members: list[Member] = field(default_factory=list)
    motions: int = 0
    inadmissible_starts: int = 0
    tried: int = 0
    led_to_orbits: int = 0
    no_motion: int = 0  # solutions that are no motion
    longer: int = 0  # orbits of more turns than are asked for
    failed: int = 0
    interrupted: bool = False
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)  # of starts without region


def collect_orbits(wanted: OrbitRequest, how: HowToCollect, legs: Legs) -> Collected:
    """Look for orbits; Ctrl-C ends the search and keeps what was found."""
    found = Collected()
    work = how.samples + how.longest * how.guesses
    try:
        with HeldInterrupts() as held, Progress("looking for orbits", work) as progress:

            def report(done: int) -> None:
                progress.update(done)
                held.check()

            search = _Collection(wanted, how, legs, found, report)
            try:
                search.run()
            finally:
                search.keep()
    except KeyboardInterrupt:
        found.interrupted = True
    return found


class _Collection:
    """The search on its way."""

    def __init__(
        self, wanted: OrbitRequest, how: HowToCollect, legs: Legs, found: Collected,
        report: Callable[[int], None],
    ) -> None:  # fmt: skip
        self.wanted, self.how, self.legs, self.found = wanted, how, legs, found
        self.report, self.driven = report, not is_autonomous(legs)
        names = legs.system.states
        self.drifting = np.array([name in legs.system.drift_states for name in names])
        self.angle_periods = periods_of_states(legs.system)
        self.origin = np.array([legs.system.rest_state[name] for name in names])
        self.set: OrbitSet | None = None

    def run(self) -> None:
        """Motions first, then guesses for one period after the other."""
        motions = list(self._motions())
        self.spread = spread_of(motions, self.drifting, self.angle_periods)
        self.set = OrbitSet(self.legs, self.spread, self.how.match)
        smooth = not self.driven and not any(len(motion.points) for motion in motions)
        if smooth:
            self._smooth_cycles()
        for n in range(1, 1 + (0 if smooth else self.how.longest)):
            returns = close_returns(motions, n, self.spread, self.angle_periods, self.how.guesses)
            self._solve_returns(motions, returns, replace(self.wanted, period=n))

    def _solve_returns(
        self, motions: list[PointsOfMotion], returns: list[Return], wanted: OrbitRequest
    ) -> None:  # fmt: skip
        """Guesses for one period; words that lead to nothing new any more are left."""
        before = self.how.samples + (wanted.period - 1) * self.how.guesses
        idle: Counter[bytes] = Counter()
        tried = 0
        for each in returns_in_turn(motions, returns, self.spread):
            motion = motions[each.motion]
            key = motion.word_key(each.i, each.j)
            if idle[key] >= _PATIENCE:
                continue
            point = motion.points[each.i]
            turned = whole_turns(point, self.angle_periods)
            shift = np.where(self.drifting, point - self.origin, turned)
            guess = motion.guess(each.i, each.j, shift)
            new = guess is not None and self._solve(wanted, guess)
            idle[key] = 0 if new else idle[key] + 1
            tried += 1
            self.report(before + tried)
            if tried >= self.how.guesses:
                break

    def keep(self) -> None:
        """Write down what was found."""
        if self.set is not None:
            self.found.members = self.set.sort()

    def _motions(self) -> Iterator[PointsOfMotion]:
        how, tables, system = self.how, self.legs.tables, self.legs.system
        first = first_motion(self.wanted, tables, how.record, self.driven)
        if first.status == Status.INTERRUPTED:
            raise KeyboardInterrupt
        yield first
        if how.box is not None:
            states = drawn_states(how.box, how.samples, how.seed)
        else:
            states, self.found.ranges = states_around(
                system, first, self.drifting, how.samples, how.seed
            )
        self.starts = states
        periods = max(_SHORTEST[self.driven], _PER_PERIOD[self.driven] * how.longest)
        drawn = sampled_motions(self.wanted, tables, states, periods, self.driven)
        for done, motion in enumerate(drawn):
            self.report(done)
            if motion is None:
                self.found.inadmissible_starts += 1
            elif motion.status == Status.INTERRUPTED:
                raise KeyboardInterrupt
            else:
                self.found.motions += 1
                yield motion

    def _smooth_cycles(self) -> None:
        """Cycles without events, once around from where motions have settled."""
        system, names = self.legs.system, self.legs.system.states
        initials = [self.wanted.initial]
        initials += [dict(zip(names, each, strict=True)) for each in self.starts[:_SMOOTH].tolist()]
        for done, initial in enumerate(initials):
            self.report(self.how.samples + done)
            try:
                guesses = cycle_guesses(
                    system, initial, period=1, transient=self.how.record, mode=None,
                    tolerance=self.wanted.tolerance,
                )  # fmt: skip
                guess = next(guesses, None)
            except (RunError, ValueError):
                guess = None
            if guess is None:
                self.found.tried += 1
                self.found.failed += 1
            else:
                self._solve(replace(self.wanted, period=1), guess)

    def _solve(self, wanted: OrbitRequest, guess: Guess) -> bool:
        """An orbit from a guess, counted; whether it is a new one."""
        assert self.set is not None
        self.found.tried += 1
        orbit = self._orbit(wanted, guess)
        if orbit is None:
            self.found.failed += 1
        elif orbit.period > self.how.longest:
            self.found.longer += 1
        elif not orbit.admissibility.admissible and not self.how.inadmissible:
            self.found.no_motion += 1
        else:
            self.found.led_to_orbits += 1
            return self.set.add(orbit)
        return False

    def _orbit(self, wanted: OrbitRequest, guess: Guess) -> Orbit | None:
        """The orbit of a guess, passed through once."""
        try:
            equations = equations_for(wanted, self.legs, guess)
            solution = solve_orbit(equations, equations.pack(guess.turn), steps=_STEPS)
            if solution.status != "completed":
                return None
            near = Guess(guess.word, equations.unpack(solution.unknowns))
            orbit = solve_guess(wanted, self.legs, near).orbit
            while orbit is not None and orbit.primitive > 1:
                shorter = replace(wanted, period=max(wanted.period // orbit.primitive, 1))
                near = part_of_turn(orbit.word, orbit.turn, orbit.primitive)
                orbit = solve_guess(shorter, self.legs, near).orbit
                wanted = shorter
        except LegError:
            return None
        if orbit is None or self.driven:
            return orbit
        return replace(orbit, period=turns_of(orbit))


def turns_of(orbit: Orbit) -> int:
    """Returns to the event that a turn passes most often; 1 of a cycle without events."""
    word = orbit.word
    if not word.closes_at_event:
        return 1
    return max(Counter(zip(word.modes, word.paths, strict=True)).values())


@dataclass
class Member:
    """An orbit of a set, and how often it was found."""

    orbit: Orbit
    points: Floats  # (P, n): strobes of a driven orbit, states behind the events of any other
    found: int = 1


class OrbitSet:
    """Orbits that differ by more than where they begin."""

    def __init__(self, legs: Legs, spread: Floats, match: float) -> None:
        """``spread`` tells what counts as large, infinite for drifts; ``match`` is a part of it."""
        self._legs, self._spread, self._match = legs, spread, match
        self._angle_periods = periods_of_states(legs.system)
        self.members: list[Member] = []

    def add(self, orbit: Orbit) -> bool:
        """Count an orbit; whether it is a new one. A motion takes the place of what is none."""
        points = self._points(orbit)
        for member in self.members:
            if self._same(orbit, points, member):
                if orbit.admissibility.admissible and not member.orbit.admissibility.admissible:
                    member.orbit, member.points = orbit, points
                member.found += 1
                return False
        self.members.append(Member(orbit, points))
        return True

    def sort(self) -> list[Member]:
        """Shortest period first, then the most stable, then by the state at the start."""
        return sorted(self.members, key=_rank)

    def _points(self, orbit: Orbit) -> Floats:
        turn, word = orbit.turn, orbit.word
        if orbit.autonomous:
            return turn.states
        instants = turn.instants[0] + np.arange(orbit.period) * orbit.window
        legs = np.searchsorted(turn.instants[1:-1], instants, side="right")
        opened = Word(tuple(word.modes[k] for k in legs), ((),) * len(legs))
        begins = turn.instants[legs]
        found = self._legs.follow_each(opened, turn.states[legs], begins, instants)
        return found.ends.copy()

    def _same(self, orbit: Orbit, points: Floats, member: Member) -> bool:
        other = member.orbit
        if orbit.period != other.period or points.shape != member.points.shape:
            return False
        if abs(orbit.length - other.length) > self._match * max(orbit.length, other.length):
            return False
        if orbit.autonomous and not orbit.word.closes_at_event:
            return other.word.modes == orbit.word.modes and self._on_cycle(points[0], other)
        for shift in range(len(points)):
            change = np.roll(points, -shift, axis=0) - member.points
            apart = np.abs(change - whole_turns(change, self._angle_periods)) / self._spread
            if apart.max() > self._match:
                continue
            if not orbit.autonomous or _shifted(orbit.word, shift) == other.word:
                return True
        return False

    def _on_cycle(self, point: Floats, cycle: Orbit) -> bool:
        """Whether a cycle without events passes through a point."""
        word, turn = cycle.word, cycle.turn
        count = _AROUND
        times = turn.instants[0] + cycle.length * np.arange(count) / count
        opened = Word(word.modes * count, ((),) * count)
        states = np.repeat(turn.states, count, axis=0)
        begins = np.full(count, turn.instants[0])
        around = self._legs.follow_each(opened, states, begins, times).ends
        away = point - around
        turned = whole_turns(away, self._angle_periods)
        apart = (np.abs(away - turned) / self._spread).max(axis=1)
        point = point - turned[int(np.argmin(apart))]
        instant = times[int(np.argmin(apart))]
        drifts = np.isinf(self._spread)
        for _ in range(_CORRECTIONS):
            here = self._legs.follow_each(
                word, turn.states, turn.instants[:1], np.array([instant])
            ).ends[0].copy()  # fmt: skip
            at_rest = self._legs.follow_each(
                word, here[None], np.array([instant]), np.array([instant])
            )
            rate = np.where(drifts, 0.0, at_rest.start_rates[0] / self._spread)
            off = np.where(drifts, 0.0, point - here) / self._spread
            off[drifts] = 0.0
            instant += float(rate @ off) / max(float(rate @ rate), 1e-300)
        return bool(np.abs(off).max() <= self._match)


def _shifted(word: Word, shift: int) -> Word:
    return Word(word.modes[shift:] + word.modes[:shift], word.paths[shift:] + word.paths[:shift])


def _rank(member: Member) -> tuple[float, ...]:
    orbit = member.orbit
    values = np.abs(orbit.multipliers.multipliers)
    largest = float(values.max(initial=0.0)) if np.all(np.isfinite(values)) else np.inf
    return (orbit.period, round(largest, 9), *np.round(orbit.turn.states[0], 9).tolist())
