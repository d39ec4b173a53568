"""What keeps motion on the surfaces that it comes onto, at the instant at which it does."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Wiring
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.onto import is_onto, modes_along
from nonsmooth.periodic_orbits.word import Word

__all__ = ["EntryGuards"]

Integers = npt.NDArray[np.int64]


class EntryGuards:
    """Guards of the cells that are entered by paths onto surfaces, at that instant.

    They are positive where both sides point at the surface, or where a contact is pressed.
    """

    def __init__(self, equations: OrbitEquations) -> None:
        self._legs, wiring = equations.legs, equations.legs.tables.wiring
        word = equations.word
        self._ends = [  # legs that end so
            k for k, path in enumerate(word.paths) if path and _enters(wiring, word.modes[k], path)
        ]
        self._entered = [(k + 1) % len(word) for k in self._ends]
        modes = tuple(word.modes[k] for k in self._entered)
        self._word = Word(modes, ((),) * len(modes)) if modes else None

    def values(self, turn: Turn) -> dict[tuple[int, int], float]:
        """Value of each such guard, by the leg that ends there and the guard's number.

        Results that the legs hold are overwritten where there are as many of them.
        """
        if self._word is None:
            return {}
        begins = turn.instants[self._entered]
        found = self._legs.follow_each(self._word, turn.states[self._entered], begins, begins)
        return {
            (k, int(g)): float(found.others[i, g])
            for i, k in enumerate(self._ends)
            for g in np.flatnonzero(np.isfinite(found.others[i]))
        }


def _enters(wiring: Wiring, mode: int, path: tuple[int, ...]) -> bool:
    """Whether a path ends on a surface that it was not on before."""
    last = modes_along(wiring, mode, path)[-2]
    return is_onto(wiring, last, path[-1]) or int(wiring.exits["onto"][last, path[-1]]) == path[-1]
