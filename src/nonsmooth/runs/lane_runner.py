"""Many runs of one system from many starts: arrays in, arrays out.

What `simulate` does for one run with all its records, this does for lanes with few of them:
states at given times, and the event log of one lane at a time. One runner belongs to one thread.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.device import DeviceLanes
from nonsmooth.engine.lanes import (
    ANY,
    GOES_ON,
    Anchor,
    Tangent,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    lane_anchors,
    lane_records,
    lane_tangents,
    run_lanes,
)
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.devices import device_for
from nonsmooth.runs.event_log import EventLog
from nonsmooth.runs.runner import advance, build_tables
from nonsmooth.system.system import System

__all__ = ["LaneRunner", "Lanes"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ALL = slice(None)
_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_FIRST_EVENTS = 256  # rows of an event log to begin with
_TOGETHER = 4096  # windows in one call of a kernel, over all its lanes
_ON_DEVICE = 2**27  # the same of a graphics device, some seconds of work
# lanes, of which fewer run faster on the processor: a thread of a device takes hundreds of times as
# long for a window
_LEAST_ON_DEVICE = 2048


class Lanes(NamedTuple):
    """Lanes on their way; L lanes, n states."""

    anchors: Anchor  # with the number of lanes in front
    status: Integers  # (L,)
    end_state: Floats  # (L, n)
    mode: Integers  # (L,): how each goes on, see `run_lane`
    uncertain: Integers  # (L,): events that rounding leaves open
    estimated: Integers  # (L,): steps the errors of which are estimated
    since: Rows  # (L,): window and phase up to which these are counted

    def select(self, chosen: Integers) -> Lanes:
        """Copy of some of the lanes."""
        return Lanes(
            self.anchors.part(chosen), self.status[chosen], self.end_state[chosen],
            self.mode[chosen], self.uncertain[chosen], self.estimated[chosen],
            self.since[chosen],
        )  # fmt: skip


class LaneRunner:
    """Runs lanes of a system; parameters are those of the last `set_up`."""

    def __init__(self, system: System, tolerance: float) -> None:
        self.system = system
        self.tolerance = tolerance
        self.tables = build_tables(system)
        self._device = device_for(system)
        self._on_device: DeviceLanes | None = None
        self.sizes = self.tables.sizes
        self.rates, self.scratch = no_rates(), no_scratch()
        self.segment = allocate_segment(self.sizes)
        self.tangent = allocate_tangent(self.sizes, -1, 0)

    @property
    def window(self) -> float:
        """Length of a window: the period, where there is one."""
        return self.tables.window

    def set_up(self, values: dict[str, float]) -> None:
        """Take other values of the parameters; `ModelError` where they make no sense."""
        self.tables, self._on_device = build_tables(self.system, values), None

    def start(self, states: Floats, begin: Instant, modes: Integers | int = ANY) -> Lanes:
        """Lanes that begin at some states.

        shapes: states (L, n), modes (L,)
        """
        count = len(states)
        anchors = lane_anchors(self.sizes, begin.number, begin.phase, states)
        return Lanes(
            anchors,
            status=np.full(count, int(Status.COMPLETED)),
            end_state=np.array(states, dtype=float),
            mode=np.broadcast_to(np.asarray(modes, np.int64), count).copy(),
            uncertain=np.zeros(count, np.int64),
            estimated=np.zeros(count, np.int64),
            since=lane_records(self.sizes, *_NO_TIMES, 0, count).since,
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
        windows = max(1, end.number - int(lanes.anchors.place["number"].min(initial=end.number)))
        on_device = self._device is not None and alive.size >= _LEAST_ON_DEVICE
        size = max(1, (_ON_DEVICE if on_device else _TOGETHER) // windows)
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
        anchors = lanes.anchors.part(chosen)
        records = lane_records(self.sizes, numbers, phases, 0, count)
        records.since[:] = lanes.since[chosen]
        tangent = self._tangents(count)
        how, statuses = lanes.mode[chosen], np.empty(count, np.int64)
        stack, passed = self.tables.as_lanes, np.zeros(2, np.int64)
        device = self._lanes_on_device(count)
        first = 0
        while first < count:
            if stop is not None and stop.is_set():
                raise Stopped
            if device is not None:
                device.run(anchors, records, how, end, statuses, self.tolerance)
                break
            first = run_lanes(
                stack, self.rates, self.scratch, anchors, self.segment, tangent, records,
                how, first, count, end.number, end.phase, passed, statuses, self.tolerance,
            )  # fmt: skip
        lanes.anchors.put(chosen, anchors)
        lanes.status[chosen], lanes.mode[chosen] = statuses, GOES_ON
        lanes.end_state[chosen] = records.end_state
        lanes.uncertain[chosen] += records.counters["uncertain"]
        lanes.estimated[chosen] += records.counters["estimated"]
        lanes.since[chosen] = records.since
        return records.sample_state, records.sample_mode

    def _lanes_on_device(self, count: int) -> DeviceLanes | None:
        """What runs so many lanes on a device, None where the processor does."""
        if self._device is None or count < _LEAST_ON_DEVICE:
            return None
        if self._on_device is None:
            self._on_device = DeviceLanes(self._device, self.tables)
        return self._on_device

    def record(
        self, lanes: Lanes, i: int, numbers: Integers, phases: Floats
    ) -> tuple[Floats, Integers, Rows, Floats]:
        """Run lane i to the last of some times, with its event log.

        Returns the states and modes at the times, as far as it has come, the rows of the log and
        the states before and after each event.
        """
        anchor = lanes.anchors.part(i)
        records = allocate_records(self.sizes, numbers, phases, _FIRST_EVENTS)
        records.since[()] = lanes.since[i]
        log = EventLog(keep=True)
        lane = (self.tables, self.rates, self.scratch, anchor, self.segment, self.tangent)
        end = Instant(int(numbers[-1]), float(phases[-1]))
        status, records = advance(
            lane, end, records, log, self.tolerance, lambda _: None, mode=int(lanes.mode[i])
        )
        lanes.status[i], lanes.mode[i] = status, GOES_ON
        lanes.end_state[i] = records.end_state
        lanes.uncertain[i] += records.counters["uncertain"]
        lanes.estimated[i] += records.counters["estimated"]
        lanes.since[i] = records.since
        count = int(records.counters["samples"])
        return records.sample_state[:count], records.sample_mode[:count], *log.rows(records)

    def _tangents(self, count: int) -> Tangent:
        """No columns for any lane."""
        return lane_tangents(self.tangent, count)
