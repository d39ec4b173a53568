"""The two ways to basins: motions followed to their attractors, and maps of cells."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

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
from nonsmooth.analysis.cell_labels import NOT_COMPUTED, label_starts
from nonsmooth.analysis.cell_mapping import ENDS, REFUSED, cycles_of, map_cells
from nonsmooth.analysis.found_attractors import FIRST_LOOK, drift_mask, find_attractors
from nonsmooth.analysis.recurrences import Known
from nonsmooth.analysis.region import Box, Grid
from nonsmooth.simulation.progress import Progress

__all__ = ["Basins", "by_cell_mapping", "by_recurrences"]

Integers = npt.NDArray[np.int64]

_AT_ONCE = 256  # starts that are looked at more closely together


@dataclass(frozen=True)
class Basins:
    """Label of every cell, and the attractors."""

    attractors: list[Attractor]
    settled: Settled
    complete: bool


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
    runner = chosen.runner(how.tolerance)
    cells = map_cells(
        grid, lambda: chosen.runner(how.tolerance), threads=threads, store=store, protocol=protocol
    )
    if not cells.complete:
        nothing = np.full(grid.size, NOT_COMPUTED)
        return Basins([], Settled(nothing, np.zeros_like(nothing)), False)
    cycles = cycles_of(cells.image)
    starts = cells.states[cycles.first] if cycles.first.size else grid.states(np.arange(1))
    images, _ = runner.iterate(runner.start(starts), FIRST_LOOK)
    drifting = drift_mask(chosen.system)
    known = Known(measure_of(images, starts, drifting, how.cells))
    search = AttractorSearch(
        runner, known, drifting, match=how.match, longest=how.longest, record=how.record
    )
    reached = search.settle(starts).label
    label = np.where(cycles.of_cell >= 0, reached[cycles.of_cell], UNSETTLED)
    label[cells.image == ENDS] = ENDED
    label[cells.image == REFUSED] = INADMISSIBLE
    settled = Settled(label, cycles.steps)
    complete = _look_closer(search, grid, settled)
    return Basins(known.attractors, settled, complete)
