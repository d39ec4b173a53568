"""Strobes of an orbit of several periods, and the same orbit told from another one of them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.word import Word

__all__ = ["from_nearest_strobe"]

Floats = npt.NDArray[np.float64]

_NEARER = 1.0 - 1e-6  # of the distance of the strobe that is told: others are as near by rounding


def from_nearest_strobe(equations: OrbitEquations, turn: Turn, wanted: Floats) -> Guess | None:
    """The orbit from its strobe nearest to a state; None where that is the one it is told from.

    Drifts are compared nowhere: they begin anywhere.
    """
    free = ~equations.drifting
    if equations.autonomous or equations.period == 1 or not np.any(free):
        return None
    try:
        strobes = _strobes(equations, turn)
    except LegError:
        return None
    scale = np.abs(np.vstack([strobes, turn.states, wanted])[:, free]).max(axis=0)
    away = (strobes - wanted)[:, free] / np.where(scale > 0.0, scale, 1.0)
    distance = np.linalg.norm(away, axis=1)
    nearest = int(np.argmin(distance))
    if not distance[nearest] < _NEARER * distance[0]:
        return None
    return _turned(equations, turn, nearest, strobes[nearest])


def _strobes(equations: OrbitEquations, turn: Turn) -> Floats:
    """States at the section, one for each period of the turn."""
    window, word = equations.legs.window, equations.word
    times = turn.instants[0] + window * np.arange(equations.period)
    legs = np.searchsorted(turn.instants[1:-1], times, side="right")
    strobes = np.empty((equations.period, turn.states.shape[1]))
    strobes[0] = turn.states[0]
    for k in range(1, equations.period):
        ends = turn.instants[1:].copy()
        ends[legs[k]] = times[k]
        found = equations.legs.follow_each(word, turn.states, turn.instants[:-1], ends)
        strobes[k] = found.ends[legs[k]]
    return strobes


def _turned(equations: OrbitEquations, turn: Turn, later: int, strobe: Floats) -> Guess:
    """Legs from a strobe some periods later on.

    The leg in which that lies is cut there. The last leg and the first one, which are parts of one
    stay in a mode, become one.
    """
    word, window = equations.word, equations.legs.window
    cut = turn.instants[0] + later * window
    k = int(np.searchsorted(turn.instants[1:-1], cut, side="right"))
    first, last = slice(k, len(word)), slice(1, k + 1)
    modes = word.modes[first] + word.modes[last]
    paths = (*word.paths[k:-1], *word.paths[:k], ())
    closed = equations.legs.follow(word, turn.states, turn.instants).nexts[-1]
    drift = np.where(equations.drifting, closed - turn.states[0], 0.0)
    states = np.vstack([strobe, turn.states[k + 1 :], turn.states[last] + drift])
    length = equations.period * window
    inner = np.concatenate([turn.instants[k + 1 : -1], turn.instants[1 : k + 1] + length])
    begin, end = turn.instants[0], turn.instants[-1]
    instants = np.concatenate([[begin], inner - later * window, [end]])
    return Guess(Word(modes, paths), Turn(states, instants))
