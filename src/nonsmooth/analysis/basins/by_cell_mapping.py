"""Basins by mapping cells to cells."""

from __future__ import annotations

from pathlib import Path
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
from nonsmooth.analysis.basins.changed_labels import (
    DOUBLINGS,
    LEAST_ITERATES,
    SETTLED,
    TWICE,
    changed_by,
)
from nonsmooth.analysis.basins.found_basins import Basins, look_closer, search_from
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.errors import OptionError

__all__ = ["by_cell_mapping"]

Integers = npt.NDArray[np.int64]


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
        raise OptionError("store= is for method='recurrences' alone; leave it out")
    cells = CellMap(grid, lambda: chosen.runner(how.tolerance), threads)
    label, steps = np.full(grid.size, NOT_COMPUTED), np.zeros(grid.size, np.int64)
    search, changed, settled_for = None, 1.0, 0
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
        changed = changed_by(before, label, grid)
        settled_for = settled_for + 1 if changed <= SETTLED else 0
        if settled_for == TWICE and cells.iterates >= LEAST_ITERATES:
            break
    assert search is not None
    settled = Settled(label, steps)
    complete = look_closer(search, grid, settled)
    notes = {"iterates_per_cell": cells.iterates, "changed_by_doubling": changed}
    return Basins(search.known.attractors, settled, complete, notes=notes)


def _labels(search: AttractorSearch, cells: CellMap, cycles: Cycles) -> Integers:
    """Label of each cell: of the attractor to which a centre of its cycle comes."""
    label = np.full(cells.image.size, UNSETTLED, np.int64)
    if cycles.first.size:
        reached = search.settle(cells.states[cycles.first]).label
        label = np.where(cycles.of_cell >= 0, reached[cycles.of_cell], UNSETTLED)
    label[cells.image == ENDS] = ENDED
    label[cells.image == REFUSED] = INADMISSIBLE
    return label
