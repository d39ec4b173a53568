"""Many motions at once with their event logs, each from an instant of its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import Starts
from nonsmooth.engine.lanes import (
    GOES_ON,
    Anchor,
    Records,
    Tangent,
    allocate_columns,
    lane_anchors,
    lane_records,
    lane_tangents,
    run_lanes,
)
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.runner import NO_DERIVATIVES, Derivatives

__all__ = ["LaneLog", "Settled", "settle"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROOM = 64  # rows of the log of a lane in one call of the kernel
_ROUNDING = 1e-9  # of states that are put on a relation
_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_AT_START = 2  # rows after which a lane stops that has only begun


class Settled(NamedTuple):
    """Lanes that have begun and not moved yet."""

    anchors: Anchor  # with the number of lanes in front
    status: Integers  # (L,)
    passed: npt.NDArray[np.bool_]  # (L,): an exit was passed at the start
    jumped: npt.NDArray[np.bool_]  # (L,): and changed the states
    columns: Floats  # (L, n, N): of derivatives by the start, no rows where none are carried

    def anchor(self, i: int) -> Anchor:
        """Copy of the anchor of one lane."""
        return self.anchors.part(i).copied()


def settle(
    engine: LaneRunner, starts: Starts, tolerance: float, derivatives: Derivatives = NO_DERIVATIVES
) -> Settled:
    """Begin at all starts, each in the first of its modes that fits."""
    count, n = starts.states.shape
    anchors = lane_anchors(engine.sizes, starts.number, starts.phase, starts.states)
    status = np.full(count, int(Status.INADMISSIBLE))
    passed, jumped = np.zeros(count, bool), np.zeros(count, bool)
    many = allocate_columns(engine.sizes, 0 if derivatives.chosen is None else n, 1)
    columns = np.zeros((count, *many.columns.shape))
    for choice in starts.modes.T:
        left = np.flatnonzero(status == Status.INADMISSIBLE)
        if not left.size:
            break
        some = anchors.part(left)
        some.state[:] = starts.states[left]
        records = lane_records(engine.sizes, *_NO_TIMES, _AT_START, left.size)
        tangent = lane_tangents(many, left.size)
        found = _call(
            engine, some, records, choice[left].copy(), Instant(0, 0.0), tolerance, tangent,
            derivatives,
        )  # fmt: skip
        anchors.put(left, some)
        columns[left] = tangent.columns
        status[left] = np.where(found == Status.BUFFER_FULL, int(Status.COMPLETED), found)
        began = records.counters["events"] > 0
        # a lane that began and is inadmissible afterwards is so in any case
        passed[left] = began & (records.events["passes"][:, 0] > 0)
        given = starts.states[left]
        apart = np.abs(some.state - given) > _ROUNDING * (1.0 + np.abs(given))
        jumped[left] = passed[left] & np.any(apart, axis=1)  # nan, left open, is no jump
    return Settled(anchors, status, passed, jumped, columns)


class LaneLog:
    """Lanes that run on together; the log of all since the beginning."""

    def __init__(self, engine: LaneRunner, settled: Settled, tolerance: float) -> None:
        self.engine, self.tolerance = engine, tolerance
        self.anchors = settled.anchors.copied()
        self.status = settled.status.copy()
        self.ends = np.full((self.status.size, engine.sizes.states), np.nan)
        empty = lane_records(engine.sizes, *_NO_TIMES, 0, self.status.size)
        self._since, self._counters = empty.since, empty.counters
        self._lanes: list[Integers] = [np.zeros(0, np.int64)]
        self._rows: list[Rows] = [empty.events.ravel()]
        self._states: list[Floats] = [empty.event_states.reshape(0, 2, engine.sizes.states)]

    def run(self, chosen: Integers, end: Instant) -> Integers:
        """Run some lanes on, to an instant or until their logs are full, and give those that are.

        ``ends`` and ``status`` are those at the instant.
        """
        some = self.anchors.part(chosen)
        records = lane_records(self.engine.sizes, *_NO_TIMES, _ROOM, chosen.size)
        records.since[:], records.counters[:] = self._since[chosen], self._counters[chosen]
        for name in ("samples", "events", "segments"):
            records.counters[name] = 0
        modes = np.full(chosen.size, GOES_ON)
        tangent = lane_tangents(allocate_columns(self.engine.sizes, 0, 1), chosen.size)
        found = _call(self.engine, some, records, modes, end, self.tolerance, tangent)
        self.anchors.put(chosen, some)
        self._since[chosen], self.ends[chosen] = records.since, records.end_state
        self._counters[chosen] = records.counters
        written = np.arange(_ROOM) < records.counters["events"][:, None]
        self._lanes.append(chosen[np.nonzero(written)[0]])
        self._rows.append(records.events[written])
        self._states.append(records.event_states[written])
        full = found == Status.BUFFER_FULL
        self.status[chosen] = np.where(full, int(Status.COMPLETED), found)
        return chosen[full]

    def rows(self) -> tuple[Integers, Rows, Floats]:
        """Lanes, rows of the log and states around events, lane by lane in order of time."""
        lanes, rows = np.concatenate(self._lanes), np.concatenate(self._rows)
        states, order = np.concatenate(self._states), np.argsort(lanes, kind="stable")
        self._lanes, self._rows, self._states = [lanes[order]], [rows[order]], [states[order]]
        return self._lanes[0], self._rows[0], self._states[0]


def _call(
    engine: LaneRunner,
    anchors: Anchor,
    records: Records,
    modes: Integers,
    end: Instant,
    tolerance: float,
    tangent: Tangent,
    derivatives: Derivatives = NO_DERIVATIVES,
) -> Integers:
    """Run all lanes; their statuses."""
    count = modes.size
    statuses, passed, first = np.empty(count, np.int64), np.zeros(2, np.int64), 0
    while first < count:
        first = run_lanes(
            engine.tables.as_lanes, derivatives.rates, derivatives.scratch, anchors,
            engine.segment, tangent, records, modes, first, count, *end, passed, statuses,
            tolerance,
        )  # fmt: skip
    return statuses
