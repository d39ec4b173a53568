"""Points spread over all cells of a grid, and the cells or attractors to which they have come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.cell_mapping import NOWHERE, REFUSED, Part, map_points
from nonsmooth.analysis.basins.recurrences import Known, new_visits
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.attractors import visit
from nonsmooth.engine.lanes import ANY, SAME

__all__ = ["CellPoints"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_SIDE = 3  # points along each state of a cell


class CellPoints:
    """Points of every cell and where they are after some iterates, which may be doubled.

    A cell none of whose points is admissible has the first image that lies in it as its point.
    """

    def __init__(self, grid: Grid, make_runner: Callable[[], Any], threads: int) -> None:
        self.grid, self.iterates = grid, 0
        self.states = grid.states(np.arange(grid.size))  # that stand for the cells
        self.centre = np.full(grid.size, -1, np.int64)  # number of the point that does
        self.source = np.zeros(0, np.int64)  # cell of each point
        self.image = np.zeros(0, np.int64)  # cell in which it lies now
        self.owner = np.zeros(0, np.int64)  # attractor at which it is now, 0 for none
        self._seen = np.zeros(0, np.int64)  # at which it was before
        self._points = np.zeros((0, self.states.shape[1]))
        self._modes = np.zeros(0, np.int64)
        self._make_runner, self._threads = make_runner, threads

    def double(self) -> bool:
        """Map on for as many iterates again, once at first; False after an interruption."""
        if self.iterates == 0:
            return self._begin()
        # what is at an attractor for the second time stays there
        here = (self.owner > 0) & (self.owner == self._seen)
        self._seen = self.owner.copy()
        moving = np.flatnonzero((self._modes >= 0) & ~here)
        count, self.iterates = self.iterates, 2 * self.iterates
        points, modes = self._points[moving], SAME - self._modes[moving]
        part, complete = self._mapped(points, modes, count)
        self._points[moving], self._modes[moving] = part.points, part.modes
        self.image[moving] = part.image
        return complete

    def recognise(self, known: Known) -> None:
        """See which points are at an attractor: in a ball of convergence, or a cell of a set."""
        marks = known.landmarks().replace(in_cycle=1, in_set=1)
        visits = new_visits(len(self._points))
        visit(np.ascontiguousarray(self._points[:, None, :]), 1, marks, visits)
        self.owner = np.where(self._modes >= 0, visits.label, 0)

    def lost(self) -> tuple[Integers, Integers]:
        """Numbers of points at no known attractor, outside the grid and in it."""
        left, outside = (self._modes >= 0) & (self.owner == 0), self.image == NOWHERE
        return np.flatnonzero(left & outside), np.flatnonzero(left & ~outside)

    def come_to(self, some: Integers) -> tuple[Floats, Integers]:
        """Where some points are now, and the modes from which they go on."""
        return self._points[some], SAME - self._modes[some]

    def _begin(self) -> bool:
        self.iterates, count = 1, self.grid.size
        inner = self.grid.inner_states(np.arange(count), _SIDE)
        points, source = (
            inner.reshape(-1, inner.shape[2]),
            np.repeat(np.arange(count), inner.shape[1]),
        )
        middle = np.tile(np.arange(inner.shape[1]) == inner.shape[1] // 2, count)
        complete = True
        while len(points) and complete:
            part, complete = self._mapped(points, np.full(len(points), ANY), 1)
            admitted = np.flatnonzero(part.image != REFUSED)
            # the middle one stands for the cell where a mode admits it
            order = admitted[np.argsort(~middle[admitted], kind="stable")]
            cells, first = np.unique(source[order], return_index=True)
            self.states[cells] = points[order[first]]
            place = np.full(len(points), -1, np.int64)
            place[admitted] = len(self.source) + np.arange(admitted.size)
            self.centre[cells] = place[order[first]]
            self.source = np.concatenate([self.source, source[admitted]])
            self.image = np.concatenate([self.image, part.image[admitted]])
            self._points = np.concatenate([self._points, part.points[admitted]])
            self._modes = np.concatenate([self._modes, part.modes[admitted]])
            to = np.flatnonzero(part.image >= 0)
            entered, which = np.unique(part.image[to], return_index=True)
            new = self.centre[entered] < 0
            points, source = part.points[to[which[new]]], entered[new]
            middle = np.ones(len(points), bool)
        self.owner = np.zeros(len(self.source), np.int64)
        self._seen = self.owner.copy()
        return complete

    def _mapped(self, points: Floats, modes: Integers, count: int) -> tuple[Part, bool]:
        total = len(points)
        whole = Part(
            points.copy(), np.full(total, ANY), np.full(total, NOWHERE, np.int64), points.copy()
        )

        def keep(places: Integers, part: Part) -> None:
            for mine, theirs in zip(vars(whole).values(), vars(part).values(), strict=True):
                mine[places] = theirs

        # points outside the grid are mapped on with the others, and so need not be followed
        complete = map_points(
            self.grid, points, modes, count, self._make_runner, self._threads, keep,
            f"points of cells, {self.iterates} iterates", outside=0,
        )  # fmt: skip
        return whole, complete
