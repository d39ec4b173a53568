"""A grid over two parameters that is refined where its labels differ, and filled elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote
from nonsmooth.runs.options import finite_number

__all__ = ["UNKNOWN", "check_levels", "refine_borders", "refined_values"]

_LEVELS = 8
UNKNOWN = 0  # key of a point that is not known; others are positive

Keys = npt.NDArray[np.int64]
Compute = Callable[[npt.NDArray[np.int64]], bool]


def check_levels(refine: Any) -> int:
    """How often cells are halved."""
    number = finite_number("refine", refine)
    if number != int(number) or not 0 <= number <= _LEVELS:
        raise OptionError(
            f"refine = {quote(refine)}: give how often cells are halved, a whole number from 0 to"
            f" {_LEVELS}"
        )
    return int(number)


def refined_values(values: npt.NDArray[np.float64], levels: int) -> npt.NDArray[np.float64]:
    """Values with those between them that halving so many times makes."""
    parts = 2**levels
    places = np.arange((values.size - 1) * parts + 1)
    between = np.interp(places / parts, np.arange(values.size), values)
    between[::parts] = values  # as they were given
    return between


def refine_borders(keys: Keys, levels: int, compute: Compute) -> Keys:
    """Compute the grid of the lowest level, then halve its cells where keys differ.

    ``compute`` gets places (K, 2) and puts their keys into ``keys``; it returns False when it could
    not finish, which ends the work. A cell is halved where two of the points known on it differ,
    and all its points are computed. As that may tell something about its neighbours, it is
    repeated until nothing changes; what is unknown then lies in cells of one key, which fills it.

    returns: places (K, 2) that were filled
    """
    step = 2**levels
    filled = [np.zeros((0, 2), np.int64)]
    whole = np.indices((keys[::step].shape[0], keys[:, ::step].shape[1])).reshape(2, -1).T
    if not compute(whole * step):
        return filled[0]
    while step > 1:
        step //= 2
        part = keys[::step, ::step]  # a view
        while True:
            wanted = np.argwhere(_on_cells(part, _differ(part)) & (part == UNKNOWN))
            if wanted.size == 0:
                break
            if not compute(wanted * step):
                return np.concatenate(filled)
        filled.append(_fill(part) * step)
    return np.concatenate(filled)


def _blocks(part: Keys) -> list[Keys]:
    """Views of the points of all cells, three by three each; of one line where there is no more."""
    views = []
    for i in _places(part.shape[0]):
        for j in _places(part.shape[1]):
            views.append(part[i, j])
    return views


def _places(size: int) -> list[slice]:
    if size == 1:
        return [slice(0, 1)]
    return [slice(0, size - 2, 2), slice(1, size - 1, 2), slice(2, size, 2)]


def _differ(part: Keys) -> npt.NDArray[np.bool_]:
    """Whether points that are known differ, for each cell."""
    blocks = np.array(_blocks(part))
    known = blocks != UNKNOWN
    largest = np.where(known, blocks, -1).max(axis=0)
    smallest = np.where(known, blocks, np.iinfo(np.int64).max).min(axis=0)
    return np.asarray(largest > smallest)


def _on_cells(part: Keys, cells: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Points of some of the cells."""
    points = np.zeros(part.shape, np.int64)
    for view in _blocks(points):
        view |= cells
    return points > 0


def _fill(part: Keys) -> npt.NDArray[np.int64]:
    """Give what is unknown the key of its cell; its places."""
    unknown = part == UNKNOWN
    blocks = np.array(_blocks(part))
    of_cell = blocks.max(axis=0)
    for view in _blocks(part):
        view[:] = np.where(view == UNKNOWN, of_cell, view)
    return np.argwhere(unknown)
