"""Columns of a bifurcation diagram: what motions do for one parameter value, once settled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, pack_end, take_end
from nonsmooth.analysis.options import check_match
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, is_known, quote, unknown_choice, unknown_name
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.part_names import OF_DIAGRAMS, check_part_names
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.whole_turns import cuts_of, folded, periods_of_states
from nonsmooth.system.system import System

__all__ = [
    "DiagramProtocol", "Look", "nothing", "pack_looks", "read_protocol", "unpack_looks",
    "with_outputs",
]  # fmt: skip

_SIDES = ("before", "after")

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
    longest: int  # transient: motions without a period are run on until there
    match: float
    exits: npt.NDArray[np.bool_] | None  # (m, e): events at which states are taken; None: strobes
    after: bool  # whether these are the states after the event
    drifting: npt.NDArray[np.bool_]  # (n,)
    outputs: bool  # whether outputs are worked out at the points

    @property
    def system(self) -> System:
        """The system with the parameters of the call."""
        return self.chosen.system

    def next_transient(self, transient: int) -> int:
        """Transient after which a motion without a period is looked at again; 0 for never."""
        following = 2 * max(transient, self.record)
        return following if following <= self.longest else 0

    def folded(self, points: Floats) -> Floats:
        """Points of one motion, (K, n), with angles within one turn."""
        periods = periods_of_states(self.system)
        return folded(points, cuts_of(points, periods), periods)

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
    transient: int = 0  # iterates before those that are looked at


def read_protocol(
    chosen: Map,
    parameter: str,
    transient: Any,
    record: Any,
    longest: Any,
    match: Any,
    at: Any,
    side: Any,
) -> DiagramProtocol:
    """How every column is computed."""
    system = chosen.system
    if not is_known(side, _SIDES):
        raise OptionError(unknown_choice("side", side, _SIDES))
    check_part_names(system, OF_DIAGRAMS, outputs=True)
    left_out = whole_number("transient", transient, 0)
    most = left_out if longest is None else whole_number("longest", longest, 0)
    if most < left_out:
        raise OptionError(
            f"longest = {most} is less than transient = {left_out}, from which the transient of a"
            " motion without a period is doubled"
        )
    return DiagramProtocol(
        chosen=chosen,
        parameter=parameter,
        transient=left_out,
        record=whole_number("record", record),
        longest=most,
        match=check_match(match),
        exits=_exits(chosen, at, side),
        after=side == "after",
        drifting=np.array([name in system.drift_states for name in system.states]),
        outputs=bool(system.outputs),
    )


def _exits(chosen: Map, at: Any, side: Any) -> npt.NDArray[np.bool_] | None:
    """Exits of each mode with a name; None for the points of the map."""
    system = chosen.system
    if isinstance(chosen, PoincareMap) and (at, side) != ("strobe", "before"):
        raise OptionError(
            f"at = {quote(at)}, side = {quote(side)}: the map says itself where its points lie and"
            " on which side of an event; give these to PoincareMap"
        )
    if is_known(at, ("strobe",)):
        if side != "before":
            raise OptionError(
                f"side = {side!r} is that of an event, and points are taken once per period; name"
                " the event by at="
            )
        return None
    names = system.compiled.exit_names
    known = dict.fromkeys(name for of_mode in names for name in of_mode)
    if not is_known(at, known):
        raise OptionError(f"at: {unknown_name('event', at, ['strobe', *known])}")
    most = max(len(of_mode) for of_mode in names)
    found = np.zeros((len(names), most), bool)
    for m, of_mode in enumerate(names):
        found[m, : len(of_mode)] = [name == at for name in of_mode]
    return found


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
