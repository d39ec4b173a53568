"""Motions at many sets of parameter values: each settles, is recorded, and repeats or not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import Columns, Rates
from nonsmooth.engine.extremes import state_maxima
from nonsmooth.engine.lanes import WORK, Anchor, Segment, Tangent
from nonsmooth.engine.library import constant, engine
from nonsmooth.engine.record import Floats, Integers, Record, Rows, array_pointer, zeros
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Sizes, Tables

__all__ = [
    "REPEATS", "Division", "Sweep", "allocate_sweep", "primitive_periods", "run_sweep", "scales",
]  # fmt: skip

REPEATS = constant("REPEATS")  # times that a period must be seen to be believed


class Division(NamedTuple):
    """Divides the one column of each of K motions by its size, so that it stays a number.

    Its entries of states that drift, on which nothing depends, become zero.
    """

    sizes: Floats  # (K, d) output, d being enough for all samples; one where a column has no size
    drifting: npt.NDArray[np.bool_]  # (n,)
    together: int  # samples behind which it is divided


@dataclass(frozen=True, eq=False)
class Sweep(Record):
    """What motions of a sweep are told, and what they leave; K motions with s samples each."""

    struct: ClassVar[str] = "SweepTask"

    modes: Integers  # (K,) of the starts
    begins: Rows  # (K,) instants of motions that follow, none where all start anew
    ends: Rows  # (K,)
    sample_number: Integers  # (K, s)
    sample_phase: Floats  # (K, s)
    sample_state: Floats  # (K, s, n)
    sample_mode: Integers  # (K, s)
    events: Rows  # (c,): the logs, one after the other
    event_states: Floats  # (c, 2, n): before and after each event
    logs: Integers  # (K + 1,): first row of each log
    settling: Rows  # (K,): counters until the first sample, from those of a call before on
    recording: Rows  # (K,): counters from there on
    end_state: Floats  # (K, n)
    since: Rows  # (K,)
    statuses: Integers  # (K,): those that are not COMPLETED at the start are left out
    sizes: Floats  # (K, d) by which the column of each was divided behind so many samples
    drifting: npt.NDArray[np.bool_]  # (n,): states that count for no size
    together: int
    next: int
    stage: int
    tolerance: float
    work: int

    def enlarged(self) -> Sweep:
        """The same sweep, wherever it is, with twice the room for its logs."""
        under_way = self.pointer
        count, states = self.events.size, self.event_states
        events = np.empty(2 * count, self.events.dtype)
        event_states = np.empty((2 * count, *states.shape[1:]))
        events[:count], event_states[:count] = self.events, states
        return self.replace(
            events=events, event_states=event_states, next=under_way.next, stage=under_way.stage
        )


def allocate_sweep(
    sizes: Sizes,
    modes: Integers,
    sample_number: Integers,
    sample_phase: Floats,
    *,
    ends: tuple[Integers, Floats],
    room: int,
    tolerance: float,
    follows: bool = False,
    division: Division | None = None,
) -> Sweep:
    """A sweep with room for so many events, or without a log; columns are divided by their sizes.

    shapes: modes (K,), sample_number and sample_phase (K, s), ends (K,) windows and phases
    """
    count, n = modes.size, sizes.states
    own = zeros(
        Sweep.struct,
        begins=(count if follows else 0,), ends=(count,), logs=(count + 1,), settling=(count,),
        recording=(count,), since=(count,), statuses=(count,),
    )  # fmt: skip
    own["since"]["number"] = own["since"]["phase"] = -np.inf
    own["ends"]["number"], own["ends"]["phase"] = ends
    own["statuses"][:] = Status.COMPLETED
    return Sweep(
        **own,
        modes=modes,
        sample_number=sample_number,
        sample_phase=sample_phase,
        sample_state=np.full((*sample_number.shape, n), np.nan),
        sample_mode=np.full(sample_number.shape, -1, np.int64),
        events=zeros(Sweep.struct, events=(room,))["events"],
        event_states=np.empty((room, 2, n)),
        end_state=np.full((count, n), np.nan),
        **(division or Division(np.zeros((count, 0)), np.zeros(n, bool), 0))._asdict(),
        next=0,
        stage=0,
        tolerance=tolerance,
        work=WORK,
    )


def run_sweep(
    stack: Tables,
    rates: Rates,
    scratch: Columns,
    anchors: Anchor,
    segment: Segment,
    tangents: Tangent,
    sweep: Sweep,
) -> Status:
    """Run the motions of a sweep, each with its own tables of the stack and lane of the tangents.

    returns: COMPLETED, PAUSED (call again) or BUFFER_FULL (call again with an enlarged sweep)
    """
    return Status(
        engine.nonsmooth_run_sweep(
            stack.pointer, rates.pointer, scratch.pointer, anchors.pointer, segment.pointer,
            tangents.pointer, sweep.pointer,
        )
    )  # fmt: skip


def scales(points: Floats, drifting: npt.NDArray[np.bool_]) -> Floats:
    """What a difference of each state is compared with: its largest size, or step of a drift.

    shapes: points (..., s, n), drifting (n,)
    """
    moving = state_maxima(np.abs(np.diff(points, axis=-2)), initial=0.0)
    return np.where(drifting, moving, state_maxima(np.abs(points), initial=0.0))


def primitive_periods(
    points: Floats,
    drifting: npt.NDArray[np.bool_],
    match: float,
    scale: Floats | None = None,
) -> Integers:
    """Smallest number of steps after which the points of each motion repeat, 0 for none.

    A drifting state repeats its steps. Points repeat where all states agree to ``match`` times
    their scale, that of `scales` without another one, and were seen to do so `REPEATS` times.

    shapes: points (K, s, n), drifting (n,), scale (K, n)
    """
    points = np.ascontiguousarray(points)
    periods = np.zeros(len(points), np.int64)
    bounds = match * (scales(points, drifting) if scale is None else scale)
    engine.nonsmooth_primitive_periods(
        array_pointer("double", points), array_pointer("uint8_t", np.asarray(drifting, bool)),
        array_pointer("double", np.ascontiguousarray(bounds)), array_pointer("int64_t", periods),
    )  # fmt: skip
    return periods
