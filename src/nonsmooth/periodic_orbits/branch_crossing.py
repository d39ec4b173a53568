"""The other branch at a point where two branches of orbits cross.

At the point itself both are tangent to solutions of the same equations, so only another point of
the known branch tells which of the two directions is its own.

Guards may be met at one instant by coincidence there: equal machines in step hit their stops
together. On a branch on which they part, each of these exits has an instant of its own, and the
direction of the branch tells which one comes first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.branch_directions import branch_directions
from nonsmooth.continuation.follow import follow
from nonsmooth.errors import NonsmoothError
from nonsmooth.periodic_orbits.branch_start import passed_twice, tangent_at
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.newton import scale_of
from nonsmooth.periodic_orbits.onto import joined, modes_along
from nonsmooth.periodic_orbits.order_of_events import in_other_order
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart, BranchStretch, scale_along
from nonsmooth.periodic_orbits.touches import GONE
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.periodic_orbits.word_change import with_leg

__all__ = ["BranchCrossing", "arm", "crossing_at", "crossing_at_flip"]

Floats = npt.NDArray[np.float64]

_FARTHER, _LEAST = 1e-3, 1e-6  # parts of the first step of a branch, by which it begins
_ALONG = 1e-6  # scaled step along a branch, by which its direction is told
_TOGETHER = 1e-6  # of the largest change of an instant: exits that stay at one instant


@dataclass(frozen=True)
class BranchCrossing:
    """A point where two branches cross, with the direction of the one that is known."""

    equations: OrbitEquations
    turn: Turn
    value: float
    known: tuple[Floats, float]

    def other(self, options: BranchOptions) -> BranchStart:
        """The start of the other branch."""
        equations = self.equations
        stretch = BranchStretch(options, equations.legs, equations)
        unknowns, (low, high) = equations.pack(self.turn), options.bounds
        found = branch_directions(
            stretch.residual, unknowns, self.value, along=self.known,
            scale=scale_of(equations, unknowns), parameter_scale=high - low,
        )  # fmt: skip
        stretch.set_parameter(self.value)
        return BranchStart(equations, np.asarray(found.u), float(found.p), found.directions[1])

    def with_order(self, guess: Guess) -> BranchCrossing:
        """The same with events of one instant in another order, of which the known branch has none.

        Of the directions along which the equations vanish it is the one along which the states of
        all other legs, and the parameter, change as they did.
        """
        equations = self.equations.of_word(guess.word, guess.turn.states[0])
        n = equations.legs.n
        unknowns = equations.pack(guess.turn)
        _, jacobian, moved = equations.evaluate(unknowns)
        scale = scale_of(equations, unknowns)
        matrix = np.column_stack([jacobian * scale, moved[:, 0]])
        rows = np.abs(matrix).max(axis=1, keepdims=True)
        _, _, vectors = np.linalg.svd(matrix / np.where(rows > 0.0, rows, 1.0))
        free, (du, dp) = vectors[-2:].T, self.known
        places = np.flatnonzero(
            np.repeat(np.abs(guess.turn.durations) > GONE * guess.turn.instants[-1], n)
        )
        known = np.append(du[places] / scale[places], dp)
        places = np.append(places, unknowns.size)
        found = free @ np.linalg.lstsq(free[places], known, rcond=None)[0]
        direction = found[:-1] * scale, float(found[-1])
        return BranchCrossing(equations, guess.turn, self.value, direction)


def crossing_at(
    options: BranchOptions, equations: OrbitEquations, guess: Guess, value: float,
    neighbour: tuple[Guess, float] | None,
) -> BranchCrossing:  # fmt: skip
    """The crossing at an orbit, from another orbit of the known branch, if there is one.

    The legs of the equations stand for the parameter there, and do so again.
    """
    whole = _with_each_exit(equations, guess)
    split = equations.of_word(whole.word, whole.turn.states[0])
    unknowns = split.pack(whole.turn)
    known = tangent_at(split, unknowns)
    if neighbour is not None:
        stretch, (there, elsewhere) = BranchStretch(options, equations.legs, equations), neighbour
        stretch.set_parameter(elsewhere)
        there = _with_each_exit(equations, there)
        stretch.set_parameter(value)
        if there.word == whole.word:
            known = split.pack(there.turn) - unknowns, elsewhere - value
    return BranchCrossing(split, whole.turn, value, known)


def crossing_at_flip(
    options: BranchOptions, once: OrbitEquations, guess: Guess, start: BranchStart
) -> BranchCrossing | None:
    """The crossing of the doubled branch with the orbit passed twice; None where exits are alone.

    It is a flip of what tells equal machines apart: each is the first one in every other turn.
    """
    twice, stretch = start.equations, BranchStretch(options, once.legs, once)
    whole = _with_each_exit(twice, Guess(twice.word, twice.unpack(start.unknowns)))
    if len(whole.word) == len(twice.word):
        return None
    unknowns = once.pack(guess.turn)
    du, dp = tangent_at(once, unknowns)
    split = twice.of_word(whole.word, whole.turn.states[0])
    step = _ALONG / max(1.0, float(np.abs(du / scale_of(once, unknowns)).max()))
    stretch.set_parameter(start.value + step * dp)
    beside = Guess(guess.word, once.unpack(unknowns + step * du))
    there = _with_each_exit(twice, passed_twice(options, once.legs, beside))
    known = split.pack(there.turn) - split.pack(whole.turn), step * dp
    stretch.set_parameter(start.value)
    return BranchCrossing(split, whole.turn, start.value, known)


def _with_each_exit(equations: OrbitEquations, guess: Guess) -> Guess:
    """The same turn with a leg of no duration before each exit that happens to be passed there.

    The legs of the equations stand for the parameter there; `LegError` where a leg fails.
    """
    word, turn = guess
    wiring = equations.legs.tables.wiring
    met = equations.legs.follow(word, turn.states, turn.instants).passed_rate != 0.0
    for k in range(len(word) - 1, -1, -1):
        for j in range(len(word.paths[k]) - 1, 0, -1):
            if met[k, j]:
                path = guess.word.paths[k]
                mode = modes_along(wiring, word.modes[k], path[:j])[-1]
                here = equations.of_word(guess.word, guess.turn.states[0])
                guess = with_leg(here, guess.turn, k, path[:j], mode, path[j:])
    return guess


def arm(options: BranchOptions, crossing: BranchCrossing, way: float) -> BranchStart:
    """The start of the other branch at a crossing, towards one of its ends.

    The exits of one instant come in the order in which the branch takes them apart; those that
    stay at one instant are one path again. ``way`` is 1 towards larger values of the parameter, or
    -1. `NonsmoothError` where no other branch begins.
    """
    start, length = crossing.other(options), float(crossing.turn.instants[-1])
    way = way if start.direction[1] >= 0.0 else -way
    start = replace(start, direction=(way * start.direction[0], way * start.direction[1]))
    for _ in range(1 + len(crossing.turn.states)):
        equations, turn = start.equations, start.equations.unpack(start.unknowns)
        du = start.direction[0]
        changes = equations.unpack(du).durations
        empty = (np.abs(turn.durations) <= GONE * length) & [bool(p) for p in equations.word.paths]
        least = _TOGETHER * np.abs(du[len(turn.states) * equations.legs.n :]).max(initial=0.0)
        wrong = np.flatnonzero(empty & (changes < -least))
        if wrong.size == 0:
            break
        k = int(wrong[0])
        swapped = in_other_order(equations, turn, k)
        if not swapped:
            return start
        crossing = crossing.with_order(swapped[0].guess)
        start = crossing.other(options)
        if start.equations.unpack(start.direction[0]).durations[k] < 0.0:
            start = replace(start, direction=(-start.direction[0], -start.direction[1]))
    for k in reversed(np.flatnonzero(empty & (np.abs(changes) <= least))):
        start = _joined(start, int(k))
    return _farther(options, start) if np.any(empty & (changes > least)) else start


def _farther(options: BranchOptions, start: BranchStart) -> BranchStart:
    """A start a little farther along the branch; the same where no step succeeds."""
    stretch, step = BranchStretch(options, start.equations.legs, start.equations), options.step
    low, high = options.bounds
    try:
        branch = follow(
            stretch.residual, start.unknowns, start.value, direction=start.direction,
            step=_FARTHER * step, smallest_step=_LEAST * step, largest_step=_FARTHER * step,
            steps=1, bounds=options.bounds, scale=scale_along(start.equations, start.unknowns),
            parameter_scale=high - low,
        )  # fmt: skip
        *_, last = branch
    except NonsmoothError:
        return start
    direction = last.tangent_u, last.tangent_p
    return replace(start, unknowns=last.u, value=last.p, direction=direction)


def _joined(start: BranchStart, k: int) -> BranchStart:
    """The start without leg k, whose exits are passed with those before."""
    word, turn = start.equations.word, start.equations.unpack(start.unknowns)
    paths, keep = list(word.paths), np.delete(np.arange(len(word)), k)
    wiring = start.equations.legs.tables.wiring
    paths[k - 1] = joined(wiring, word.modes[k - 1], paths[k - 1], paths[k])
    new = Word(tuple(word.modes[i] for i in keep), tuple(paths[i] for i in keep))
    equations = start.equations.of_word(new, turn.states[keep[0]])
    change = start.equations.unpack(start.direction[0])
    unknowns, du = (
        equations.pack(Turn(each.states[keep], np.delete(each.instants, k)))
        for each in (turn, change)
    )
    return replace(
        start, equations=equations, unknowns=unknowns, direction=(du, start.direction[1])
    )
