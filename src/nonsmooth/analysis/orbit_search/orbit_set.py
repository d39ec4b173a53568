"""Orbits as sets of points: whether two are the same, and the shorter one that a turn repeats."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit import Orbit
from nonsmooth.periodic_orbits.word import Word

__all__ = ["OrbitSet", "primitive_guess", "turns_of"]

Floats = npt.NDArray[np.float64]

_AROUND = 256  # points of a cycle without events, between which another's start is looked for
_CORRECTIONS = 4


def primitive_guess(orbit: Orbit) -> Guess:
    """The shorter orbit that a turn repeats."""
    word, turn, parts = orbit.word, orbit.turn, orbit.primitive
    length = orbit.length / parts
    count = word.n_events // parts
    if word.closes_at_event:
        short = Word(word.modes[:count], word.paths[:count])
        return Guess(short, Turn(turn.states[:count].copy(), turn.instants[: count + 1].copy()))
    short = Word(word.modes[: count + 1], (*word.paths[:count], ()))
    instants = np.append(turn.instants[: count + 1], turn.instants[0] + length)
    return Guess(short, Turn(turn.states[: count + 1].copy(), instants))


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
            apart = np.abs(np.roll(points, -shift, axis=0) - member.points) / self._spread
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
        apart = (np.abs(around - point) / self._spread).max(axis=1)
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
