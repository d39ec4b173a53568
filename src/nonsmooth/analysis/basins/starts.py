"""Starts drawn evenly from a box, those that some mode admits."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.basins.region import Box
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import complete_state

__all__ = ["admissible_starts"]

_MOST_DRAWN = 50  # times as many as are wanted


def admissible_starts(
    runner: Any, box: Box, count: int, seed: int
) -> tuple[npt.NDArray[np.float64], int]:
    """Starts from a scrambled Sobol sequence, and how many were drawn for them.

    Such points fill a box more evenly than random ones, so that what is larger than a few of
    their gaps is not missed.

    returns: states (count, n), number drawn
    """
    sequence = qmc.Sobol(len(box.low), rng=np.random.default_rng(seed))
    found, n_found, drawn = [], 0, 0
    while n_found < count and drawn < _MOST_DRAWN * count:
        # powers of two keep the balance of the sequence
        batch = box.states(sequence.random(2 ** max(6, int(np.ceil(np.log2(count))))))
        batch = _completed(runner, box, batch)
        lanes = runner.start(batch)
        runner.last(lanes, 1)
        admitted = lanes.status != Status.INADMISSIBLE
        found.append(batch[admitted][: count - n_found])
        n_found += len(found[-1])
        last = np.flatnonzero(admitted)[len(found[-1]) - 1] if n_found >= count else len(batch) - 1
        drawn += int(last) + 1
    if n_found == 0:
        raise OptionError(
            f"no mode admits any of {drawn} starts in the region; choose another region, or"
            " complete the other states so that starts are admissible, as in"
            " completion={'q': 'max(0, p - g)'}"
        )
    return np.concatenate(found), drawn


def _completed(runner: Any, box: Box, states: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """States with those that were left to the equations of a mode, given as nan, solved for."""
    if not np.any(np.isnan(states)):
        return states
    system = box.completion.system
    tables, begin = build_tables(system), getattr(runner, "begin", Instant(0, 0.0))
    return np.array([complete_state(system, tables, state, begin) for state in states])
