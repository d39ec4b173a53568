"""All orbits that can be found from the close returns of some motions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from nonsmooth.analysis.basins.region import Box
from nonsmooth.analysis.orbit_search.close_returns import (
    Return,
    close_returns,
    returns_in_turn,
    spread_of,
)
from nonsmooth.analysis.orbit_search.motions import Motion, first_motion
from nonsmooth.analysis.orbit_search.orbit_set import (
    Member,
    OrbitSet,
    primitive_guess,
    turns_of,
)
from nonsmooth.analysis.orbit_search.sampled_motions import (
    drawn_states,
    sampled_motions,
    states_around,
)
from nonsmooth.engine.status import Status
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.guess import Guess, cycle_guesses
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest
from nonsmooth.periodic_orbits.search import equations_for, is_autonomous, solve_guess
from nonsmooth.runs.progress import HeldInterrupts, Progress

__all__ = ["Collected", "HowToCollect", "collect_orbits"]

_SHORTEST = {True: 32, False: 64}  # periods, or windows, of a motion from a start
_PER_PERIOD = {True: 4, False: 16}  # of an orbit
_PATIENCE = 10  # guesses of one word in a row that lead to nothing new
_STEPS = 20  # of Newton's method: guesses that need more seldom lead to an orbit
_SMOOTH = 20  # starts from which a cycle without events is looked for


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


def collect_orbits(wanted: OrbitRequest, how: HowToCollect, legs: Legs) -> Collected:
    """Look for orbits; Ctrl-C ends the search and keeps what was found."""
    found = Collected()
    work = how.samples + how.longest * how.guesses
    try:
        with HeldInterrupts() as held, Progress("looking for orbits", work) as progress:

            def report(done: int) -> None:
                progress.update(done)
                held.check()

            search = _Search(wanted, how, legs, found, report)
            try:
                search.run()
            finally:
                search.keep()
    except KeyboardInterrupt:
        found.interrupted = True
    return found


class _Search:
    """The search on its way."""

    def __init__(
        self, wanted: OrbitRequest, how: HowToCollect, legs: Legs, found: Collected,
        report: Callable[[int], None],
    ) -> None:  # fmt: skip
        self.wanted, self.how, self.legs, self.found = wanted, how, legs, found
        self.report, self.driven = report, not is_autonomous(legs)
        names = legs.system.states
        self.drifting = np.array([name in legs.system.drift_states for name in names])
        self.origin = np.array([legs.system.rest_state[name] for name in names])
        self.set: OrbitSet | None = None

    def run(self) -> None:
        """Motions first, then guesses for one period after the other."""
        motions = list(self._motions())
        self.spread = spread_of(motions, self.drifting)
        self.set = OrbitSet(self.legs, self.spread, self.how.match)
        smooth = not self.driven and not any(len(motion.points) for motion in motions)
        if smooth:
            self._smooth_cycles()
        for n in range(1, 1 + (0 if smooth else self.how.longest)):
            returns = close_returns(motions, n, self.spread, self.how.guesses)
            self._solve_returns(motions, returns, replace(self.wanted, period=n))

    def _solve_returns(
        self, motions: list[Motion], returns: list[Return], wanted: OrbitRequest
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
            guess = motion.guess(each.i, each.j, self.origin, self.drifting)
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

    def _motions(self) -> Iterator[Motion]:
        how, tables, system = self.how, self.legs.tables, self.legs.system
        first = first_motion(self.wanted, tables, how.record, self.driven)
        if first.status == Status.INTERRUPTED:
            raise KeyboardInterrupt
        yield first
        if how.box is not None:
            states = drawn_states(how.box, how.samples, how.seed)
        else:
            states = states_around(system, first, self.drifting, how.samples, how.seed)
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
                orbit = solve_guess(shorter, self.legs, primitive_guess(orbit)).orbit
                wanted = shorter
        except LegError:
            return None
        if orbit is None or self.driven:
            return orbit
        return replace(orbit, period=turns_of(orbit))
