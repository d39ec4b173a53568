"""Many runs of one system from many starts: arrays in, arrays out.

What `simulate` does for one run with all its records, this does for lanes with few of them:
states at given times, and the event log of one lane at a time. One runner belongs to one thread.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.lanes import run_lanes
from nonsmooth.engine.layout import allocate_segment, stack_of_one
from nonsmooth.engine.loop import ANY, GOES_ON
from nonsmooth.engine.records import Anchor, Records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import Tangent, allocate_tangent
from nonsmooth.engine.variation_tables import no_columns, no_rates
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.crew import Stopped
from nonsmooth.simulation.event_log import EventLog
from nonsmooth.simulation.runner import advance, build_tables
from nonsmooth.system.system import System

__all__ = ["LaneRunner", "Lanes"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ALL = slice(None)
_FIRST_EVENTS = 256  # rows of an event log to begin with
_TOGETHER = 4096  # windows in one call of a kernel, over all its lanes


class Lanes(NamedTuple):
    """Lanes on their way; L lanes, n states."""

    anchors: Anchor  # with the number of lanes in front
    status: Integers  # (L,)
    end_state: Floats  # (L, n)
    mode: Integers  # (L,): how each goes on, see `run_lane`
    uncertain: Integers  # (L,): events that rounding leaves open
    since: Floats  # (L, 2): window and phase up to which these are counted

    def select(self, chosen: Integers) -> Lanes:
        """Copy of some of the lanes."""
        return Lanes(
            _of_lane(self.anchors, chosen), self.status[chosen], self.end_state[chosen],
            self.mode[chosen], self.uncertain[chosen], self.since[chosen],
        )  # fmt: skip


class LaneRunner:
    """Runs lanes of a system; parameters are those of the last `set_up`."""

    def __init__(self, system: System, tolerance: float) -> None:
        self.system = system
        self.tolerance = tolerance
        self.tables = build_tables(system)
        self.sizes = self.tables.sizes
        self.rates, self.scratch = no_rates(), no_columns()
        self.segment = allocate_segment(self.sizes)
        self.tangent = allocate_tangent(self.sizes, -1, 0)

    @property
    def window(self) -> float:
        """Length of a window: the period, where there is one."""
        return float(self.tables.clock[0])

    def set_up(self, values: dict[str, float]) -> None:
        """Take other values of the parameters; `ModelError` where they make no sense."""
        self.tables = build_tables(self.system, values)

    def start(self, states: Floats, begin: Instant, modes: Integers | int = ANY) -> Lanes:
        """Lanes that begin at some states.

        shapes: states (L, n), modes (L,)
        """
        count, _n = states.shape
        place = np.zeros((count, 2), np.int64)
        place[:, 0] = begin.number
        anchors = Anchor(
            place,
            np.full((count, 1), begin.phase),
            np.array(states, dtype=float),
            np.zeros((count, int(self.sizes[5])), np.int64),
        )
        return Lanes(
            anchors,
            status=np.full(count, int(Status.COMPLETED)),
            end_state=np.array(states, dtype=float),
            mode=np.broadcast_to(np.asarray(modes, np.int64), count).copy(),
            uncertain=np.zeros(count, np.int64),
            since=np.full((count, 2), -np.inf),
        )

    def run(
        self,
        lanes: Lanes,
        end: Instant,
        numbers: Integers,
        phases: Floats,
        stop: threading.Event | None = None,
    ) -> tuple[Floats, Integers]:
        """Run all lanes that can go on to an instant; their states and modes at some times.

        shapes: numbers, phases (K,) in order of time; returns (L, K, n) and (L, K), nan and -1
        where a lane has ended before
        """
        count, n = lanes.end_state.shape
        alive = np.flatnonzero(lanes.status == Status.COMPLETED)
        if count == alive.size == 1:  # as in a diagram: nothing to pick and to put together
            return self._run_some(lanes, _ALL, 1, end, numbers, phases, stop)
        states = np.full((count, numbers.size, n), np.nan)
        modes = np.full((count, numbers.size), -1, np.int64)
        windows = max(1, end.number - int(lanes.anchors.place[:, 0].min(initial=end.number)))
        size = max(1, _TOGETHER // windows)
        for first in range(0, alive.size, size):
            chosen = alive[first : first + size]
            states[chosen], modes[chosen] = self._run_some(
                lanes, chosen, chosen.size, end, numbers, phases, stop
            )
        return states, modes

    def _run_some(
        self,
        lanes: Lanes,
        chosen: Integers | slice,
        count: int,
        end: Instant,
        numbers: Integers,
        phases: Floats,
        stop: threading.Event | None,
    ) -> tuple[Floats, Integers]:
        """Run the chosen lanes, so many of them; their states and modes at the times."""
        anchors = _of_lane(lanes.anchors, chosen)
        records = self._records(count, numbers, phases)
        records.since[:] = lanes.since[chosen]
        tangent = self._tangents(count)
        how, statuses = lanes.mode[chosen], np.empty(count, np.int64)
        stack, passed = stack_of_one(self.tables), np.zeros(2, np.int64)
        first = 0
        while first < count:
            if stop is not None and stop.is_set():
                raise Stopped
            first = run_lanes(
                stack, self.rates, self.scratch, anchors, self.segment, tangent, records,
                how, first, count, end.number, end.phase, passed, statuses, self.tolerance,
            )  # fmt: skip
            if first < count:
                how[first] = GOES_ON
        for part, whole in zip(anchors, lanes.anchors, strict=True):
            whole[chosen] = part
        lanes.status[chosen], lanes.mode[chosen] = statuses, GOES_ON
        lanes.end_state[chosen] = records.end_state
        lanes.uncertain[chosen] += records.cursor[:, at.UNCERTAIN]
        lanes.since[chosen] = records.since
        return records.sample_state, records.sample_mode

    def record(
        self, lanes: Lanes, i: int, numbers: Integers, phases: Floats
    ) -> tuple[Floats, Integers, Integers, Floats]:
        """Run lane i to the last of some times, with its event log.

        Returns the states and modes at the times, as far as it has come, and the rows of the log
        as in `Records`.
        """
        anchor = _of_lane(lanes.anchors, i)
        whole = self._records(1, numbers, phases, _FIRST_EVENTS)
        records = Records(*whole[:2], *(part[0] for part in whole[2:]))
        records.since[:] = lanes.since[i]
        log = EventLog(keep=True)
        lane = (self.tables, self.rates, self.scratch, anchor, self.segment, self.tangent)
        end = Instant(int(numbers[-1]), float(phases[-1]))
        status, records = advance(
            lane, end, records, log, self.tolerance, lambda _: None, mode=int(lanes.mode[i])
        )
        lanes.status[i], lanes.mode[i] = status, GOES_ON
        lanes.end_state[i] = records.end_state
        lanes.uncertain[i] += records.cursor[at.UNCERTAIN]
        lanes.since[i] = records.since
        count = int(records.cursor[at.SAMPLES])
        return records.sample_state[:count], records.sample_mode[:count], *log.rows(records)

    def _records(self, count: int, numbers: Integers, phases: Floats, events: int = 0) -> Records:
        n, samples = int(self.sizes[0]), numbers.size
        return Records(
            sample_number=numbers,
            sample_phase=phases,
            sample_state=np.full((count, samples, n), np.nan),
            sample_mode=np.full((count, samples), -1, np.int64),
            event_integers=np.empty((count, events, at.EVENT_INTEGERS), np.int64),
            event_floats=np.empty((count, events, at.EVENT_FLOATS + 2 * n)),
            cursor=np.zeros((count, at.CURSOR), np.int64),
            end_state=np.full((count, n), np.nan),
            since=np.full((count, 2), -np.inf),
        )

    def _tangents(self, count: int) -> Tangent:
        """No columns for any lane."""
        columns = np.zeros((count, *self.tangent.columns.shape))
        samples = np.zeros((count, *self.tangent.samples.shape))
        return self.tangent._replace(columns=columns, samples=samples)


def _of_lane(anchors: Anchor, i: int | Integers | slice) -> Anchor:
    """Anchor of one lane, or a copy of those of some lanes; a slice gives no copy."""
    return Anchor(anchors.place[i], anchors.phase[i], anchors.state[i], anchors.order[i])
