"""Recurrences of lanes: which of them have come to a known attractor, and stay.

Attractors are told by their points. A cycle has a ball around each of its points, in which all
motions are known to converge to it; a larger set has the cells of a grid that it visits. States
are compared in units of a scale for each. Cells are known by a hash of their numbers, so that no
grid is ever stored.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from nonsmooth.engine.library import engine
from nonsmooth.engine.record import Floats, Integers, Record, array_pointer

__all__ = ["Landmarks", "Visits", "cell_keys", "fill_cells", "visit"]


@dataclass(frozen=True, eq=False)
class Landmarks(Record):
    """Points and cells of the attractors that are known; d states are compared."""

    struct: ClassVar[str] = "Landmarks"

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


@dataclass(frozen=True, eq=False)
class Visits(Record):
    """What lanes have visited last."""

    struct: ClassVar[str] = "Visits"
    in_lanes: ClassVar[tuple[str, ...]] = ("candidate", "point", "score", "label", "needed")

    candidate: Integers  # (L,): attractor, 0 for none
    point: Integers  # (L,): point of a cycle, -1 for none
    score: Integers  # (L,): visits that speak for it
    label: Integers  # (L,): attractor to which the lane has come, 0 for none yet
    needed: Integers  # (L,): images until then


def cell_keys(states: Floats, columns: Integers, scale: Floats, cell: float) -> Integers:
    """Keys (K,) of the cells of some states (K, n), 0 where they are not finite."""
    keys = np.empty(len(states), np.int64)
    states = np.ascontiguousarray(states)
    engine.nonsmooth_cell_keys(
        array_pointer("double", states), array_pointer("int64_t", columns),
        array_pointer("double", scale), cell, array_pointer("int64_t", keys),
    )  # fmt: skip
    return keys


def fill_cells(found: Integers, label: int, keys: Integers, owner: Integers) -> int:
    """Put cells into the table; a cell that is there already stays with its owner.

    shapes: found (C,), keys, owner (H,)
    returns: number of cells that are new
    """
    found = np.ascontiguousarray(found)
    return int(
        engine.nonsmooth_fill_cells(
            array_pointer("int64_t", found), label, array_pointer("int64_t", keys),
            array_pointer("int64_t", owner),
        )
    )  # fmt: skip


def visit(images: Floats, first: int, marks: Landmarks, visits: Visits) -> None:
    """Count the visits of lanes along some images (L, K, n), until each has come to an attractor.

    Cycles are to be visited in the order of their points; of a set, nearly all visits must be to
    its known cells. ``first`` is the number of the first image since the start of the lanes.
    """
    images = np.ascontiguousarray(images)
    engine.nonsmooth_visit(array_pointer("double", images), first, marks.pointer, visits.pointer)
