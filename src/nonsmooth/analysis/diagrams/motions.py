"""Motions at several values of a parameter, set up and run by the engine some at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.diagrams.column_starts import Column, ColumnStarts, Start
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner, SweepStarts, Times

__all__ = ["Motions", "Recording", "end_of"]

_BEGIN = Instant(0, 0.0)


class Recording(NamedTuple):
    """Which points of a motion are recorded, counted in iterates of the map."""

    transient: int  # left out
    intervals: int  # between the points that are recorded


class Motions:
    """Motions at several values of a parameter, one after the other.

    ``start`` gives the initial state and the mode for a value. A motion that is to ``follow``
    begins where the last one has ended, with drifting states at their initial value. After a
    value at which the motion ended early, or that the system refuses, it begins anew.
    """

    def __init__(
        self,
        chosen: StroboscopicMap,
        parameter: str,
        runner: SweepRunner,
        start: Start,
        recording: Recording,
        *,
        follow: bool,
    ) -> None:
        self._chosen, self._parameter, self._runner = chosen, parameter, runner
        self._start, self._recording, self._follow = start, recording, follow
        system = chosen.system
        self._own = list(system.parameter_values.values())
        self._drifting = np.array([name in system.drift_states for name in system.states])

    def run(
        self, values: list[float], stop: threading.Event, behind: End | None
    ) -> Iterator[Recorded]:
        """Run a motion at each value; REFUSED where the system refuses the value.

        They come some at a time. The first one follows what has ended ``behind`` it.
        """
        runner = self._runner
        runner.set_up(np.array([self._own]))
        columns = ColumnStarts(self._chosen, self._parameter, values, runner.tables(0), self._start)
        for first in range(0, len(values), runner.most):
            numbers = range(first, min(first + runner.most, len(values)))
            group = [_column(columns, i) for i in numbers]
            recorded = self._run_group(group, behind, stop)
            behind = end_of(recorded)
            yield recorded

    def _run_group(
        self, group: list[Column | None], behind: End | None, stop: threading.Event
    ) -> Recorded:
        """Run motions that have tables side by side."""
        rows = [self._own if each is None else list(each.values.values()) for each in group]
        usable = self._runner.set_up(np.array(rows))
        usable &= np.array([each is not None for each in group])
        first, times = self._times(group)
        starts = self._starts(group, usable)
        follows = first if self._follow else None
        if follows and behind is not None:
            starts.states[0] = np.where(self._drifting, starts.states[0], behind.state)
            starts.modes[0] = SAME - behind.mode
            starts.numbers[0], starts.phases[0] = first.numbers[0, 0], first.phases[0, 0]
        return self._runner.run(starts, times, usable, follows=follows, stop=stop)

    def _starts(self, group: list[Column | None], usable: npt.NDArray[np.bool_]) -> SweepStarts:
        """Where motions begin that do not follow."""
        count = len(group)
        starts = SweepStarts(
            np.zeros((count, self._drifting.size)), np.zeros(count, np.int64),
            np.zeros(count, np.int64), np.zeros(count),
        )  # fmt: skip
        for i, column in enumerate(group):
            if column is None or not usable[i]:
                continue
            start = column.start
            found = start(self._runner.tables(i)) if callable(start) else start
            starts.states[i], starts.modes[i] = found
        return starts

    def _times(self, group: Sequence[Column | None]) -> tuple[Times, Times]:
        """First strobes, where motions go on that follow, and the strobes that are recorded."""
        every, phase = self._chosen.every, self._chosen.phase
        behind = self._recording.transient * every
        count = self._recording.intervals * every + 1

        def some(first: int, count: int) -> Times:
            found = [
                strobes(window, _BEGIN, each.length if each else None, phase, first, count)
                for each, window in zip(group, self._runner.windows.tolist(), strict=True)
            ]
            numbers, phases = (np.stack(each)[:, ::every] for each in zip(*found, strict=True))
            return Times(np.ascontiguousarray(numbers), np.ascontiguousarray(phases))

        return some(0, 1), some(behind, count)


def end_of(recorded: Recorded) -> End | None:
    """Where the last one of some motions has ended; None where it ended early."""
    if recorded.statuses[-1] != Status.COMPLETED:
        return None
    return End(recorded.end_states[-1], int(recorded.places["mode"][-1]))


def _column(columns: ColumnStarts, i: int) -> Column | None:
    try:
        return columns.column(i)
    except ModelError:
        return None
