"""Basins of attraction as an xarray dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.analysis.basins.attractor import renumbered
from nonsmooth.analysis.basins.attractor_dataset import attractor_variables, common_attributes
from nonsmooth.analysis.basins.attractor_search import ENDED, INADMISSIBLE, UNSETTLED
from nonsmooth.analysis.basins.attractor_words import with_words
from nonsmooth.analysis.basins.basins import Basins
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.simulation.labels import labels_of

__all__ = ["basin_dataset"]


def basin_dataset(chosen: Any, grid: Grid, basins: Basins, options: dict[str, Any]) -> xr.Dataset:
    """Labels over the states of the region, beside the attractors."""
    system = chosen.system
    order, label = renumbered(basins.attractors, basins.settled.label)
    order = with_words(chosen, order, options["tolerance"])
    variables, coords = attractor_variables(system, order, label[label > INADMISSIBLE])
    names = grid.completion.given
    dims = tuple(reversed(names))
    words = labels_of(system)
    variables["label"] = (
        dims,
        label.reshape(grid.shape).astype(np.int16),
        {
            "long_name": "attractor",
            "comment": "0: unsettled, -1: ended early, -2: inadmissible, -3: not computed",
        },
    )
    if basins.probability is None:
        variables["iterations"] = (
            dims, basins.settled.needed.reshape(grid.shape).astype(np.int32),
            {"long_name": "iterates until the attractor was known"},
        )  # fmt: skip
    else:
        variables["probability"] = (
            dims, basins.probability.reshape(grid.shape),
            {"long_name": "probability of the attractor of the label"},
        )  # fmt: skip
    for name, axis in zip(names, grid.axes, strict=True):
        coords[name] = ((name,), axis, words.attributes(name))
    counts = {
        "unsettled_cells": int(np.sum(label == UNSETTLED)),
        "ended_cells": int(np.sum(label == ENDED)),
        "inadmissible_cells": int(np.sum(label == INADMISSIBLE)),
        "cells_left_out": int(np.sum(label == NOT_COMPUTED)),
    }
    status = "completed" if basins.complete else "interrupted"
    attrs = common_attributes(
        system, status, _message(counts, basins.complete), options | counts | dict(basins.notes)
    )
    return xr.Dataset(variables, coords, attrs)


def _message(counts: dict[str, int], complete: bool) -> str:
    if not complete:
        return "interrupted by the user; the cells that are done are kept"
    if counts["unsettled_cells"]:
        return (
            f"{counts['unsettled_cells']} cells came to no attractor in the longest time; raise"
            " longest="
        )
    return "completed"
