"""The same orbit with other rebounds before its rests, where the ones that are followed change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.branch_start import goes_on
from nonsmooth.periodic_orbits.branch_tests import Looked
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.motion_beyond import motion_from, start_of, way_of
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.stretch import BranchStart, BranchStretch
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.system import System

__all__ = [
    "cycle_of",
    "differs_in_rebounds",
    "over_chatter",
    "over_last_rebounds",
    "past_rebounds",
    "within_chatter",
]

Floats = npt.NDArray[np.float64]

_AT_SECTION = ("leg:0", "leg:last")
_BEYOND = 1e-6  # of the range of the parameter: an impact at the section is on one side of it there
_INSIDE = 1e-9  # of the way to the middle of an orbit, which is forgotten at rest
_SHORT = 1e-3  # of the turn: flights at the section behind which no rebound counts by itself
_NEXT = (1e-7, 1e-6, 1e-5, 1e-4)  # of the range of the parameter
_ALIKE = 0.1  # part of the duration of a leg by which it differs there at most
_NO_SPEED = 1e-9  # of the speed of an impact
_FORGOTTEN = 1e-12  # part of a change that is rounding
_MOST_TURNS = 1000
_FARTHER = (1e-3, 2e-3, 5e-3, 1e-2, 2e-2)  # of the range of the parameter


def over_last_rebounds(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where the section passes the last rebounds, or comes to them.

    They are so short that the next ones follow at once.
    """
    word = stretch.equations.word
    if point.special not in _AT_SECTION:
        return None
    if _section_in_chatter(stretch, word):
        return over_chatter(stretch, looked, point) if _is_short(looked.turn) else None
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    if point.special != "leg:last" or all(legs[-1] != len(word) - 2 for legs in found):
        return None  # it is not rest that begins at the section
    return _farther(stretch, looked, point, lambda guess: not _is_short(guess.turn))


def _is_short(turn: Turn) -> bool:
    """Whether the flight over the section is one of the last."""
    flight = float(turn.durations[0] + turn.durations[-1])
    return flight <= _SHORT * float(turn.durations.sum())


def over_chatter(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where the section does not lie within its rebounds any more.

    Infinitely many of them pass the section while the parameter changes by little. The motion comes
    to rest in every turn, so it is on the orbit after one.
    """
    if not _section_in_chatter(stretch, stretch.equations.word):
        return None
    return _farther(
        stretch, looked, point, lambda guess: not _section_in_chatter(stretch, guess.word)
    )


def _farther(
    stretch: BranchStretch, looked: Looked, point: Point, done: Callable[[Guess], bool]
) -> BranchStart | None:
    """The same orbit beyond, as far as it takes or as it may be."""
    low, high = stretch.options.bounds
    found: tuple[Guess, float] | None = None
    for part in _FARTHER:
        value = point.p + way_of(point) * part * (high - low)
        guess = _same_motion_at(stretch, looked, value)
        if guess is None:  # as behind a bound
            break
        found = guess, value
        if done(guess):
            break
    return None if found is None else start_of(stretch, *found, point)


def within_chatter(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit with other rebounds, where a test has changed its sign within them.

    The last ones are so short that the equations confuse them with none at all. Where an impact
    just passes the section, the engine would find it on either side there, so it is asked beyond.
    """
    word = stretch.equations.word
    name, *numbers = point.special.split(":")
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    legs = {k for each in found for k in each}
    if name != "motion" and not (numbers and numbers[0].isdigit() and int(numbers[0]) in legs):
        return None
    if not found or (name != "motion" and _lands_softly(stretch, looked, int(numbers[0]))):
        return None
    value = point.p
    if point.special in _AT_SECTION:
        low, high = stretch.options.bounds
        value += way_of(point) * _BEYOND * (high - low)
    guess = _same_motion_at(stretch, looked, value)
    if guess is None or guess.word == word:
        return None
    return start_of(stretch, guess, value, point)


def _lands_softly(stretch: BranchStretch, looked: Looked, k: int) -> bool:
    """Whether a flight begins with an impact that leaves no speed: it is no rebound."""
    legs, word, turn = stretch.legs, stretch.equations.word, looked.turn
    before = (k - 1) % len(word)
    if not word.paths[before]:
        return False
    stretch.set_parameter(float(looked.values[stretch.place]))
    found = legs.follow(word, turn.states, turn.instants)
    row = found.guard_row[before, : legs.n]
    speed = abs(float(found.guard_rate[before]))
    left = abs(float(row @ (found.start_rates[k] - found.end_rates[before])) - speed)
    return left <= _NO_SPEED * speed


def past_rebounds(stretch: BranchStretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where no step succeeds although nothing happens to it.

    Rounding of the last rebounds before rest may let none succeed. That the motion has the others
    there, of the same durations, tells that it is the same orbit.
    """
    word = stretch.equations.word
    if _section_in_chatter(stretch, word):
        return None
    low, high = stretch.options.bounds
    here = _durations(stretch, Guess(word, looked.turn))
    for part in _NEXT if here else ():
        value = point.p + way_of(point) * part * (high - low)
        stretch.set_parameter(point.p)
        guess = _same_motion_at(stretch, looked, value)
        if guess is None or _section_in_chatter(stretch, guess.word):
            return None
        there = _durations(stretch, guess)
        if len(here) != len(there) or any(map(_are_apart, here, there)):
            return None
        start = start_of(stretch, guess, value, point)
        if start is not None and goes_on(stretch, replace(start, kind="")):
            return start
    return None


def _durations(stretch: BranchStretch, guess: Guess) -> list[Floats]:
    """Durations of rebounds before each rest, and of what lies between; without those of rest.

    Rest begins where the last rebound that is followed ends. Nothing where there is no such rest.
    """
    word, (_, turn) = guess.word, guess
    found, begin = [], 0
    for legs in chatters(word.modes, word.paths, stretch.legs.tables.wiring):
        found += [turn.durations[begin : legs[0]], turn.durations[legs]]
        begin = legs[-1] + 2
    return [*found, turn.durations[begin:]] if found else []


def _are_apart(these: Floats, those: Floats) -> bool:
    """Whether durations differ, as far as both go on."""
    count = min(these.size, those.size)
    these, those = these[:count], those[:count]
    return bool(np.any(np.abs(these - those) > _ALIKE * np.abs(these)))


def _same_motion_at(stretch: BranchStretch, looked: Looked, value: float) -> Guess | None:
    """What the motion is when it has settled, if its modes are those of the orbit."""
    states, turns = looked.turn.states, _turns_to_settle(looked)
    guess = motion_from(stretch, states[0], value, turns)
    if guess is None:  # an impact at the section may lie behind the wall by rounding
        inside = states[0] + _INSIDE * (states.mean(axis=0) - states[0])
        guess = motion_from(stretch, inside, value, turns)
    return guess if guess is not None and differs_in_rebounds(stretch, guess.word) else None


def _turns_to_settle(looked: Looked) -> int:
    """Turns after which rounding is left of a change: one where all that moves comes to rest.

    One too where the orbit is unstable, from which a motion only goes away.
    """
    largest = float(np.abs(looked.multipliers.multipliers).max(initial=0.0))
    if not _FORGOTTEN < largest < 1.0:
        return 1
    return min(_MOST_TURNS, int(np.ceil(np.log(_FORGOTTEN) / np.log(largest))))


def differs_in_rebounds(stretch: BranchStretch, word: Word) -> bool:
    """Whether a word has the modes of the orbit, but for how many rebounds before rest it shows."""
    system = stretch.options.system
    return cycle_of(word, system) == cycle_of(stretch.equations.word, system)


def _section_in_chatter(stretch: BranchStretch, word: Word) -> bool:
    """Whether an orbit begins between rebounds."""
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    return any(len(word) - 1 in legs or legs[0] == 0 for legs in found)


def cycle_of(word: Word, system: System) -> tuple[int, ...]:
    """Modes that events lead to in a turn, from wherever they come first in order."""
    modes = word.collapsed(system.compiled.program.wiring).modes
    turn = modes if word.closes_at_event else modes[:-1]
    if not turn:  # no event is passed
        return ()
    return min(turn[k:] + turn[:k] for k in range(len(turn)))
