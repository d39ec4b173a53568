"""Basins by mapping cells to cells."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    UNSETTLED,
    AttractorSearch,
    Settled,
)
from nonsmooth.analysis.basins.cell_cycles import Cycles, cycles_of
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED
from nonsmooth.analysis.basins.cell_mapping import ENDS, REFUSED, CellMap
from nonsmooth.analysis.basins.changed_labels import DOUBLINGS, SETTLED, Changes
from nonsmooth.analysis.basins.found_basins import Basins, look_closer, search_from
from nonsmooth.analysis.basins.region import Grid

__all__ = ["by_cell_mapping"]

Integers = npt.NDArray[np.int64]


def by_cell_mapping(
    chosen: Any,
    grid: Grid,
    how: Search,
    threads: int,
) -> Basins:
    """Map cells to cells, and follow the cycles of that map by the exact one."""
    cells = CellMap(grid, lambda: chosen.runner(how.tolerance), threads)
    label, steps = np.full(grid.size, NOT_COMPUTED), np.zeros(grid.size, np.int64)
    search, changes = None, Changes(grid)
    for _ in range(DOUBLINGS):
        if not cells.double():
            return Basins(
                [] if search is None else search.known.attractors, Settled(label, steps), False
            )
        if search is None:
            search = search_from(chosen, cells.states[cells.image != REFUSED], how)
        cycles = cycles_of(cells.image)
        try:
            before, label = label, _labels(search, cells, cycles)
        except KeyboardInterrupt:
            return Basins(search.known.attractors, Settled(label, steps), False)
        steps = cycles.steps * cells.iterates
        changes.note(before, label)
        if changes.have_ended(cells.iterates):
            break
    assert search is not None
    settled = Settled(label, steps)
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


def _labels(search: AttractorSearch, cells: CellMap, cycles: Cycles) -> Integers:
    """Label of each cell: of the attractor to which a centre of its cycle comes."""
    label = np.full(cells.image.size, UNSETTLED, np.int64)
    if cycles.first.size:
        reached = search.settle(cells.states[cycles.first]).label
        label = np.where(cycles.of_cell >= 0, reached[cycles.of_cell], UNSETTLED)
    label[cells.image == ENDS] = ENDED
    label[cells.image == REFUSED] = INADMISSIBLE
    return label
