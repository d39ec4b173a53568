"""Basins by mapping cells to cells: chains of cells, their cycles, and where these lead."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    AttractorSearch,
    SearchOptions,
    SettledStarts,
)
from nonsmooth.analysis.basins.by_recurrences import Basins, look_closer, search_from
from nonsmooth.analysis.basins.folded_runner import runner_within_turns
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.engine.status import Status
from nonsmooth.runs.crew import Stopped, run_tasks

__all__ = [
    "DOUBLINGS",
    "ENDS",
    "NOWHERE",
    "REFUSED",
    "SETTLED",
    "CellImages",
    "Changes",
    "by_cell_mapping",
    "cycles_of",
    "map_points",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NOWHERE, ENDS, REFUSED = -1, -2, -3  # images of cells that go to none
_TOGETHER = 1024  # cells in a task
_OUTSIDE = 100  # iterates after which a motion outside the grid is left there

DOUBLINGS = 9  # of the iterates of a cell mapping: 256 at most
_LEAST_ITERATES, _TWICE = 8, 2  # doublings in a row, since coarse pictures may agree by chance
SETTLED = 1e-3  # part of the cells that may still change by doubling
_AWAY = 3  # cells from those of another label; nearer ones depend on the size of cells
_FEW = 0.01  # part of all cells; of fewer that are away, all count


@dataclass(frozen=True)
class CellImages:
    """Where some cells have come."""

    points: Floats  # (K, n): images of their states after all iterates
    modes: Integers  # (K,)
    image: Integers  # (K,): cell, or one of the above
    landing: Floats  # (K, n): point that lies in it
    ending: Integers  # (K,): status of motions that ended, else 0


class CellMap:
    """Image of every cell after some iterates, which may be doubled."""

    def __init__(self, grid: Grid, make_runner: Callable[[], Any], threads: int) -> None:
        self.grid = grid
        self.states = grid.states(np.arange(grid.size))  # that stand for the cells
        self.image = np.full(grid.size, REFUSED, np.int64)
        self.ending = np.zeros(grid.size, np.int64)  # status of motions that ended
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
        def keep(places: Integers, part: CellImages) -> None:
            chosen = cells[places]
            self._points[chosen], self._modes[chosen] = part.points, part.modes
            self.image[chosen], self._landing[chosen] = part.image, part.landing
            self.ending[chosen] = part.ending

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
    keep: Callable[[Integers, CellImages], None],
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
) -> Callable[[Any, threading.Event], CellImages]:
    def run(runner: Any, stop: threading.Event) -> CellImages:
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
) -> CellImages:
    """Map some points on, and find the cells in which they come to lie."""
    lanes = runner.start(points, modes)
    images, image_modes = runner.last(lanes, count, stop)
    going_on = lanes.status == Status.COMPLETED
    columns = [grid.completion.system.states.index(name) for name in grid.completion.given]
    image = np.full(len(points), ENDS, np.int64)
    image[lanes.status == Status.INADMISSIBLE] = REFUSED
    image[going_on] = grid.cells(images[going_on][:, columns])
    landing, outside = images.copy(), np.flatnonzero(going_on & (image == NOWHERE))
    ending = np.where(going_on, 0, lanes.status).astype(np.int64)
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
        ending[outside[~going_on]] = lanes.status[~going_on]
        kept = np.flatnonzero(here == NOWHERE)
        outside, lanes = outside[kept], lanes.select(kept)
    return CellImages(images, image_modes, image, landing, ending)


@dataclass(frozen=True)
class CellCycles:
    """Cycles of a map of cells, and to which of them each cell comes."""

    first: Integers  # (C,): one cell of each cycle, the least
    length: Integers  # (C,)
    of_cell: Integers  # (N,): number of the cycle, -1 where a cell goes to none
    steps: Integers  # (N,): until the cell is in the cycle, or has no image


def cycles_of(image: Integers) -> CellCycles:
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
    return CellCycles(
        first, length, of_cell, _steps(step, in_cycle | (np.arange(count + 1) == gone))
    )


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


class Changes:
    """What doublings have changed."""

    def __init__(self, grid: Grid) -> None:
        self.last = 1.0  # part of the labels that the last doubling changed
        self._grid, self._stayed = grid, 0

    def note(
        self, before: npt.NDArray[np.int64], label: npt.NDArray[np.int64], open_part: float = 0.0
    ) -> None:
        """Take in the labels before and after a doubling, and the part that has none yet."""
        self.last = _changed_by(before, label, self._grid)
        stays = self.last <= SETTLED and open_part <= SETTLED
        self._stayed = self._stayed + 1 if stays else 0

    def have_ended(self, iterates: int) -> bool:
        """Whether further iterates would change little."""
        return self._stayed >= _TWICE and iterates >= _LEAST_ITERATES


def _changed_by(before: npt.NDArray[np.int64], label: npt.NDArray[np.int64], grid: Grid) -> float:
    """Part of the cells away from others that have another label than before."""
    picture = label.reshape(grid.shape)
    width = 2 * _AWAY + 1
    away = ndimage.maximum_filter(picture, width) == ndimage.minimum_filter(picture, width)
    if np.count_nonzero(away) < _FEW * picture.size:
        away = np.ones_like(away)
    return float(np.mean((before != label)[away.ravel()]))


def by_cell_mapping(
    chosen: Any,
    grid: Grid,
    how: SearchOptions,
    threads: int,
) -> Basins:
    """Map cells to cells, and follow the cycles of that map by the exact one."""
    cells = CellMap(grid, lambda: runner_within_turns(chosen, how.tolerance, grid), threads)
    settled = SettledStarts.of(np.full(grid.size, NOT_COMPUTED))
    search, changes = None, Changes(grid)
    for _ in range(DOUBLINGS):
        if not cells.double():
            return Basins([] if search is None else search.known.attractors, settled, False)
        if search is None:
            search = search_from(chosen, cells.states[cells.image != REFUSED], how)
        cycles = cycles_of(cells.image)
        try:
            before, settled = settled, _settled(search, cells, cycles)
        except KeyboardInterrupt:
            return Basins(search.known.attractors, settled, False)
        changes.note(before.label, settled.label)
        if changes.have_ended(cells.iterates):
            break
    assert search is not None
    complete = look_closer(search, grid, settled)
    notes = {"iterates_per_cell": cells.iterates, "changed_by_doubling": changes.last}
    remark = ""
    if complete and changes.last > SETTLED:
        remark = (
            f"after {cells.iterates} iterates per cell the last doubling still changed"
            f" {changes.last:.2%} of the labels away from borders; take finer cells, or"
            " method='recurrences'"
        )
    return Basins(search.known.attractors, settled, complete, notes=notes, remark=remark)


def _settled(search: AttractorSearch, cells: CellMap, cycles: CellCycles) -> SettledStarts:
    """What each cell comes to: the attractor to which a centre of its cycle does."""
    label = np.full(cells.image.size, UNSETTLED, np.int64)
    ending = cells.ending.copy()
    if cycles.first.size:
        reached, in_cycle = search.settle(cells.states[cycles.first]), cycles.of_cell >= 0
        label[in_cycle] = reached.label[cycles.of_cell[in_cycle]]
        ending[in_cycle] = reached.ending[cycles.of_cell[in_cycle]]
    label[cells.image == ENDS] = ENDED
    label[cells.image == REFUSED] = INADMISSIBLE
    return SettledStarts(label, cycles.steps * cells.iterates, ending)
