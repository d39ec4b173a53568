"""Basins, by whichever method: labels of all cells, and the attractors they stand for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import (
    UNSETTLED,
    AttractorSearch,
    Settled,
    measure_of,
)
from nonsmooth.analysis.basins.found_attractors import FIRST_LOOK, drift_mask
from nonsmooth.analysis.basins.recurrences import Known
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.errors import OptionError
from nonsmooth.runs.progress import Progress

__all__ = ["Basins", "look_closer", "search_from"]

Floats = npt.NDArray[np.float64]

_AT_ONCE = 256  # starts that are looked at more closely together


@dataclass(frozen=True)
class Basins:
    """Label of every cell, and the attractors."""

    attractors: list[Attractor]
    settled: Settled
    complete: bool
    probability: Floats | None = None  # of the label, where the method tells
    notes: Mapping[str, Any] = field(default_factory=dict)  # what the method tells beside
    remark: str = ""  # that the message ends with


def look_closer(search: AttractorSearch, grid: Grid, settled: Settled) -> bool:
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


def search_from(chosen: Any, states: Floats, how: Search) -> AttractorSearch:
    """A search whose units are those of motions from states all over a grid; (K, n)."""
    if not len(states):
        raise OptionError(
            "no mode admits the centre of any cell; choose another region, or finer cells"
        )
    runner, drifting = chosen.runner(how.tolerance), drift_mask(chosen.system)
    some = states[:: max(1, len(states) // _AT_ONCE)]
    images, _ = runner.iterate(runner.start(some), FIRST_LOOK)
    known = Known(measure_of(images, some, drifting, how.cells))
    return AttractorSearch(
        runner, known, drifting, match=how.match, longest=how.longest, record=how.record
    )
