"""The points of a tile: what motions settle to there, as a small map."""

from __future__ import annotations

import threading
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.map_question import MapQuestion
from nonsmooth.analysis.regimes.regime_dataset import map_dataset
from nonsmooth.analysis.regimes.regime_run import first_windows, settled_regimes
from nonsmooth.analysis.settle import ParameterSets, settle
from nonsmooth.runs.sweep_runner import SweepRunner

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["tile_map", "verdicts_at"]

Floats = npt.NDArray[np.float64]


def verdicts_at(
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


def tile_map(
    question: MapQuestion, rows: slice, columns: slice, runner: SweepRunner, stop: threading.Event
) -> xr.Dataset:
    """The map of a part of the points of a question."""
    values = (question.values[0][columns], question.values[1][rows])
    second, first = (each.ravel() for each in np.meshgrid(values[1], values[0], indexing="ij"))
    verdicts = np.empty(first.size, object)
    verdicts[:] = verdicts_at(question, first, second, runner, stop)
    shape, nowhere = (values[1].size, values[0].size), np.zeros((0, 2), np.int64)
    return map_dataset(
        question.system, question.names, values, verdicts.reshape(shape), nowhere, {}
    )
