"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, pack_end, take_end
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.maps import Map
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = [
    "DiagramProtocol", "Look", "nothing", "pack_looks", "unpack_looks", "with_outputs",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Arrays = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class DiagramProtocol:
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


def pack_looks(found: tuple[Sequence[Look], End | None]) -> Arrays:
    """Arrays of looks, with any number of points each, and of where the last one has ended."""
    looks, end = found
    return pack_end(end) | {
        f"{i}.{field.name}": np.asarray(getattr(look, field.name))
        for i, look in enumerate(looks)
        for field in fields(Look)
    }


def unpack_looks(arrays: Mapping[str, npt.NDArray[Any]]) -> tuple[list[Look], End | None]:
    """The looks and the end of arrays that `pack_looks` made."""
    end, arrays = take_end(arrays)
    names = [field.name for field in fields(Look)]
    return [
        Look(**{name: _value(name, arrays[f"{i}.{name}"]) for name in names})
        for i in range(len(arrays) // len(names))
    ], end


def _value(name: str, array: npt.NDArray[Any]) -> Any:
    if array.ndim:
        return array
    return Status(array.item()) if name == "status" else array.item()
