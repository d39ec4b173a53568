"""Whether an orbit is its own mirror image, half a turn later."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic.equations import OrbitEquations, Turn
from nonsmooth.periodic.word import Word

__all__ = ["is_symmetric"]

Floats = npt.NDArray[np.float64]

_SHARES = np.array([0.0, 0.137, 0.289, 0.411])  # of the turn, where it is looked at
_SAME = 1e-6  # of the size of each state: where branches cross, orbits are found to half the digits


def is_symmetric(equations: OrbitEquations, turn: Turn) -> bool:
    """Whether all states change their signs half a turn later, but for drifts."""
    length = float(turn.instants[-1] - turn.instants[0])
    now = _states(equations, turn, turn.instants[0] + _SHARES * length)
    then = _states(equations, turn, turn.instants[0] + (_SHARES + 0.5) * length)
    keep = ~equations.drifting
    size = np.abs(np.concatenate([now, then, turn.states])).max(axis=0)[keep]
    return bool(keep.any() and np.all(np.abs(now + then)[:, keep] <= _SAME * (size + 1e-300)))


def _states(equations: OrbitEquations, turn: Turn, times: Floats) -> Floats:
    """States of the turn at some times."""
    legs = np.searchsorted(turn.instants[1:-1], times, side="right")
    word = Word(tuple(equations.word.modes[k] for k in legs), ((),) * times.size)
    found = equations.legs.follow_each(word, turn.states[legs], turn.instants[legs], times)
    return found.ends.copy()
