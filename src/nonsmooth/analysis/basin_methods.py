"""The two ways to basins: motions followed to their attractors, and maps of cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from nonsmooth.analysis.attractor import Attractor
from nonsmooth.analysis.attractor_options import Search
from nonsmooth.analysis.attractor_search import (
    ENDED,
    INADMISSIBLE,
    UNSETTLED,
    AttractorSearch,
    Settled,
    measure_of,
)
from nonsmooth.analysis.cell_cycles import Cycles, cycles_of
from nonsmooth.analysis.cell_labels import NOT_COMPUTED, label_starts
from nonsmooth.analysis.cell_mapping import ENDS, REFUSED, CellMap
from nonsmooth.analysis.found_attractors import FIRST_LOOK, drift_mask, find_attractors
from nonsmooth.analysis.recurrences import Known
from nonsmooth.analysis.region import Box, Grid
from nonsmooth.errors import OptionError
from nonsmooth.simulation.progress import Progress

__all__ = ["Basins", "by_cell_mapping", "by_recurrences"]

Integers = npt.NDArray[np.int64]

_AT_ONCE = 256  # starts that are looked at more closely together
_DOUBLINGS = 9  # of the iterates of a cell mapping: 256 at most
_LEAST_ITERATES, _TWICE = 8, 2  # doublings in a row, since coarse pictures may agree by chance
_SETTLED = 1e-3  # part of the cells that may still change by doubling
_AWAY = 3  # cells from those of another label; nearer ones depend on the size of cells
_FEW = 0.01  # part of all cells; of fewer that are away, all count


@dataclass(frozen=True)
class Basins:
    """Label of every cell, and the attractors."""

    attractors: list[Attractor]
    settled: Settled
    complete: bool
    notes: Mapping[str, Any] = field(default_factory=dict)  # what the method tells beside


def by_recurrences(
    chosen: Any,
    grid: Grid,
    how: Search,
    threads: int,
    store: str | Path | None,
    protocol: dict[str, Any],
) -> Basins:
    """Follow the centre of every cell until it has come to an attractor."""
    ends = np.array([[axis[0], axis[-1]] for axis in grid.axes])
    found = find_attractors(chosen, Box(ends[:, 0], ends[:, 1], grid.completion), how)
    if not found.complete:
        nothing = np.full(grid.size, NOT_COMPUTED)
        return Basins(found.known.attractors, Settled(nothing, np.zeros_like(nothing)), False)
    settled, complete = label_starts(
        grid.states, grid.size, found.known.landmarks(), lambda: chosen.runner(how.tolerance),
        longest=how.longest, threads=threads, store=store, protocol=protocol,
    )  # fmt: skip
    if complete:
        complete = _look_closer(found.search, grid, settled)
    return Basins(found.known.attractors, settled, complete)


def _look_closer(search: AttractorSearch, grid: Grid, settled: Settled) -> bool:
    """Settle cells that came to no known attractor; in place. False after an interruption."""
    left = np.flatnonzero(settled.label == UNSETTLED)
    with Progress("cells that take longer", left.size) as progress:
        try:
            for i in range(0, left.size, _AT_ONCE):
                some = left[i : i + _AT_ONCE]
                result = search.settle(grid.states(some))
                settled.label[some], settled.needed[some] = result.label, result.needed
                progress.update(i + some.size)
        except KeyboardInterrupt:
            return False
    return True


def by_cell_mapping(
    chosen: Any,
    grid: Grid,
    how: Search,
    threads: int,
    store: str | Path | None,
    protocol: dict[str, Any],
) -> Basins:
    """Map cells to cells, and follow the cycles of that map by the exact one."""
    if store is not None:
        raise OptionError(
            "store= is for method='recurrences'; a cell mapping takes a small part of its time"
        )
    cells = CellMap(grid, lambda: chosen.runner(how.tolerance), threads)
    label, steps = np.full(grid.size, NOT_COMPUTED), np.zeros(grid.size, np.int64)
    search, changed, settled_for = None, 1.0, 0
    for _ in range(_DOUBLINGS):
        if not cells.double():
            found = [] if search is None else search.known.attractors
            return Basins(found, Settled(label, steps), False)
        if search is None:
            search = _search_from(chosen, cells, how)
        cycles = cycles_of(cells.image)
        before, label = label, _labels(search, cells, cycles)
        steps = cycles.steps * cells.iterates
        changed = _changed(before, label, grid)
        settled_for = settled_for + 1 if changed <= _SETTLED else 0
        if settled_for == _TWICE and cells.iterates >= _LEAST_ITERATES:
            break
    assert search is not None
    settled = Settled(label, steps)
    complete = _look_closer(search, grid, settled)
    notes = {"iterates_per_cell": cells.iterates, "changed_by_doubling": changed}
    return Basins(search.known.attractors, settled, complete, notes)


def _search_from(chosen: Any, cells: CellMap, how: Search) -> AttractorSearch:
    """A search whose units are those of motions from cells all over the grid."""
    runner, drifting = chosen.runner(how.tolerance), drift_mask(chosen.system)
    admitted = np.flatnonzero(cells.image != REFUSED)
    if not admitted.size:
        raise OptionError(
            "no mode admits the centre of any cell; choose another region, or finer cells"
        )
    some = cells.states[admitted[:: max(1, admitted.size // _AT_ONCE)]]
    images, _ = runner.iterate(runner.start(some), FIRST_LOOK)
    known = Known(measure_of(images, some, drifting, how.cells))
    return AttractorSearch(
        runner, known, drifting, match=how.match, longest=how.longest, record=how.record
    )


def _labels(search: AttractorSearch, cells: CellMap, cycles: Cycles) -> Integers:
    """Label of each cell: of the attractor to which a centre of its cycle comes."""
    label = np.full(cells.image.size, UNSETTLED, np.int64)
    if cycles.first.size:
        reached = search.settle(cells.states[cycles.first]).label
        label = np.where(cycles.of_cell >= 0, reached[cycles.of_cell], UNSETTLED)
    label[cells.image == ENDS] = ENDED
    label[cells.image == REFUSED] = INADMISSIBLE
    return label


def _changed(before: Integers, label: Integers, grid: Grid) -> float:
    """Part of the cells away from others that have another label than before."""
    picture = label.reshape(grid.shape)
    width = 2 * _AWAY + 1
    away = ndimage.maximum_filter(picture, width) == ndimage.minimum_filter(picture, width)
    if np.count_nonzero(away) < _FEW * picture.size:
        away = np.ones_like(away)
    return float(np.mean((before != label)[away.ravel()]))
