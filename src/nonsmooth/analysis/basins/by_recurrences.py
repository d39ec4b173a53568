"""Basins by following the centre of every cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import Settled
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED, label_starts
from nonsmooth.analysis.basins.found_attractors import find_attractors
from nonsmooth.analysis.basins.found_basins import Basins, look_closer
from nonsmooth.analysis.basins.region import Box, Grid

__all__ = ["by_recurrences"]


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
        grid.states, grid.size, found.known.landmarks(), found.known.cycles(),
        lambda: chosen.runner(how.tolerance), longest=how.longest, threads=threads, store=store,
        protocol=protocol,
    )  # fmt: skip
    if complete:
        complete = look_closer(found.search, grid, settled)
    resting = found.known.cycles().unconfirmed(settled.label)
    remark = (
        f"{resting} cells come to cycles that attract too slowly to be confirmed: they rest on"
        " trial starts around these"
    )
    return Basins(
        found.known.attractors, settled, complete, notes={"unconfirmed_cells": resting},
        remark=remark if resting else "",
    )  # fmt: skip
