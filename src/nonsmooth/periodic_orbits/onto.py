"""Paths that lead onto surfaces: how motion comes to slide or to rest there, and leaves.

Motion comes onto a surface by its exit into the cell beyond, and there by the exit onto it, which
is never searched for; or by an impact, and there by the one onto its rest. An exit that holds leads
there by itself.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Wiring

__all__ = [
    "crosses",
    "is_onto",
    "joined",
    "kind_of_mode",
    "modes_along",
    "onto_beyond",
    "targets_of_cell",
]

Integers = npt.NDArray[np.int64]


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


def is_onto(wiring: Wiring, mode: int, e: int) -> bool:
    """Whether an exit leads onto a surface, or to rest, and is passed on behalf of others only.

    The one across a surface that holds is not such an exit.
    """
    beside = e >= int(wiring.modes["n_exits"][mode])
    return beside and int(wiring.exits["onto"][mode, e]) < 0


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

    Onto a surface and off it beyond is through it; through it, back and onto it is onto it.
    """
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
