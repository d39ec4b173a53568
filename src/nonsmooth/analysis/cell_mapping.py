"""Cell-to-cell mapping: every cell goes to the cell in which the image of its centre lies.

C. S. Hsu, Cell-to-Cell Mapping (Springer, 1987). The map of cells is a map of whole numbers, so all
of its cycles and what comes to them are found exactly; what is approximate is the centre that
stands for the cell. Two rules beside Hsu's: a centre whose image leaves the grid is mapped on
until it comes back, and a cell whose centre no mode admits is mapped from the first image that
lies in it, as on the surface on which a slaved state lives.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.region import Grid
from nonsmooth.engine.status import Status
from nonsmooth.simulation.crew import Stopped
from nonsmooth.simulation.stored_tasks import run_stored_tasks

__all__ = ["CellMap", "Cycles", "cycles_of", "map_cells"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NOWHERE, ENDS, REFUSED = -1, -2, -3  # images of cells that go to none
_TOGETHER = 4096  # cells in a task
_OUTSIDE = 200  # iterates after which a motion outside the grid is left there


@dataclass(frozen=True)
class CellMap:
    """Image of every cell, and the state that stands for it."""

    image: Integers  # (N,): number of a cell, or one of the above
    states: Floats  # (N, n)
    complete: bool


@dataclass(frozen=True)
class Cycles:
    """Cycles of a map of cells, and to which of them each cell comes."""

    first: Integers  # (C,): one cell of each cycle, the least
    length: Integers  # (C,)
    of_cell: Integers  # (N,): number of the cycle, -1 where a cell goes to none
    steps: Integers  # (N,): until the cell is in the cycle, or has no image


def map_cells(
    grid: Grid,
    make_runner: Callable[[], Any],
    *,
    threads: int,
    store: str | Path | None,
    protocol: dict[str, Any],
) -> CellMap:
    """Map every cell of a grid once."""
    states = grid.states(np.arange(grid.size))
    image = np.full(grid.size, REFUSED, np.int64)
    cells, complete, turn = np.arange(grid.size), True, 0
    while cells.size and complete:
        points = np.full((cells.size, states.shape[1]), np.nan)
        chunks = [slice(i, i + _TOGETHER) for i in range(0, cells.size, _TOGETHER)]
        found = np.full(cells.size, REFUSED, np.int64)

        def keep(
            i: int,
            result: tuple[Integers, Floats],
            found: Integers = found,
            points: Floats = points,
            chunks: list[slice] = chunks,
        ) -> None:
            found[chunks[i]], points[chunks[i]] = result

        complete = run_stored_tasks(
            [_task(grid, states[cells[chunk]]) for chunk in chunks],
            make_runner,
            store=None if store is None or turn > 0 else store,  # later turns are small
            protocol=protocol,
            pack=lambda result: {"image": result[0], "points": result[1]},
            unpack=lambda arrays: (arrays["image"], arrays["points"]),
            threads=threads,
            label="cells",
            keep=keep,
        )
        image[cells] = found
        # cells that are entered for the first time, and that their centres could not map
        entered = found >= 0
        where, source = np.unique(found[entered], return_index=True)
        new = image[where] == REFUSED
        if turn > 0:
            new &= ~np.isin(where, cells)  # one trial each
        cells, chosen = where[new], source[new]
        states[cells] = points[entered][chosen]
        turn += 1
    return CellMap(image, states, complete)


def _task(grid: Grid, states: Floats) -> Callable[[Any, threading.Event], tuple[Integers, Floats]]:
    def run(runner: Any, stop: threading.Event) -> tuple[Integers, Floats]:
        return _images(grid, runner, states, stop)

    return run


def _images(
    grid: Grid, runner: Any, starts: Floats, stop: threading.Event
) -> tuple[Integers, Floats]:
    """Cells in which the images lie, and the images."""
    columns = [grid.completion.system.states.index(name) for name in grid.completion.given]
    image = np.full(len(starts), NOWHERE, np.int64)
    points = np.full(starts.shape, np.nan)
    lanes, left = runner.start(starts), np.arange(len(starts))
    for k in range(_OUTSIDE):
        if stop.is_set():
            raise Stopped
        ends = runner.advance(lanes, 1, stop)
        going_on = lanes.status == Status.COMPLETED
        lost = np.where((lanes.status == Status.INADMISSIBLE) & (k == 0), REFUSED, ENDS)
        found = np.full(len(ends), NOWHERE, np.int64)
        found[going_on] = grid.cells(ends[going_on][:, columns])
        arrived = going_on & (found >= 0)
        image[left] = np.where(going_on, found, lost)
        points[left[arrived]] = ends[arrived]
        kept = np.flatnonzero(going_on & (found < 0))
        left, lanes = left[kept], lanes.select(kept)
        if not left.size:
            break
    return image, points


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
