"""Columns of a diagram of strobes: motions run and judged some at a time."""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.diagrams.column_starts import Start
from nonsmooth.analysis.diagrams.columns import Look, Protocol, nothing
from nonsmooth.analysis.diagrams.motions import Motions, Recording, end_of
from nonsmooth.analysis.statistics.periodicity import whole_periods
from nonsmooth.engine.status import Status
from nonsmooth.engine.sweeps import primitive_periods
from nonsmooth.runs.impacts import happened, impacts_of
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.sweep_runner import Recorded, SweepRunner
from nonsmooth.runs.words import word_of_modes

__all__ = ["run_strobe_chain"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def run_strobe_chain(
    protocol: Protocol,
    runner: SweepRunner,
    stop: threading.Event,
    values: list[float],
    start: Start,
    follow: bool,
    behind: End | None,
) -> tuple[list[Look], End | None]:
    """Motions at several values of the parameter, see `Motions`; where the last one has ended."""
    motions = Motions(
        protocol.strobed, protocol.parameter, runner, start,
        Recording(protocol.transient, protocol.record), follow=follow,
    )  # fmt: skip
    looks: list[Look] = []
    for recorded in motions.run(values, stop, behind):
        some = values[len(looks) : len(looks) + recorded.statuses.size]
        looks += _Judged(protocol, recorded, np.array(some)).looks()
        behind = end_of(recorded)
    return looks, behind


class _Judged:
    """What is seen of motions that were recorded together."""

    def __init__(self, protocol: Protocol, recorded: Recorded, values: Floats) -> None:
        self._protocol, self._recorded, self._values = protocol, recorded, values
        self._column = np.repeat(np.arange(values.size), np.diff(recorded.logs))  # of each event
        self._happened = happened(recorded.rows)
        self._done = recorded.statuses == Status.COMPLETED
        self._period = np.zeros(values.size, np.int64)
        self._period[self._done] = primitive_periods(
            recorded.states[self._done], protocol.drifting, protocol.match
        )

    def looks(self) -> list[Look]:
        """A look for each motion."""
        recorded, period = self._recorded, self._period
        count = whole_periods(self._protocol.record, period)
        first = -1 - count
        passed = self._passed(first)
        each = np.arange(period.size)
        drift = (recorded.states[:, -1] - recorded.states[each, first]) / count[:, None]
        lasts = (recorded.numbers[:, -1] - recorded.numbers[each, first]) * recorded.windows
        lasts += recorded.phases[:, -1] - recorded.phases[each, first]
        events, impacts = (self._per_column(passed, weights) / count for weights in self._weights())
        taken, words = self._taken(), self._words()
        return [
            Look(
                Status.COMPLETED, *taken[k], int(period[k]), words[k],
                float(events[k]), float(impacts[k]), drift[k],
                int(recorded.uncertain[k]), int(recorded.estimated[k]), float(lasts[k] / count[k]),
            )
            if self._done[k]
            else nothing(
                Status(int(recorded.statuses[k])), drift.shape[1], float(recorded.windows[k])
            )
            for k in each
        ]  # fmt: skip

    def _weights(self) -> tuple[Integers, Integers]:
        """For how many events, and for how many impacts, each row of the logs stands."""
        rows = self._recorded.rows
        return np.ones(rows.size, np.int64), impacts_of(self._protocol.system).in_rows(rows)

    def _per_column(self, rows: Bools, weights: Integers) -> Floats:
        """Sum of the weights of some rows in each column."""
        total = np.bincount(self._column[rows], weights[rows], minlength=self._values.size)
        return np.asarray(total, float)

    def _passed(self, first: Integers) -> Bools:
        """Events from strobe ``first`` of each motion on; one at that instant counts."""
        recorded, column = self._recorded, self._column
        rows, origin = recorded.rows, (column, first[column])
        since = (rows["number"] - recorded.numbers[origin]) * recorded.windows[column]
        since += rows["phase"] - recorded.phases[origin]
        return np.asarray(self._happened & (since >= 0.0))

    def _words(self) -> list[str]:
        """Modes of the last primitive period of each motion, "" where there is none."""
        recorded, system = self._recorded, self._protocol.system
        begins = -1 - self._period
        within = self._passed(begins)
        counts = np.bincount(self._column[within], minlength=self._values.size)
        entered = np.split(recorded.rows["to_mode"][within], np.cumsum(counts)[:-1])
        known: dict[bytes, str] = {}

        def word(k: int) -> str:
            modes = np.append(recorded.modes[k, begins[k]], entered[k])
            key = modes.tobytes()
            if key not in known:
                known[key] = word_of_modes(system, modes)
            return known[key]

        return [word(k) if period else "" for k, period in enumerate(self._period.tolist())]

    def _taken(self) -> list[tuple[Floats, Integers, Floats, Integers]]:
        """Points of each motion, with outputs as further columns; windows, phases and modes."""
        counts, points, numbers, phases, modes = (
            self._strobes() if self._protocol.exits is None else self._events(self._protocol.exits)
        )
        if self._protocol.outputs:
            parameters = {self._protocol.parameter: np.repeat(self._values, counts)}
            windows = np.repeat(self._recorded.windows, counts)
            clock = SweptClock(numbers, phases, windows, parameters)
            found = output_values(self._protocol.system, clock, points.T, modes)
            points = np.column_stack([points, *found.values()])
        ends = np.cumsum(counts)[:-1]
        parts = (np.split(each, ends) for each in (points, numbers, phases, modes))
        return list(zip(*parts, strict=True))

    def _strobes(self) -> tuple[Integers, Floats, Integers, Floats, Integers]:
        """Number of strobes in each column, and all of them.

        The last one closes the recorded time and belongs to the next period.
        """
        recorded, done = self._recorded, self._done
        intervals, n = recorded.states.shape[1] - 1, recorded.states.shape[2]
        return (
            np.where(done, intervals, 0),
            recorded.states[done, :-1].reshape(-1, n),
            recorded.numbers[done, :-1].ravel(),
            recorded.phases[done, :-1].ravel(),
            recorded.modes[done, :-1].ravel(),
        )

    def _events(self, exits: Bools) -> tuple[Integers, Floats, Integers, Floats, Integers]:
        """Number of chosen events in each column, and the states before or behind all of them."""
        rows, after = self._recorded.rows, self._protocol.after
        chosen = (rows["exit"] >= 0) & exits[rows["from_mode"], rows["exit"]]
        chosen &= self._done[self._column]
        return (
            np.bincount(self._column[chosen], minlength=self._values.size),
            self._recorded.event_states[chosen, 1 if after else 0],
            rows["number"][chosen],
            rows["phase"][chosen],
            rows["to_mode" if after else "from_mode"][chosen],
        )
