"""Settled motions, each of which may be looked at as often as is needed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.strobe_periods import strobe_periods
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.impacts import happened
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.sweep_runner import Motions, Recorded, Times

__all__ = ["Events", "Samples", "SweptMotion", "reduce_settled"]

Arrays = dict[str, npt.NDArray[Any]]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MATCH = 1e-6  # part of the size of a state to which strobes repeat, as a diagram has it


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


class SweptMotion:
    """Motion ``i`` of a group after its transient, recorded from one strobe to another one.

    ``begun`` are the motions of the group where their records begin.
    """

    def __init__(
        self, group: Group, begun: Motions, i: int, begin: Instant, end: Instant, recorded: Recorded
    ) -> None:
        self._group, self._begun, self._i = group, begun, i
        self.begin, self.end = begin, end
        self.window = float(group.windows[i])
        self.period = group.length(i) * group.chosen.every
        log = slice(*recorded.logs[i : i + 2].tolist())
        rows, states = recorded.rows[log], recorded.event_states[log]
        kept = happened(rows)
        rows, states = rows[kept], states[kept]
        number, phase = rows["number"].copy(), rows["phase"].copy()
        since = (number - begin.number) * self.window + (phase - begin.phase)
        self.events = Events(
            since,
            Samples(states[:, 0], number, phase, rows["from_mode"].copy()),
            Samples(states[:, 1], number, phase, rows["to_mode"].copy()),
        )

    @property
    def duration(self) -> float:
        """Time from the beginning of the record to its end."""
        begin, end = self.begin, self.end
        return (end.number - begin.number) * self.window + (end.phase - begin.phase)

    def instants(self, since: Floats) -> tuple[Integers, Floats]:
        """Windows and phases of times since the beginning of the record."""
        numbers, phases = instants(self.begin.phase + since, self.window)
        return numbers + self.begin.number, phases

    def samples(self, since: Floats) -> Samples:
        """States at times since the beginning of the record, in order."""
        numbers, phases = self.instants(since)
        i = self._i
        found = self._group.runner.run(
            self._begun.select(np.array([i])), Times(numbers[None], phases[None]), log=False,
            sets=slice(i, i + 1), stop=self._group.stop,
        )  # fmt: skip
        return Samples(found.states[0], numbers, phases, found.modes[0])

    def values(self, name: str, samples: Samples) -> Floats:
        """Values of a state or an output."""
        system, group = self._group.system, self._group
        if name in system.states:
            return samples.states[:, system.states.index(name)]
        count = samples.numbers.size
        varied = {each: group.values_of(each)[self._i] for each in group.varied}
        clock = SweptClock(
            samples.numbers, samples.phases, np.full(count, self.window),
            {each: np.full(count, value) for each, value in varied.items()},
        )  # fmt: skip
        return output_values(system, clock, samples.states.T, samples.modes)[name]


def reduce_settled(
    reduce: Callable[[SweptMotion], Arrays],
    transient: int,
    record: int,
    group: Group,
    _: Recorded,
) -> list[Arrays]:
    """What ``reduce`` makes of each motion of a group that is run on through its record.

    There is its ``status`` too, and its ``motion_period``, 0 where its strobes show none.
    Nothing but the status is there where a motion has ended early.
    """
    begun = group.motions.select(np.arange(group.count))
    times = group.iterates(transient, record + 1)
    passed = group.run(times)
    periods = strobe_periods(group, passed, PassedEvents(group.system, passed), _MATCH)
    found: list[Arrays] = []
    for i, status in enumerate(passed.statuses.tolist()):
        found.append({"status": np.array(status)})
        if status == Status.COMPLETED:
            begin, end = (
                Instant(int(times.numbers[i, k]), float(times.phases[i, k])) for k in (0, -1)
            )
            settled = SweptMotion(group, begun, i, begin, end, passed)
            found[-1] |= {"motion_period": np.array(periods[i])} | reduce(settled)
    return found
