"""What the motion from an orbit of a branch does at another value of the parameter."""

from __future__ import annotations

import numpy as np

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic.branch_start import tangent_at
from nonsmooth.periodic.branch_tests import Looked
from nonsmooth.periodic.chatter import chatters
from nonsmooth.periodic.guess import Guess, driven_guess
from nonsmooth.periodic.legs import LegError
from nonsmooth.periodic.newton import solve_orbit
from nonsmooth.periodic.stretch import BranchStart, Stretch
from nonsmooth.periodic.word import Word
from nonsmooth.system.system import System

__all__ = ["motion_at", "over_chatter"]

_FARTHER = (1e-3, 2e-3, 5e-3, 1e-2, 2e-2)  # of the range of the parameter


def motion_at(stretch: Stretch, looked: Looked, value: float, turns: int = 0) -> Guess | None:
    """Legs of the motion from an orbit, after some turns; None where nothing drives the system."""
    options = stretch.options
    low, high = options.bounds
    if options.autonomous or not low <= value <= high:
        return None
    names = list(options.system.parameters)
    state = dict(zip(options.system.states, looked.turn.states[0].tolist(), strict=True))
    values = dict(zip(names, stretch.legs.values.tolist(), strict=True))
    try:
        there = options.system.with_parameters(**values | {options.parameter: value})
        return driven_guess(
            there, state, period=options.period, phase=options.phase,
            transient=turns * options.period, mode=None, tolerance=options.tolerance,
        )  # fmt: skip
    except (RunError, ValueError):
        return None


def over_chatter(stretch: Stretch, looked: Looked, point: Point) -> BranchStart | None:
    """The same orbit a little beyond, where the section does not lie within its rebounds any more.

    Infinitely many of them pass the section while the parameter changes by little. The motion comes
    to rest in every turn, so it is on the orbit after one.
    """
    word = stretch.equations.word
    if not _section_in_chatter(stretch, word):
        return None
    way = float(np.sign(point.tangent_p) or 1.0)
    low, high = stretch.options.bounds
    for part in _FARTHER:
        value = point.p + way * part * (high - low)
        guess = motion_at(stretch, looked, value, 1)
        if guess is None or _cycle(guess.word, stretch.options.system) != _cycle(
            word, stretch.options.system
        ):
            return None
        if _section_in_chatter(stretch, guess.word) and part < _FARTHER[-1]:
            continue
        try:
            stretch.set_parameter(value)
            equations = stretch.equations.of_word(guess.word, guess.turn.states[0])
            solution = solve_orbit(equations, equations.pack(guess.turn))
            if solution.status != "completed":
                return None
            du, dp = tangent_at(equations, solution.unknowns)
        except LegError:
            return None
        sign = 1.0 if dp * way >= 0.0 else -1.0
        return BranchStart(
            equations, solution.unknowns, value, (sign * du, sign * dp), kind="section"
        )
    return None


def _section_in_chatter(stretch: Stretch, word: Word) -> bool:
    """Whether an orbit begins between rebounds."""
    found = chatters(word.modes, word.paths, stretch.legs.tables.wiring)
    return any(len(word) - 1 in legs or (0 in legs and legs[0] == 0) for legs in found)


def _cycle(word: Word, system: System) -> tuple[int, ...]:
    """Modes of a turn from wherever they come first in order."""
    modes = word.collapsed(system.compiled.program.wiring).modes
    turn = modes if word.closes_at_event else modes[:-1]
    return min(turn[k:] + turn[:k] for k in range(len(turn)))
