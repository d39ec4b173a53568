"""A settled motion at one value of a parameter, which may be looked at as often as is needed."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.impacts import happened
from nonsmooth.runs.lane_runner import LaneRunner, Lanes
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.runs.stroboscopic_map import StroboscopicMap

__all__ = ["Events", "Samples", "Settled", "settle"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ONE = np.zeros(1, np.int64)


class Samples(NamedTuple):
    """States, which may be on either side of an event, with window, phase and mode of each."""

    states: Floats  # (K, n)
    numbers: Integers
    phases: Floats
    modes: Integers


class Events(NamedTuple):
    """Events of a recorded motion, tangencies left out."""

    since: Floats  # time since the record began
    before: Samples
    after: Samples


@dataclass
class Settled:
    """A motion after its transient; ``begin`` and ``end`` are those of its record."""

    runner: LaneRunner
    chosen: StroboscopicMap
    parameter: str
    value: float
    begin: Instant
    end: Instant
    period: float
    lanes: Lanes
    events: Events = field(init=False)
    status: Status = field(init=False)

    @property
    def duration(self) -> float:
        """Time from the beginning of the record to its end."""
        window = self.runner.window
        return (self.end.number - self.begin.number) * window + (self.end.phase - self.begin.phase)

    def instants(self, since: Floats) -> tuple[Integers, Floats]:
        """Windows and phases of times since the beginning of the record."""
        numbers, phases = instants(self.begin.phase + since, self.runner.window)
        return numbers + self.begin.number, phases

    def samples(self, since: Floats) -> Samples:
        """States at times since the beginning of the record, in order."""
        numbers, phases = self.instants(since)
        lanes = self.lanes.select(_ONE)
        end = Instant(int(numbers[-1]), float(phases[-1]))
        states, modes = self.runner.run(lanes, end, numbers, phases)
        return Samples(states[0], numbers, phases, modes[0])

    def values(self, name: str, samples: Samples) -> Floats:
        """Values of a state or an output."""
        system = self.chosen.system
        if name in system.states:
            return samples.states[:, system.states.index(name)]
        count = samples.numbers.size
        clock = SweptClock(
            samples.numbers, samples.phases, np.full(count, self.runner.window),
            {self.parameter: np.full(count, self.value)} if self.parameter else {},
        )  # fmt: skip
        return output_values(system, clock, samples.states.T, samples.modes)[name]

    def pass_record(self, lanes: Lanes) -> None:
        """Run the motion itself to the end of the record, with the event log."""
        ends = np.array([self.begin, self.end])
        numbers, phases = ends[:, 0].astype(np.int64), ends[:, 1].copy()
        _, _, rows, states = self.runner.record(lanes, 0, numbers, phases)
        self.status = Status(int(lanes.status[0]))
        # a run that goes on has no row for its start
        kept = happened(rows)
        rows, states = rows[kept], states[kept]
        number, phase = rows["number"].copy(), rows["phase"].copy()
        since = (number - self.begin.number) * self.runner.window + (phase - self.begin.phase)
        self.events = Events(
            since,
            Samples(states[:, 0], number, phase, rows["from_mode"].copy()),
            Samples(states[:, 1], number, phase, rows["to_mode"].copy()),
        )


def settle(
    runner: LaneRunner,
    chosen: StroboscopicMap,
    parameter: str,
    value: float,
    lanes: Lanes,
    begin: Instant,
    length: float | None,
    transient: int,
    record: int,
    stop: threading.Event,
) -> Settled | Status:
    """Let a motion settle and pass its record; the status where it ended before."""
    numbers, phases = strobes(
        runner.window, begin, length, chosen.phase, transient * chosen.every,
        record * chosen.every + 1,
    )  # fmt: skip
    first, last = (Instant(int(numbers[k]), float(phases[k])) for k in (0, -1))
    if first != begin:
        runner.run(lanes, first, np.zeros(0, np.int64), np.zeros(0), stop)
    if lanes.status[0] != Status.COMPLETED:
        return Status(int(lanes.status[0]))
    period = (runner.window if length is None else length) * chosen.every
    settled = Settled(
        runner, chosen, parameter, value, first, last, period, lanes.select(_ONE)
    )  # fmt: skip
    settled.pass_record(lanes)
    return settled if settled.status == Status.COMPLETED else settled.status
