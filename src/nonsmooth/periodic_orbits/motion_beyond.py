"""What the motion from an orbit of a branch does at another value of the parameter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.branch_start import tangent_at
from nonsmooth.periodic_orbits.branch_tests import Looked
from nonsmooth.periodic_orbits.chatter import chatters
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess, driven_guess
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.stretch import BranchStart, Stretch
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.system import System

__all__ = [
    "differs_in_rebounds",
    "motion_at",
    "over_chatter",
    "over_last_rebounds",
    "within_chatter",
]

Floats = npt.NDArray[np.float64]

_AT_SECTION = ("leg:0", "leg:last")
_BEYOND = 1e-6  # of the range of the parameter: an impact at the section is on one side of it there
_INSIDE = 1e-9  # of the way to the middle of an orbit, which is forgotten at rest
_SHORT = 1e-3  # of the turn: flights at the section behind which no rebound counts by itself
_FARTHER = (1e-3, 2e-3, 5e-3, 1e-2, 2e-2)  # of the range of the parameter


def motion_at(stretch: Stretch, looked: Looked, value: float) -> Guess | None:
    """Legs of the motion from an orbit; None where nothing drives the system.

    It begins in the cell of the orbit where that admits it: a state that has decayed to a border
    of cells lies in several of them.
    """
    running = stretch.options.system.structure.running
    cell = running[stretch.equations.word.modes[0]].name
    first = looked.turn.states[0]
    found = _motion_from(stretch, first, value, 0, cell)
    return found or _motion_from(stretch, first, value, 0)


def _motion_from(
    stretch: Stretch, first: Floats, value: float, turns: int, mode: str | None = None
) -> Guess | None:
    """Legs of the motion from a state, after some turns."""
    options = stretch.options
    low, high = options.bounds
    if options.autonomous or not low <= value <= high:
        return None
    names = list(options.system.parameters)
    state = dict(zip(options.system.states, first.tolist(), strict=True))
    values = dict(zip(names, stretch.legs.values.tolist(), strict=True))
    try:
        there = options.system.with_parameters(**values | {options.parameter: value})
        return driven_guess(
            there, state, period=options.period, phase=options.phase,
            transient=turns * options.period, mode=mode, tolerance=options.tolerance,
        )  # fmt: skip
    except (RunError, ValueError):
        return None


def over_last_rebounds(stretch: Stretch, looked: Looked, point: Point) -> BranchStart | None:
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


def over_chatter(stretch: Stretch, looked: Looked, point: Point) -> BranchStart | None:
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
    stretch: Stretch, looked: Looked, point: Point, done: Callable[[Guess], bool]
) -> BranchStart | None:
    """The same orbit beyond, as far as it takes or as it may be."""
    low, high = stretch.options.bounds
    found: tuple[Guess, float] | None = None
    for part in _FARTHER:
        value = point.p + _way(point) * part * (high - low)
        guess = _same_motion_at(stretch, looked, value)
        if guess is None:  # as behind a bound
            break
        found = guess, value
        if done(guess):
            break
    return None if found is None else _start(stretch, *found, point)


def within_chatter(stretch: Stretch, looked: Looked, point: Point) -> BranchStart | None:
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
    if not found:
        return None
    value = point.p
    if point.special in _AT_SECTION:
        low, high = stretch.options.bounds
        value += _way(point) * _BEYOND * (high - low)
    guess = _same_motion_at(stretch, looked, value)
    if guess is None or guess.word == word:
        return None
    return _start(stretch, guess, value, point)


def _same_motion_at(stretch: Stretch, looked: Looked, value: float) -> Guess | None:
    """What the motion is after a turn in which it rests, if its modes are those of the orbit."""
    states = looked.turn.states
    guess = _motion_from(stretch, states[0], value, 1)
    if guess is None:  # an impact at the section may lie behind the wall by rounding
        inside = states[0] + _INSIDE * (states.mean(axis=0) - states[0])
        guess = _motion_from(stretch, inside, value, 1)
    return guess if guess is not None and differs_in_rebounds(stretch, guess.word) else None


def differs_in_rebounds(stretch: Stretch, word: Word) -> bool:
    """Whether a word has the modes of the orbit, but for how many rebounds before rest it shows."""
    system = stretch.options.system
    return _cycle(word, system) == _cycle(stretch.equations.word, system)


def _start(stretch: Stretch, guess: Guess, value: float, point: Point) -> BranchStart | None:
    """The branch from there on, in the direction that it has; None where it is no motion."""
    try:
        stretch.set_parameter(value)
        equations = stretch.equations.of_word(guess.word, guess.turn.states[0])
        solution = solve_orbit(equations, equations.pack(guess.turn))
        if solution.status != "completed":
            return None
        du, dp = tangent_at(equations, solution.unknowns)
    except LegError:
        return None
    sign = 1.0 if dp * _way(point) >= 0.0 else -1.0
    return BranchStart(equations, solution.unknowns, value, (sign * du, sign * dp), kind="section")


def _way(point: Point) -> float:
    return float(np.sign(point.tangent_p) or 1.0)


def _section_in_chatter(stretch: Stretch, word: Word) -> bool:
    """Whether an orbit begins between rebounds."""
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    return any(len(word) - 1 in legs or (0 in legs and legs[0] == 0) for legs in found)


def _cycle(word: Word, system: System) -> tuple[int, ...]:
    """Modes of a turn from wherever they come first in order."""
    modes = word.collapsed(system.compiled.program.wiring).modes
    turn = modes if word.closes_at_event else modes[:-1]
    return min(turn[k:] + turn[:k] for k in range(len(turn)))
