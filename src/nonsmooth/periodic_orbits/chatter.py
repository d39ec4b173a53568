"""Rebounds that accumulate, in the words of orbits: how many of them are followed says nothing.

The engine follows some and passes infinitely many at once. So words are compared and shown as if
the first impact ended in rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Wiring
from nonsmooth.periodic_orbits.onto import is_onto

__all__ = ["chatters", "collapsed"]

Integers = npt.NDArray[np.int64]
Path = tuple[int, ...]


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
