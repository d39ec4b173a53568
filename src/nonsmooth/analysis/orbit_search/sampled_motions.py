"""Motions from starts spread over a region, or over where a first motion has been."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.basins.region import Box
from nonsmooth.analysis.orbit_search.motions import Motion, motion_from
from nonsmooth.engine.tables import Tables
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.runner import NoMode
from nonsmooth.runs.start import complete_state
from nonsmooth.system.system import System

__all__ = ["drawn_states", "sampled_motions", "states_around"]

Floats = npt.NDArray[np.float64]

_WIDER = 0.5  # of the range of a motion: by how much starts are taken beyond it, on either side


def drawn_states(box: Box, count: int, seed: int) -> Floats:
    """States from a scrambled Sobol sequence in a box; nan where the equations complete them."""
    return box.states(_sobol(len(box.low), count, seed))


def states_around(
    system: System, motion: Motion, drifting: npt.NDArray[np.bool_], count: int, seed: int
) -> Floats:
    """States drawn around a motion.

    In every other one, states that some mode slaves are nan: left to the equations of a mode.
    """
    points = np.concatenate([motion.points, motion.event_states])
    origin = np.array([system.rest_state[name] for name in system.states])
    if not len(points):
        points = origin[None]
    low, high = points.min(axis=0), points.max(axis=0)
    width = np.where(high > low, high - low, 0.0)
    moves = ~drifting & (width > 1e-9 * width.max(initial=1e-12))
    low, high = low - _WIDER * width, high + _WIDER * width
    states = np.where(drifting, origin, points[-1]) + np.zeros((count, len(origin)))
    unit = _sobol(max(int(moves.sum()), 1), count, seed)
    states[:, moves] = (low + unit[:, np.cumsum(moves) - 1] * (high - low))[:, moves]
    slaved = {name for mode in system.modes.values() for name in mode.slaved}
    states[1::2, [name in slaved for name in system.states]] = np.nan
    return states


def _sobol(dimensions: int, count: int, seed: int) -> Floats:
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    drawn: Floats = sequence.random(2 ** int(np.ceil(np.log2(max(count, 1)))))[:count]
    return drawn


def sampled_motions(
    wanted: OrbitRequest, tables: Tables, states: Floats, periods: int, driven: bool
) -> Iterator[Motion | None]:
    """A motion from each state; None where no mode admits it."""
    begin = Instant(0, wanted.phase * tables.window)
    for state in states:
        try:
            if np.any(np.isnan(state)):
                state = complete_state(wanted.system, tables, state, begin)
            yield motion_from(wanted, tables, state, begin, 0, periods, driven)
        except NoMode:
            yield None
