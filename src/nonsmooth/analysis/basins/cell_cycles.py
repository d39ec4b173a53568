"""Cycles of a map of whole numbers, and what comes to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Cycles", "cycles_of"]

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Cycles:
    """Cycles of a map of cells, and to which of them each cell comes."""

    first: Integers  # (C,): one cell of each cycle, the least
    length: Integers  # (C,)
    of_cell: Integers  # (N,): number of the cycle, -1 where a cell goes to none
    steps: Integers  # (N,): until the cell is in the cycle, or has no image


def cycles_of(image: Integers) -> Cycles:
    """All cycles of a map of whole numbers; negative images are no numbers.

    By squaring: after 2**k >= N steps every number is in a cycle or gone.
    """
    count = image.size
    gone = count  # a place that maps to itself
    step = np.append(np.where(image >= 0, image, gone), gone)
    far = step.copy()
    for _ in range(max(1, int(count).bit_length())):
        far = far[far]
    in_cycle = np.zeros(count + 1, bool)
    in_cycle[far] = True
    least, leap = np.arange(count + 1), np.where(in_cycle, step, np.arange(count + 1))
    for _ in range(max(1, int(count).bit_length())):
        least = np.minimum(least, least[leap])
        leap = leap[leap]
    in_cycle[gone] = False
    first = np.unique(least[:count][in_cycle[:count]])
    number = np.full(count + 1, -1, np.int64)
    number[first] = np.arange(first.size)
    of_cell = number[least[far[:count]]]
    length = np.bincount(number[least[:count][in_cycle[:count]]], minlength=first.size)
    return Cycles(first, length, of_cell, _steps(step, in_cycle | (np.arange(count + 1) == gone)))


def _steps(step: Integers, ends: npt.NDArray[np.bool_]) -> Integers:
    """Steps until a number is at an end, by squaring: leaps that do not pass one are taken."""
    count = step.size - 1
    leaps = [np.where(ends, np.arange(count + 1), step)]
    while len(leaps) <= int(count).bit_length():
        leaps.append(leaps[-1][leaps[-1]])
    here, total = np.arange(count + 1), np.zeros(count + 1, np.int64)
    for k in range(len(leaps) - 1, -1, -1):
        there = leaps[k][here]
        short = ~ends[there]
        here = np.where(short, there, here)
        total = np.where(short, total + (1 << k), total)
    return np.where(ends, 0, total + 1)[:count]
