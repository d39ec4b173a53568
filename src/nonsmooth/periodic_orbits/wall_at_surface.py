"""A body meets a wall at the instant at which it leaves a surface, or comes onto it.

On one side of such an orbit it leaves the surface, and flies into the wall after a short leg; on
the other side the surface still holds it where it meets the wall. Likewise it comes onto the
surface for a short leg before the wall, or meets the wall first. The wall is an exit of either
mode, with a number of its own and its own way on; it may be the tick of a clock. The exit to the
other mode may reset what it finds there already, as a current that is zero when a diode blocks.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.onto import onto_beyond
from nonsmooth.periodic_orbits.word import Word, shortest_paths

__all__ = ["surface_before_wall", "through_wall", "wall_before_surface"]

Path = tuple[int, ...]

_SAME = 1e-9  # of the size of a state: it is not changed


def wall_before_surface(
    equations: OrbitEquations, turn: Turn, k: int
) -> list[tuple[Guess, str]]:  # fmt: skip
    """Leg k from a surface or onto it lasts no time before its wall, which is met without it.

    The orbits begun with, and the test that grows with each.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    count = len(word)
    before = (k - 1) % count
    mode, path = word.modes[before], word.paths[before]
    at_wall = bool(word.paths[k]) and wiring.resets(word.modes[k], word.paths[k][0])
    if count < 2 or not path or not at_wall:
        return []
    if wiring.resets(mode, path[0]) and not _changes_nothing(equations, turn, before, path[:1]):
        return []
    keep = [i for i in range(count) if i != k]
    place = keep.index(before)
    instants = np.delete(turn.instants, k if k else 1)
    found = []
    after = word.last_target(wiring, k)
    for straight in through_wall(equations, mode, after, turn, k, without=path[0]):
        paths = [word.paths[i] if i != before else straight for i in keep]
        new = Word(tuple(word.modes[i] for i in keep), tuple(paths))
        found.append((Guess(new, Turn(turn.states[keep], instants)), f"corner:{place}:{path[0]}"))
    return found


def surface_before_wall(
    equations: OrbitEquations, turn: Turn, k: int, g: int
) -> list[tuple[Guess, str]]:  # fmt: skip
    """Leg k ends at a wall where guard g leads off a surface or onto one: that comes first.

    The orbits begun with, and the test that grows with each.
    """
    word, wiring = equations.word, equations.legs.tables.wiring
    mode = word.modes[k]
    at_wall = bool(word.paths[k]) and wiring.resets(mode, word.paths[k][0])
    beyond = int(wiring.exits["target"][mode, g])
    if not at_wall or beyond < 0:
        return []
    if wiring.resets(mode, g) and not _changes_nothing(equations, turn, k, (g,)):
        return []
    onto = onto_beyond(wiring, mode, g)
    ways: list[tuple[Path, int]] = [((g,), beyond)]
    if onto >= 0:
        ways.insert(0, ((g, onto), int(wiring.exits["target"][beyond, onto])))
    corner = equations.legs.follow(word, turn.states, turn.instants).ends[k].copy()
    states = np.insert(turn.states, k + 1, corner, axis=0)
    there = Turn(states, np.insert(turn.instants, k + 1, turn.instants[k + 1]))
    found = []
    for path, inside in ways:
        for straight in through_wall(equations, inside, word.last_target(wiring, k), there, k + 1):
            modes = (*word.modes[: k + 1], inside, *word.modes[k + 1 :])
            paths = (*word.paths[:k], path, straight, *word.paths[k + 1 :])
            found.append((Guess(Word(modes, paths), there), f"leg:{k + 1}"))
    return found


def _changes_nothing(equations: OrbitEquations, turn: Turn, k: int, path: Path) -> bool:
    """Whether the reset of an exit leaves the state as it is where leg k ends."""
    word = Word(equations.word.modes[k : k + 1], (path,))
    found = equations.legs.follow_each(
        word, turn.states[k : k + 1], turn.instants[k : k + 1], turn.instants[k + 1 : k + 2]
    )
    change = np.abs(found.nexts[0] - found.ends[0])
    return bool(np.all(change <= _SAME * np.abs(turn.states).max(axis=0)))


def through_wall(
    equations: OrbitEquations, mode: int, after: int, turn: Turn, k: int, without: int = -1
) -> list[Path]:  # fmt: skip
    """Ways from a mode to another one by the wall that is met where leg k begins.

    It is another exit than the one to do ``without``, whose guard is zero there too.
    """
    wiring = equations.legs.tables.wiring
    exits = range(int(wiring.modes["n_exits"][mode]))
    walls = [e for e in exits if e != without and wiring.resets(mode, e)]
    if not walls:
        return []
    at = turn.instants[k : k + 1]
    there = equations.legs.follow_each(Word((mode,), ((),)), turn.states[k : k + 1], at, at)
    wall = min(walls, key=lambda e: abs(float(there.others[0, e])))
    behind = int(wiring.exits["target"][mode, wall])
    if behind == after:
        return [(wall,)]
    return [(wall, *rest) for rest in shortest_paths(wiring, behind, after)]
