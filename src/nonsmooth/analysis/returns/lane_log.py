"""Many motions at once with their event logs, each from an instant of its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import Starts
from nonsmooth.engine import records as at
from nonsmooth.engine.lanes import run_lanes
from nonsmooth.engine.layout import stack_of_one
from nonsmooth.engine.loop import GOES_ON
from nonsmooth.engine.records import Anchor, Records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import Tangent, allocate_columns
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.lane_runner import LaneRunner
from nonsmooth.simulation.runner import NO_DERIVATIVES, Derivatives

__all__ = ["LaneLog", "Settled", "settle"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROOM = 64  # rows of the log of a lane in one call of the kernel
_ROUNDING = 1e-9  # of states that are put on a relation
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
        return some_anchors(self.anchors, i)


def some_anchors(anchors: Anchor, chosen: int | slice | Integers) -> Anchor:
    """Copy of one anchor or of several."""
    return Anchor(
        anchors.place[chosen].copy(), anchors.phase[chosen].copy(), anchors.state[chosen].copy(),
        anchors.order[chosen].copy(),
    )  # fmt: skip


def settle(
    engine: LaneRunner, starts: Starts, tolerance: float, derivatives: Derivatives = NO_DERIVATIVES
) -> Settled:
    """Begin at all starts, each in the first of its modes that fits."""
    count, n = starts.states.shape
    order = np.zeros((count, int(engine.sizes[5])), np.int64)
    place = np.column_stack([starts.number, np.zeros(count, np.int64)])
    anchors = Anchor(place, starts.phase[:, None].copy(), starts.states.copy(), order)
    status = np.full(count, int(Status.INADMISSIBLE))
    passed, jumped = np.zeros(count, bool), np.zeros(count, bool)
    many = allocate_columns(engine.sizes, 0 if derivatives.chosen is None else n, 1)
    columns = np.zeros((count, *many.columns.shape))
    for choice in starts.modes.T:
        left = np.flatnonzero(status == Status.INADMISSIBLE)
        if not left.size:
            break
        some = some_anchors(anchors, left)
        some.state[:] = starts.states[left]
        records = _records(left.size, n, _AT_START)
        tangent = _of_lanes(many, left.size)
        found = _call(
            engine, some, records, choice[left].copy(), Instant(0, 0.0), tolerance, tangent,
            derivatives,
        )  # fmt: skip
        for part, whole in zip(some, anchors, strict=True):
            whole[left] = part
        columns[left] = tangent.columns
        status[left] = np.where(found == Status.BUFFER_FULL, int(Status.COMPLETED), found)
        began = records.cursor[:, at.EVENTS] > 0
        # a lane that began and is inadmissible afterwards is so in any case
        passed[left] = began & (records.event_integers[:, 0, at.PASSES] > 0)
        given = starts.states[left]
        apart = np.abs(some.state - given) > _ROUNDING * (1.0 + np.abs(given))
        jumped[left] = passed[left] & np.any(apart, axis=1)  # nan, left open, is no jump
    return Settled(anchors, status, passed, jumped, columns)


class LaneLog:
    """Lanes that run on together; the log of all since the beginning."""

    def __init__(self, engine: LaneRunner, settled: Settled, tolerance: float) -> None:
        self.engine, self.tolerance = engine, tolerance
        self.anchors = some_anchors(settled.anchors, slice(None))
        self.status = settled.status.copy()
        self.ends = np.full((self.status.size, int(engine.sizes[0])), np.nan)
        self._since = np.full((self.status.size, 2), -np.inf)
        self._cursor = np.zeros((self.status.size, at.CURSOR), np.int64)
        self._lanes: list[Integers] = []
        self._rows: list[Integers] = []
        self._values: list[Floats] = []

    def run(self, chosen: Integers, end: Instant) -> Integers:
        """Run some lanes on, to an instant or until their logs are full, and give those that are.

        ``ends`` and ``status`` are those at the instant.
        """
        some = some_anchors(self.anchors, chosen)
        n = some.state.shape[1]
        records = _records(chosen.size, n, _ROOM)
        records.since[:], records.cursor[:] = self._since[chosen], self._cursor[chosen]
        records.cursor[:, [at.SAMPLES, at.EVENTS, at.SEGMENTS]] = 0
        modes = np.full(chosen.size, GOES_ON)
        tangent = _of_lanes(allocate_columns(self.engine.sizes, 0, 1), chosen.size)
        found = _call(self.engine, some, records, modes, end, self.tolerance, tangent)
        for part, whole in zip(some, self.anchors, strict=True):
            whole[chosen] = part
        self._since[chosen], self.ends[chosen] = records.since, records.end_state
        self._cursor[chosen] = records.cursor
        written = np.arange(_ROOM) < records.cursor[:, at.EVENTS, None]
        self._lanes.append(chosen[np.nonzero(written)[0]])
        self._rows.append(records.event_integers[written])
        self._values.append(records.event_floats[written])
        full = found == Status.BUFFER_FULL
        self.status[chosen] = np.where(full, int(Status.COMPLETED), found)
        return chosen[full]

    def rows(self) -> tuple[Integers, Integers, Floats]:
        """Numbers of the lanes, rows and values of the log, lane by lane in order of time."""
        n = self.ends.shape[1]
        lanes = np.concatenate([np.zeros(0, np.int64), *self._lanes])
        rows = np.concatenate([np.zeros((0, at.EVENT_INTEGERS), np.int64), *self._rows])
        values = np.concatenate([np.zeros((0, at.EVENT_FLOATS + 2 * n)), *self._values])
        order = np.argsort(lanes, kind="stable")
        self._lanes, self._rows, self._values = [lanes[order]], [rows[order]], [values[order]]
        return self._lanes[0], self._rows[0], self._values[0]


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
            stack_of_one(engine.tables), derivatives.rates, derivatives.scratch, anchors,
            engine.segment, tangent, records, modes, first, count, *end, passed, statuses,
            tolerance,
        )  # fmt: skip
        if first < count:
            modes[first] = GOES_ON
    return statuses


def _records(count: int, n: int, room: int) -> Records:
    """Logs of some lanes, without samples."""
    return Records(
        sample_number=np.zeros(0, np.int64),
        sample_phase=np.zeros(0),
        sample_state=np.empty((count, 0, n)),
        sample_mode=np.empty((count, 0), np.int64),
        event_integers=np.zeros((count, room, at.EVENT_INTEGERS), np.int64),
        event_floats=np.empty((count, room, at.EVENT_FLOATS + 2 * n)),
        cursor=np.zeros((count, at.CURSOR), np.int64),
        end_state=np.full((count, n), np.nan),
        since=np.full((count, 2), -np.inf),
    )


def _of_lanes(tangent: Tangent, count: int) -> Tangent:
    """Columns of so many lanes."""
    return tangent._replace(
        columns=np.zeros((count, *tangent.columns.shape)),
        samples=np.zeros((count, *tangent.samples.shape)),
    )
