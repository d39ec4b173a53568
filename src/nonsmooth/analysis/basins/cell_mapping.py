"""Cell-to-cell mapping: every cell goes to the cell in which the image of its centre lies.

C. S. Hsu, Cell-to-Cell Mapping (Springer, 1987). The map of cells is a map of whole numbers, so all
of its cycles and what comes to them are found exactly; what is approximate is the centre that
stands for the cell. Three rules beside Hsu's: the image is that after as many iterates as it takes
for the answer to stay, since each one is rounded to a cell; a motion whose image lies outside the
grid is followed until it comes back; and a cell whose centre no mode admits stands for the first
image that lies in it, as on the surface on which a slaved state lives.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.engine.status import Status
from nonsmooth.runs.crew import Stopped, run_tasks

__all__ = ["ENDS", "NOWHERE", "REFUSED", "CellMap", "Part", "map_points"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NOWHERE, ENDS, REFUSED = -1, -2, -3  # images of cells that go to none
_TOGETHER = 1024  # cells in a task
_OUTSIDE = 100  # iterates after which a motion outside the grid is left there


@dataclass(frozen=True)
class Part:
    """Where some cells have come."""

    points: Floats  # (K, n): images of their states after all iterates
    modes: Integers  # (K,)
    image: Integers  # (K,): cell, or one of the above
    landing: Floats  # (K, n): point that lies in it


class CellMap:
    """Image of every cell after some iterates, which may be doubled."""

    def __init__(self, grid: Grid, make_runner: Callable[[], Any], threads: int) -> None:
        self.grid = grid
        self.states = grid.states(np.arange(grid.size))  # that stand for the cells
        self.image = np.full(grid.size, REFUSED, np.int64)
        self.iterates = 0
        self._points, self._landing = self.states.copy(), self.states.copy()
        self._modes = np.full(grid.size, ANY, np.int64)
        self._make_runner, self._threads = make_runner, threads

    def double(self) -> bool:
        """Map on for as many iterates again, once at first; False after an interruption."""
        if self.iterates > 0:
            alive = np.flatnonzero(self._modes >= 0)
            modes = self._modes.copy()
            self._modes[alive] = SAME - modes[alive]
            self.iterates *= 2
            return self._advance(alive, self.iterates // 2)
        self.iterates = 1
        cells, tried = np.arange(self.grid.size), np.zeros(self.grid.size, bool)
        complete = True
        while cells.size and complete:
            complete = self._advance(cells, 1)
            tried |= self.image != REFUSED
            sources = np.flatnonzero(self.image >= 0)
            entered, first = np.unique(self.image[sources], return_index=True)
            new = ~tried[entered]
            cells = entered[new]
            tried[cells] = True
            self.states[cells] = self._landing[sources[first[new]]]
            self._points[cells], self._modes[cells] = self.states[cells], ANY
        return complete

    def _advance(self, cells: Integers, count: int) -> bool:
        def keep(places: Integers, part: Part) -> None:
            chosen = cells[places]
            self._points[chosen], self._modes[chosen] = part.points, part.modes
            self.image[chosen], self._landing[chosen] = part.image, part.landing

        points, modes = self._points[cells], self._modes[cells]
        return map_points(
            self.grid, points, modes, count, self._make_runner, self._threads, keep,
            f"cells, {self.iterates} iterates",
        )  # fmt: skip


def map_points(
    grid: Grid,
    points: Floats,
    modes: Integers,
    count: int,
    make_runner: Callable[[], Any],
    threads: int,
    keep: Callable[[Integers, Part], None],
    label: str,
    outside: int = _OUTSIDE,
) -> bool:
    """Map points on; ``keep`` is told the numbers of some and where they came.

    Those outside the grid are mapped on until they come back, ``outside`` times at most.
    False after an interruption.
    """
    everything = np.arange(len(points))
    chunks = [everything[i : i + _TOGETHER] for i in range(0, len(points), _TOGETHER)]
    return run_tasks(
        [_task(grid, points[c], modes[c], count, outside) for c in chunks],
        make_runner,
        threads=threads,
        label=label,
        keep=lambda i, part: keep(chunks[i], part),
    )


def _task(
    grid: Grid, points: Floats, modes: Integers, count: int, outside: int
) -> Callable[[Any, threading.Event], Part]:
    def run(runner: Any, stop: threading.Event) -> Part:
        return _part(grid, runner, points, modes, count, stop, outside)

    return run


def _part(
    grid: Grid,
    runner: Any,
    points: Floats,
    modes: Integers,
    count: int,
    stop: threading.Event,
    most: int,
) -> Part:
    """Map some points on, and find the cells in which they come to lie."""
    lanes = runner.start(points, modes)
    images, image_modes = runner.last(lanes, count, stop)
    going_on = lanes.status == Status.COMPLETED
    columns = [grid.completion.system.states.index(name) for name in grid.completion.given]
    image = np.full(len(points), ENDS, np.int64)
    image[lanes.status == Status.INADMISSIBLE] = REFUSED
    image[going_on] = grid.cells(images[going_on][:, columns])
    landing, outside = images.copy(), np.flatnonzero(going_on & (image == NOWHERE))
    lanes = lanes.select(outside)
    for _ in range(most):
        if not outside.size:
            break
        if stop.is_set():
            raise Stopped
        later, _ = runner.last(lanes, 1, stop)
        here = np.full(outside.size, ENDS, np.int64)
        going_on = lanes.status == Status.COMPLETED
        here[going_on] = grid.cells(later[going_on][:, columns])
        image[outside], landing[outside] = here, later
        kept = np.flatnonzero(here == NOWHERE)
        outside, lanes = outside[kept], lanes.select(kept)
    return Part(images, image_modes, image, landing)
