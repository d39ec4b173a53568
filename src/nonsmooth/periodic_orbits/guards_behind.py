"""Guards of the modes behind events at that instant, which tell what the events lead to."""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.tables import Wiring
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.onto import (
    is_onto,
    jump_over,
    jumps_over,
    modes_along,
)
from nonsmooth.periodic_orbits.word import Word

__all__ = ["EntryGuards", "JumpedGuards", "KeptGuards"]


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


class JumpedGuards:
    """Guards of surfaces that hold, behind impacts that jump over them.

    The exit over such a surface has no guard of its own: an impact passes it where the guard onto
    the surface has become negative.
    """

    def __init__(self, equations: OrbitEquations) -> None:
        self._legs, wiring = equations.legs, equations.legs.tables.wiring
        word = equations.word
        self._found = []  # leg, place in its path, mode before the surface, guard of the surface
        for k, path in enumerate(word.paths):
            j = len(path) - 1
            mode = modes_along(wiring, word.modes[k], path)[j] if j > 0 else -1
            if j > 0 and jumps_over(wiring, mode, path[j]):
                self._found.append((k, j, mode, int(wiring.exits["onto"][mode, path[j]])))
        modes = tuple(mode for _, _, mode, _ in self._found)
        self._word = Word(modes, ((),) * len(modes)) if modes else None

    def values(self, turn: Turn) -> dict[tuple[int, int], float]:
        """Value of each such guard by its leg and its place in the path of that.

        Results that the legs hold are overwritten where there are as many of them.
        """
        if self._word is None:
            return {}
        behind = [(k + 1) % len(turn.states) for k, *_ in self._found]
        begins = turn.instants[behind]
        found = self._legs.follow_each(self._word, turn.states[behind], begins, begins)
        return {
            (k, j): float(found.others[i, onto]) for i, (k, j, _, onto) in enumerate(self._found)
        }


class KeptGuards:
    """Guards of surfaces that hold, behind impacts that do not jump over them.

    Where such a guard becomes negative, the impact throws the motion over the surface.
    """

    def __init__(self, equations: OrbitEquations) -> None:
        self._legs, wiring = equations.legs, equations.legs.tables.wiring
        word = equations.word
        self._found = []  # leg, mode behind its impact, guard of the surface
        for k, path in enumerate(word.paths):
            if len(path) == 1 and wiring.resets(word.modes[k], path[0]):
                mode = word.last_target(wiring, k)
                surfaces = range(int(wiring.modes["n_exits"][mode]))
                self._found += [(k, mode, g) for g in surfaces if jump_over(wiring, mode, g) >= 0]
        modes = tuple(mode for _, mode, _ in self._found)
        self._word = Word(modes, ((),) * len(modes)) if modes else None

    def values(self, turn: Turn) -> dict[tuple[int, int], float]:
        """Value of each such guard, by the leg that ends there and the guard's number.

        Results that the legs hold are overwritten where there are as many of them.
        """
        if self._word is None:
            return {}
        behind = [(k + 1) % len(turn.states) for k, *_ in self._found]
        begins = turn.instants[[k + 1 for k, *_ in self._found]]
        found = self._legs.follow_each(self._word, turn.states[behind], begins, begins)
        return {(k, g): float(found.others[i, g]) for i, (k, _, g) in enumerate(self._found)}


def _enters(wiring: Wiring, mode: int, path: tuple[int, ...]) -> bool:
    """Whether a path ends on a surface that it was not on before."""
    last = modes_along(wiring, mode, path)[-2]
    return is_onto(wiring, last, path[-1]) or int(wiring.exits["onto"][last, path[-1]]) == path[-1]
