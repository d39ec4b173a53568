"""Recurrences of lanes: which of them have come to a known attractor, and stay.

Attractors are told by their points. A cycle has a ball around each of its points, in which all
motions are known to converge to it; a larger set has the cells of a grid that it visits. States
are compared in units of a scale for each. Cells are known by a hash of their numbers, so that
no grid is ever stored.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nonsmooth.engine.jit import entry, inlined, kernel
from nonsmooth.engine.layout import Floats, Integers

__all__ = ["Landmarks", "Visits", "cell_keys", "fill_cells", "visit"]

EMPTY = 0  # key of a free place in the table of cells
_NO_LABEL = 0
_MISS = 10  # visits that one outside the known cells of a set takes back


class Landmarks(NamedTuple):
    """Points and cells of the attractors that are known; d states are compared."""

    columns: Integers  # (d,): numbers of these states
    scale: Floats  # (d,): unit of each
    cell: float  # width of a cell, in these units
    points: Floats  # (P, d) of all cycles, in these units
    radius: Floats  # (P,): of the ball around each
    label: Integers  # (P,): attractor to which a point belongs
    following: Integers  # (P,): the point after it
    keys: Integers  # (H,): table of cells, H a power of two
    owner: Integers  # (H,): attractor to which a cell belongs
    in_cycle: int  # visits in a row after which a lane has come to a cycle
    in_set: int  # visits after which it has come to a set


class Visits(NamedTuple):
    """What lanes have visited last."""

    candidate: Integers  # (L,): attractor, 0 for none
    point: Integers  # (L,): point of a cycle, -1 for none
    score: Integers  # (L,): visits that speak for it
    label: Integers  # (L,): attractor to which the lane has come, 0 for none yet
    needed: Integers  # (L,): images until then


@kernel
def _key(number, key):
    """Mix the number of a cell along one state into a key (splitmix64)."""
    mixed = np.uint64(number) + key * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return mixed ^ (mixed >> np.uint64(31))


@kernel
def _key_of_cell(state, columns, scale, cell):
    """Key of the cell in which a state lies, never `EMPTY`."""
    key = np.uint64(1)
    for k in range(columns.size):
        number = math.floor(state[columns[k]] / (scale[k] * cell))
        key = _key(np.int64(number), key)
    found = np.int64(key >> np.uint64(1))
    return found if found != EMPTY else np.int64(1)


@entry
def cell_keys(states, columns, scale, cell, keys):
    """Keys of the cells of some states, `EMPTY` where they are not finite.

    shapes: states (K, n), keys (K,)
    """
    for i in range(states.shape[0]):
        finite = True
        for k in range(columns.size):
            # far away cells have no number that fits
            finite = finite and abs(states[i, columns[k]]) < 1e15 * scale[k] * cell
        keys[i] = _key_of_cell(states[i], columns, scale, cell) if finite else EMPTY


@kernel
def _place(keys, key):
    """Place of a key in the table, or the free one where it would stand."""
    mask = keys.size - 1
    i = key & mask
    while keys[i] != EMPTY and keys[i] != key:
        i = (i + 1) & mask
    return i


@entry
def fill_cells(found, label, keys, owner):
    """Put cells into the table; a cell that is there already stays with its owner.

    shapes: found (C,), keys, owner (H,)
    returns: number of cells that are new
    """
    new = 0
    for key in found:
        if key == EMPTY:
            continue
        i = _place(keys, key)
        if keys[i] == EMPTY:
            keys[i], owner[i] = key, label
            new += 1
    return new


@inlined
def _distance(marks, i, state):
    """Square of the distance of a state from a point of a cycle, as far as the radius."""
    most = marks.radius[i] * marks.radius[i]
    found = 0.0
    for k in range(marks.columns.size):
        step = state[marks.columns[k]] / marks.scale[k] - marks.points[i, k]
        found += step * step
        if found > most:
            break
    return found


@inlined
def _near(marks, state, expected):
    """Point of a cycle that is near, the expected one first; -1 for none."""
    if expected >= 0 and _distance(marks, expected, state) <= marks.radius[expected] ** 2:
        return expected
    for i in range(marks.radius.size):
        if _distance(marks, i, state) <= marks.radius[i] ** 2:
            return i
    return -1


@inlined
def _owner_of_cell(marks, state):
    """Attractor to which the cell of a state belongs, 0 for none."""
    i = _place(marks.keys, _key_of_cell(state, marks.columns, marks.scale, marks.cell))
    return marks.owner[i] if marks.keys[i] != EMPTY else _NO_LABEL


@entry
def visit(images, first, marks, visits):
    """Count the visits of lanes along some images, until each has come to an attractor.

    Cycles are to be visited in the order of their points; of a set, nearly all visits must be to
    its known cells. ``first`` is the number of the first
    image since the start of the lanes.

    shapes: images (L, K, n)
    """
    for lane in range(images.shape[0]):
        for k in range(images.shape[1]):
            if visits.label[lane] != _NO_LABEL:
                break
            state = images[lane, k]
            if not math.isfinite(state[0]):
                break
            before = visits.point[lane]
            point = _near(marks, state, marks.following[before] if before >= 0 else -1)
            if point >= 0:
                found, going_on = marks.label[point], before >= 0
                going_on = going_on and point == marks.following[before]
            else:
                found = _owner_of_cell(marks, state)
                if found == _NO_LABEL and before < 0:  # a set has cells that are not known yet
                    visits.score[lane] = max(0, visits.score[lane] - _MISS)
                    continue
                going_on = before < 0 and found == visits.candidate[lane]
            visits.score[lane] = visits.score[lane] + 1 if going_on else 1
            visits.candidate[lane], visits.point[lane] = found, point
            enough = marks.in_cycle if point >= 0 else marks.in_set
            if found != _NO_LABEL and visits.score[lane] >= enough:
                visits.label[lane] = found
                visits.needed[lane] = first + k
