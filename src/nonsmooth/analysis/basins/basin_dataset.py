"""Basins of attraction as an xarray dataset."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.analysis.basins.attractor import renumbered
from nonsmooth.analysis.basins.attractor_dataset import (
    attractor_variables,
    common_attributes,
    search_message,
)
from nonsmooth.analysis.basins.attractor_images import with_images
from nonsmooth.analysis.basins.attractor_search import ENDED, INADMISSIBLE, UNSETTLED
from nonsmooth.analysis.basins.attractor_words import with_words
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED
from nonsmooth.analysis.basins.found_basins import Basins
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.errors import OptionError
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

__all__ = ["basin_dataset", "check_names"]

_OF_CELLS = ("label", "iterations", "probability")


def check_names(system: System, region: Iterable[str]) -> None:
    """Refuse states of a region, coordinates of the result, that are called like parts of it."""
    variables, coords = attractor_variables(system, [], np.zeros(0, np.int64))
    dims = {name for dims, *_ in variables.values() for name in dims}
    for name in region:
        if name in {*variables, *coords, *dims, *_OF_CELLS}:
            raise OptionError(
                f"region: {name!r} is also the name of a part of the result; give the state another"
                " name"
            )


def basin_dataset(chosen: Any, grid: Grid, basins: Basins, options: dict[str, Any]) -> xr.Dataset:
    """Labels over the states of the region, beside the attractors."""
    system = chosen.system
    order, label = renumbered(basins.attractors, basins.settled.label)
    order = with_images(
        chosen, with_words(chosen, order, options["tolerance"]), options["tolerance"]
    )
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
    message = "interrupted by the user; the cells that are done are kept"
    if basins.complete:
        message = search_message(
            "cells", counts["unsettled_cells"], counts["ended_cells"], len(order)
        )
    if basins.remark:
        message = f"{message}; {basins.remark}"
    attrs = common_attributes(system, status, message, options | counts | dict(basins.notes))
    return xr.Dataset(variables, coords, attrs)
