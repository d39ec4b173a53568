"""A leg of an orbit lies on a surface all along, and goes to the other side of it: its border.

So it is where a state that only resets change says on which side the motion is, as in a map that
is defined piece by piece: between two instants of a clock it stays where it is. The orbit goes on
with the field and the resets of the other side, or turns back there if its continuation exists on
the side that it comes from. See M. di Bernardo, C. Budd, A. Champneys and P. Kowalczyk,
Piecewise-smooth Dynamical Systems, 2008, chapter 3.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.tables import DERIVATIVES, Wiring
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import targets_of_cell
from nonsmooth.periodic_orbits.wall_at_surface import through_wall
from nonsmooth.periodic_orbits.word import Word, shortest_paths

__all__ = ["beyond_border", "equilibrium_beyond"]

_CONSTANT = 1e-9  # of the terms of a guard along the orbit: it does not change by more
_PLACES = np.array([0.0, 0.5, 1.0])  # of a leg


def beyond_border(
    equations: OrbitEquations, turn: Turn, k: int, g: int
) -> list[tuple[Guess, str]]:  # fmt: skip
    """Leg k, on the surface of guard g from its begin to its end, is one beyond the surface.

    The orbits begun with, and the test that grows with each.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    # a leg that the section cuts is the first one and the last one
    parts = [k] if k or word.closes_at_event else [0, len(word) - 1]
    mode, before = word.modes[k], (parts[-1] - 1) % len(word)
    beyond = int(wiring.exits["target"][mode, g])
    if beyond < 0 or wiring.resets(mode, g) or not (word.paths[k] and word.paths[before]):
        return []
    back = targets_of_cell(wiring, beyond)
    if mode not in back or not _lies_on_surface(equations, turn, k, g):
        return []
    ends = equations.legs.follow(word, turn.states, turn.instants).ends.copy()
    at_ends = Turn(ends, turn.instants[1:])
    alone = before == k
    after = beyond if alone else word.last_target(wiring, k)
    modes = tuple(beyond if i in parts else m for i, m in enumerate(word.modes))
    found = []
    for out in through_wall(equations, beyond, after, at_ends, k):
        entries = [out] if alone else _entries(word, wiring, before, beyond)
        for entry in entries:
            paths = list(word.paths)
            paths[before], paths[k] = entry, out
            found.append((Guess(Word(modes, tuple(paths)), turn), f"corner:{k}:{back.index(mode)}"))
    return found


def equilibrium_beyond(
    equations: OrbitEquations, turn: Turn, g: int
) -> list[tuple[Guess, str]]:  # fmt: skip
    """A turn without events at rest on the surface of guard g: the rest of the mode beyond it.

    Or that on the surface itself. It exists on the other side of the parameter, or on the same one:
    the branch goes on or turns back. See section 5.1 of the book.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    mode, found = word.modes[0], []
    targets, onto = wiring.exits["target"], wiring.exits["onto"]
    for lead in dict.fromkeys((g, int(onto[mode, g]))):
        beyond = int(targets[mode, lead]) if lead >= 0 else -1
        if beyond < 0 or beyond == mode:
            continue
        new = Word((beyond,) * len(word), word.paths)
        for e in range(int(wiring.modes["n_exits"][beyond])):
            ways = [e] if onto[beyond, e] < 0 else [e, int(onto[beyond, e])]
            if mode in targets[beyond, ways]:
                found.append((Guess(new, turn), f"border:0:{e}"))
    return found


def _entries(word: Word, wiring: Wiring, before: int, beyond: int) -> list[tuple[int, ...]]:
    """Ways into the mode beyond the surface, by the exit that ends the leg before."""
    first = word.paths[before][0]
    behind = int(wiring.exits["target"][word.modes[before], first])
    if behind == beyond:
        return [(first,)]
    return [(first, *rest) for rest in shortest_paths(wiring, behind, beyond)]


def _lies_on_surface(equations: OrbitEquations, turn: Turn, k: int, g: int) -> bool:
    """Whether a guard that is zero where leg k ends is so where it begins and in the middle of it.

    It does not change there, beside its terms. How large it is says nothing where the border is
    at zero and the states are, so that the terms are no larger.
    """
    legs, mode, (begin, end) = equations.legs, equations.word.modes[k], turn.instants[k : k + 2]
    ends = begin + _PLACES * (end - begin)
    open_legs = Word((mode,) * ends.size, ((),) * ends.size)
    states = np.tile(turn.states[k], (ends.size, 1))
    guards = legs.follow_each(open_legs, states, np.full(ends.size, begin), ends).others[:, g]
    row = np.abs(legs.tables.affine[mode, DERIVATIVES * g])
    terms = row[: legs.n] @ np.abs(turn.states).max(axis=0) + row[legs.n]
    return bool(np.ptp(guards) <= _CONSTANT * terms)
