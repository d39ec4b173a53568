"""The points of a tile: what motions settle to there, as a small map."""

from __future__ import annotations

import threading
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.border_refinement import refine_borders
from nonsmooth.analysis.regimes.label_grid import LabelGrid
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.map_question import MapQuestion
from nonsmooth.analysis.regimes.regime_dataset import map_dataset
from nonsmooth.analysis.regimes.regime_run import first_windows, settled_regimes
from nonsmooth.analysis.settle import ParameterSets, settle
from nonsmooth.runs.sweep_runner import SweepRunner

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["TilePoints", "tile_map", "tile_points"]

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]


class TilePoints(NamedTuple):
    """Verdicts of the points of a tile, and the places (K, 2) in it that were filled."""

    verdicts: npt.NDArray[np.object_]
    filled: Places


def tile_points(
    question: MapQuestion,
    levels: int,
    rows: slice,
    columns: slice,
    runner: SweepRunner,
    stop: threading.Event,
) -> TilePoints:
    """Verdicts of a part of the points of a question, which begins at corners of cells.

    Cells are halved so many times where their labels differ. A tile has no last row and column of
    its cells: these are the first ones of the tiles beyond it, and it computes them for itself.
    """
    height, width = rows.stop - rows.start, columns.stop - columns.start
    beyond = 1 if levels else 0
    second = question.values[1][rows.start : rows.stop + beyond]
    first = question.values[0][columns.start : columns.stop + beyond]
    grid = LabelGrid((second.size, first.size))

    def compute(places: Places) -> bool:
        found = _verdicts_at(question, first[places[:, 1]], second[places[:, 0]], runner, stop)
        for (row, column), verdict in zip(places, found, strict=True):
            grid.verdicts[row, column] = verdict
        grid.number(places)
        return True

    filled = refine_borders(grid.keys, levels, compute)
    grid.fill(filled)
    own = (filled[:, 0] < height) & (filled[:, 1] < width)
    return TilePoints(grid.verdicts[:height, :width], filled[own])


def tile_map(
    question: MapQuestion,
    levels: int,
    rows: slice,
    columns: slice,
    runner: SweepRunner,
    stop: threading.Event,
) -> xr.Dataset:
    """The map of a part of the points of a question."""
    found = tile_points(question, levels, rows, columns, runner, stop)
    values = (question.values[0][columns], question.values[1][rows])
    return map_dataset(question.system, question.names, values, found.verdicts, found.filled, {})


def _verdicts_at(
    question: MapQuestion, first: Floats, second: Floats, runner: SweepRunner, stop: threading.Event
) -> list[Verdict]:
    """Regimes at some values of both parameters, (K,) each."""
    over = dict(zip(question.names, (first, second), strict=True))
    found, _ = settle(
        runner,
        stop,
        sets=ParameterSets(question.strobes, over, question.initial, question.mode),
        times=partial(first_windows, question.protocol),
        reduce=partial(settled_regimes, question.protocol),
    )
    return found
