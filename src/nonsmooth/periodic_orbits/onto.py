"""Paths that lead onto surfaces: how motion comes to slide or to rest there, and leaves.

Motion comes onto a surface by its exit into the cell beyond, and there by the exit onto it, which
is never searched for; or by an impact, and there by the one onto its rest. An exit that holds leads
there by itself.

Of rebounds that accumulate the engine follows some and passes infinitely many at once: how many it
follows says nothing. So words are compared and shown as if the first impact ended in rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import SLIDES, Wiring

__all__ = [
    "chatters",
    "collapsed",
    "crosses",
    "is_onto",
    "joined",
    "jump_over",
    "jumps_over",
    "kind_of_excursion",
    "kind_of_leg",
    "kind_of_mode",
    "modes_along",
    "onto_beyond",
    "path_through",
    "targets_of_cell",
    "with_jump",
    "without_jump",
]

Integers = npt.NDArray[np.int64]
Path = tuple[int, ...]


def kind_of_mode(wiring: Wiring, mode: int) -> int:
    """Whether a mode is free, slides or is at rest, as the engine's layout numbers it."""
    return int(wiring.modes["kind"][mode])


def modes_along(wiring: Wiring, mode: int, path: tuple[int, ...]) -> list[int]:
    """Modes that a path passes, with the one it begins in and the one it leads to."""
    modes = [mode]
    for e in path:
        modes.append(int(wiring.exits["target"][modes[-1], e]))
    return modes


def targets_of_cell(wiring: Wiring, cell: int) -> list[int]:
    """Modes behind the exits of a cell that are searched for."""
    found: list[int] = wiring.exits["target"][cell, : wiring.modes["n_exits"][cell]].tolist()
    return found


def path_through(wiring: Wiring, mode: int, guards: Path) -> Path | None:
    """The path through several surfaces of a cell one after the other; None where it is not clear.

    A surface is that of the same exit in the next cell which leads there to the cell that lies
    behind both surfaces.
    """
    path, here, left = [], mode, list(guards)
    while left:
        out = left.pop(0)
        path.append(out)
        targets = targets_of_cell(wiring, here)
        behind = targets_of_cell(wiring, targets[out]) if targets[out] >= 0 else []
        following = []
        for guard in left:
            beyond = set(targets_of_cell(wiring, targets[guard])) - {here, -1}
            same = [e for e, target in enumerate(behind) if target in beyond]
            if len(same) != 1:
                return None
            following.append(same[0])
        here, left = targets[out], following
    return tuple(path)


def is_onto(wiring: Wiring, mode: int, e: int) -> bool:
    """Whether an exit leads onto a surface, or to rest, and is passed on behalf of others only.

    The one across a surface that holds is not such an exit.
    """
    beside = e >= int(wiring.modes["n_exits"][mode])
    return beside and int(wiring.exits["onto"][mode, e]) < 0


def jumps_over(wiring: Wiring, mode: int, e: int) -> bool:
    """Whether an exit is the one by which an impact jumps over a surface that holds."""
    beside = e >= int(wiring.modes["n_exits"][mode])
    return beside and int(wiring.exits["onto"][mode, e]) >= 0


def with_jump(wiring: Wiring, mode: int, path: Path) -> Path:
    """The path behind an impact: it jumps over a surface that holds, which was crossed before."""
    if len(path) < 2 or int(wiring.exits["onto"][mode, path[0]]) != path[0]:
        return path
    beyond, jump = modes_along(wiring, mode, path)[2], jump_over(wiring, mode, path[0])
    if jump >= 0 and int(wiring.exits["target"][mode, jump]) == beyond:
        return (jump, *path[2:])
    return path


def jump_over(wiring: Wiring, mode: int, g: int) -> int:
    """The exit by which an impact jumps over the surface of guard g if that holds; else -1."""
    for e in range(int(wiring.modes["n_exits"][mode]), int(wiring.modes["n_ways"][mode])):
        if int(wiring.exits["onto"][mode, e]) == g == int(wiring.exits["onto"][mode, g]):
            return e
    return -1


def without_jump(wiring: Wiring, mode: int, path: Path) -> Path:
    """The path without an impact before it: it comes onto a surface that holds, and leaves it."""
    if not path or not jumps_over(wiring, mode, path[0]):
        return path
    onto = int(wiring.exits["onto"][mode, path[0]])
    exits = targets_of_cell(wiring, int(wiring.exits["target"][mode, onto]))
    beyond = int(wiring.exits["target"][mode, path[0]])
    return (onto, exits.index(beyond), *path[1:]) if beyond in exits else path


def crosses(wiring: Wiring, families: Integers, mode: int, path: tuple[int, ...]) -> bool:
    """Whether a path leads straight through a surface of the mode, without a reset."""
    if len(path) != 1:
        return False
    beyond = int(wiring.exits["target"][mode, path[0]])
    return (
        beyond >= 0
        and bool(families[beyond] == families[mode])
        and kind_of_mode(wiring, beyond) == kind_of_mode(wiring, mode)
        and not wiring.resets(mode, path[0])
    )


def onto_beyond(wiring: Wiring, mode: int, e: int) -> int:
    """Exit of the cell beyond a surface that leads onto it; -1 where motion cannot slide."""
    beyond = int(wiring.exits["target"][mode, e])
    if beyond < 0 or wiring.resets(mode, e):
        return -1
    for back in range(int(wiring.modes["n_exits"][beyond])):
        if int(wiring.exits["target"][beyond, back]) == mode:
            onto = int(wiring.exits["onto"][beyond, back])
            if onto not in (-1, back) and not wiring.resets(beyond, back):
                return onto
    return -1


def joined(
    wiring: Wiring, mode: int, first: tuple[int, ...], second: tuple[int, ...]
) -> tuple[int, ...]:
    """Path by which the engine passes at one instant what were two events.

    Onto a surface and off it beyond is through it; through it, back and onto it is onto it; over it
    and back through it is not to come to it.
    """
    over = modes_along(wiring, mode, first)
    if first and jumps_over(wiring, over[-2], first[-1]):
        back = modes_along(wiring, over[-1], second)
        quiet = not any(wiring.resets(m, e) for m, e in zip(back, second, strict=False))
        if quiet and back[-1] == over[-2]:
            return first[:-1]
    path = first + second
    modes = modes_along(wiring, mode, path)
    for j, e in enumerate(path):
        if not is_onto(wiring, modes[j], e) or wiring.resets(modes[j], e):
            continue
        if j + 1 < len(path) and modes[j + 2] == modes[j]:
            return path[:j] + path[j + 2 :]
        if j >= 2 and modes[j] == modes[j - 2]:
            onto = int(wiring.exits["onto"][modes[j - 1], path[j - 1]])
            if onto >= 0:
                return (*path[: j - 1], onto, *path[j + 1 :])
    return path


def kind_of_excursion(wiring: Wiring, mode: int, away: int) -> str:
    """What it is called where an excursion out of a mode and back into it begins.

    Names are those of M. di Bernardo, C. Budd, A. Champneys and P. Kowalczyk, Piecewise-smooth
    Dynamical Systems, 2008: a guard that is touched is a tangency of the field beside a surface,
    or, while motion slides, one at which it would leave.
    """
    if kind_of_mode(wiring, away) == SLIDES and kind_of_mode(wiring, mode) != SLIDES:
        return "grazing_sliding"
    if kind_of_mode(wiring, mode) == SLIDES and kind_of_mode(wiring, away) != SLIDES:
        return "adding_sliding"
    return "grazing"


def kind_of_leg(
    wiring: Wiring, before: int, path: tuple[int, ...], mode: int, behind: tuple[int, ...]
) -> str:
    """What it is called where a leg between two events vanishes; "" where it has no name.

    ``path`` leads from the mode before to that of the leg, ``behind`` away from it.
    """
    slaved = wiring.modes["slaved"]["words"]  # states that follow from what a mode rests on
    after = modes_along(wiring, mode, behind)[-1]
    slides = [kind_of_mode(wiring, m) == SLIDES for m in (before, mode, after)]
    same = bool((slaved[after] == slaved[before]).all())
    if slides == [False, True, False] and same and after != before:
        return "crossing_sliding"
    if (
        slides == [False, False, True]
        and len(path) == 1
        and before in modes_along(wiring, mode, behind)
    ):
        return "switching_sliding"
    return ""


def chatters(modes: Sequence[int], paths: Sequence[Path], wiring: Wiring) -> list[list[int]]:
    """Legs that end with the impacts of each chatter, in order; the last one ends in rest."""
    return [
        _up_to(modes, paths, k)
        for k, path in enumerate(paths)
        if len(path) == 2
        and wiring.resets(modes[k], path[0])
        and int(wiring.exits["target"][modes[k], path[0]]) == modes[k]
        and is_onto(wiring, modes[k], path[1])
    ]


def _up_to(modes: Sequence[int], paths: Sequence[Path], last: int) -> list[int]:
    """Legs that end with the same impact as this one, in a row up to it.

    The section cuts a leg of a driven orbit in two: both are the first flight then.
    """
    found, count = [last], len(modes)
    while len(found) < count:
        k = (found[0] - 1) % count
        if modes[k] != modes[last] or paths[k] not in (paths[last][:1], ()):
            break
        found.insert(0, k)
    return found


def collapsed(
    modes: Sequence[int], paths: Sequence[Path], wiring: Wiring
) -> tuple[tuple[int, ...], tuple[Path, ...]]:
    """Modes and paths of a word as if the first impact of each chatter ended in rest."""
    gone: set[int] = set()
    new = list(paths)
    cut = len(modes) - 1 if not paths[-1] else -1  # leg that ends at the section
    for legs in chatters(modes, paths, wiring):
        first = legs[0]
        if cut in legs:  # it goes on behind the section
            new[first] = ()
            gone |= set(legs[1 : legs.index(cut) + 1])
            first = 0
        new[first] = paths[legs[-1]]
        gone |= set(legs[legs.index(first) + 1 :])
    keep = [k for k in range(len(modes)) if k not in gone]
    return tuple(modes[k] for k in keep), tuple(new[k] for k in keep)
