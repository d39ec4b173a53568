"""How the lanes of an ensemble are run, and what is told of some of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.members import Members
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Plan
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

__all__ = ["Chunk", "EnsembleProtocol", "empty_chunk"]

Chunk = dict[str, npt.NDArray[np.generic]]  # see `empty_chunk`


@dataclass(frozen=True)
class EnsembleProtocol:
    """How every lane is run."""

    system: System
    members: Members
    plan: Callable[[float], Plan]  # end and times of samples for a length of the window
    n_points: int
    modes: tuple[int, ...]  # of the starts, the first that admits one; -1 for any


def empty_chunk(protocol: EnsembleProtocol, count: int, status: Status) -> Chunk:
    """What is told of lanes that were not run.

    shapes: points (lane, point, state or output), modes (lane, point), initial and end (lane,
    state), all else (lane,)
    """
    n = len(protocol.system.states)
    shape = (count, protocol.n_points)
    return {
        "points": np.full((*shape, n + len(protocol.system.outputs)), np.nan),
        "modes": np.full(shape, -1, labels_of(protocol.system).mode_type),
        "initial": np.full((count, n), np.nan),
        "end": np.full((count, n), np.nan),
        "end_time": np.full(count, np.nan),
        "status": np.full(count, int(status), np.int8),
        "uncertain": np.zeros(count, np.int64),
        "estimated": np.zeros(count, np.int64),
    }
