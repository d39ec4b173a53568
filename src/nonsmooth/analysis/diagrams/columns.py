"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.maps import Map
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["Look", "Protocol", "nothing", "with_outputs"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Protocol:
    """How every column is computed."""

    chosen: Map
    parameter: str
    transient: int
    record: int
    match: float
    exits: npt.NDArray[np.bool_] | None  # (m, e): events at which states are taken; None: strobes
    after: bool  # whether these are the states after the event
    drifting: npt.NDArray[np.bool_]  # (n,)
    outputs: bool  # whether outputs are worked out at the points

    @property
    def system(self) -> System:
        """The system with the parameters of the call."""
        return self.chosen.system

    @property
    def strobed(self) -> StroboscopicMap:
        """The map, where it is one of strobes."""
        assert isinstance(self.chosen, StroboscopicMap)
        return self.chosen

    @property
    def unit(self) -> str:
        """What iterates of the map are called."""
        chosen = self.chosen
        if isinstance(chosen, StroboscopicMap) and (chosen.length, chosen.every) == (None, 1):
            return "period"
        return "iterate"


@dataclass(frozen=True)
class Look:
    """What one motion shows; K points, n states."""

    status: Status
    points: Floats  # (K, n + outputs)
    numbers: Integers  # (K,): window of each point
    phases: Floats  # (K,)
    modes: Integers  # (K,)
    period: int  # in iterates of the map; 0 where none was found
    word: str
    events: float  # per iterate
    impacts: float  # see `Impacts`
    drift: Floats  # (n,): change of each state per iterate
    uncertain: int
    estimated: int
    window: float  # mean time of an iterate


def with_outputs(
    system: System,
    tables: Tables,
    points: Floats,
    numbers: Integers,
    phases: Floats,
    modes: Integers,
) -> Floats:
    """Points with the outputs as further columns."""
    found = output_values(system, SampleClock(numbers, phases, tables), points.T, modes)
    return np.column_stack([points, *found.values()])


def nothing(status: Status, n: int, window: float) -> Look:
    """A motion that left nothing to look at."""
    whole = np.zeros(0, np.int64)
    return Look(
        status, np.zeros((0, n)), whole, np.zeros(0), whole, 0, "", np.nan, np.nan,
        np.full(n, np.nan), 0, 0, window,
    )  # fmt: skip
