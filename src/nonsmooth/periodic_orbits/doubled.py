"""The branch of orbits with twice the period that begins at a flip."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.newton import null_vector
from nonsmooth.periodic_orbits.stretch import BranchOptions, BranchStart
from nonsmooth.periodic_orbits.word import Word

__all__ = ["doubled_start"]

Floats = npt.NDArray[np.float64]


def doubled_start(options: BranchOptions, legs: Legs, guess: Guess, value: float) -> BranchStart:
    """Start on the doubled branch: the orbit passed twice, and the direction in which they differ.

    ``options`` have the period of the doubled orbit. At the flip the equations of the doubled
    orbit are singular; their null vector leads to it, the parameter being stationary there.
    """
    word, turn = guess
    length = float(turn.instants[-1] - turn.instants[0])
    ends = legs.follow(word, turn.states, turn.instants).nexts[-1]
    drifting = np.array([name in options.system.drift_states for name in options.system.states])
    shift = np.where(drifting, ends - turn.states[0], 0.0)
    if word.closes_at_event:
        twice = Word(word.modes * 2, word.paths * 2)
        states = np.vstack([turn.states, turn.states + shift])
        instants = np.concatenate([turn.instants, turn.instants[1:] + length])
    else:
        # the last leg of the first turn and the first one of the second are one
        twice = Word(word.modes + word.modes[1:], word.paths[:-1] + word.paths)
        states = np.vstack([turn.states, turn.states[1:] + shift])
        instants = np.concatenate([turn.instants[:-1], turn.instants[1:] + length])
    equations = OrbitEquations(
        legs, twice, period=options.period, phase=options.phase, autonomous=options.autonomous,
        origin=states[0], reference=states[0].copy(),
    )  # fmt: skip
    unknowns = equations.pack(Turn(states, instants))
    return BranchStart(equations, unknowns, value, (null_vector(equations, unknowns), 0.0))
