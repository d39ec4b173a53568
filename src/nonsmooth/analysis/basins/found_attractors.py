"""The attractors that starts sampled from a box come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import AttractorSearch, Settled, measure_of
from nonsmooth.analysis.basins.recurrences import Known
from nonsmooth.analysis.basins.region import Box
from nonsmooth.analysis.basins.starts import admissible_starts
from nonsmooth.runs.progress import Progress
from nonsmooth.system.system import System

__all__ = ["FIRST_LOOK", "Found", "drift_mask", "find_attractors"]

FIRST_LOOK = 64  # images from which the units of the states are taken


@dataclass(frozen=True)
class Found:
    """Attractors that the sampled starts came to."""

    known: Known
    search: AttractorSearch
    settled: Settled
    drawn: int  # starts, those that no mode admits among them
    complete: bool


def find_attractors(chosen: Any, box: Box, how: Search) -> Found:
    """Settle the starts of a box."""
    runner = chosen.runner(how.tolerance)
    starts, drawn = admissible_starts(runner, box, how.samples, how.seed)
    drifting = drift_mask(chosen.system)
    lanes = runner.start(starts)
    images, _ = runner.iterate(lanes, FIRST_LOOK)
    known = Known(measure_of(images, starts, drifting, how.cells))
    complete, settled = True, Settled(np.zeros(0, np.int64), np.zeros(0, np.int64))
    with Progress("attractors", len(starts)) as progress:
        search = AttractorSearch(
            runner, known, drifting,
            match=how.match, longest=how.longest, record=how.record, tell=progress.update,
        )  # fmt: skip
        try:
            settled = search.settle(starts)
        except KeyboardInterrupt:
            complete = False
    return Found(known, search, settled, drawn, complete)


def drift_mask(system: System) -> npt.NDArray[np.bool_]:
    """Which states drift, (n,)."""
    return np.array([name in system.drift_states for name in system.states])
