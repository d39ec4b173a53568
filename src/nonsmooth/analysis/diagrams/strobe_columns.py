"""Columns of a diagram of strobes: what is seen of motions that were recorded side by side."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.columns import DiagramProtocol, Look, nothing
from nonsmooth.analysis.diagrams.strobe_periods import strobe_periods
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.periodicity import whole_periods
from nonsmooth.engine.status import Status
from nonsmooth.runs.impacts import rows_passing
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.sweep_runner import Recorded

__all__ = ["strobe_looks"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def strobe_looks(protocol: DiagramProtocol, group: Group, recorded: Recorded) -> list[Look]:
    """A look for each motion of a group.

    Motions that show no period are run on and looked at again, as long as the protocol says.
    """
    transient = protocol.transient
    looks = _Judged(protocol, group, recorded, transient).looks()
    while transient := protocol.next_transient(transient):
        going = np.array([one.status == Status.COMPLETED and one.period == 0 for one in looks])
        if not np.any(going):
            break
        times = group.iterates(transient, protocol.record + 1)
        later = _Judged(protocol, group, group.run(times, chosen=going), transient).looks()
        looks = [new if goes else one for new, goes, one in zip(later, going, looks, strict=True)]
    return looks


class _Judged:
    """What is seen of motions that were recorded together."""

    def __init__(
        self, protocol: DiagramProtocol, group: Group, recorded: Recorded, transient: int
    ) -> None:
        self._protocol, self._group, self._recorded = protocol, group, recorded
        self._transient = transient
        self._done = recorded.statuses == Status.COMPLETED
        self._passed = PassedEvents(protocol.system, recorded)
        self._period = strobe_periods(group, recorded, self._passed, protocol.match)

    def looks(self) -> list[Look]:
        """A look for each motion."""
        recorded, period, motions = self._recorded, self._period, self._group.motions
        count = whole_periods(self._protocol.record, period)
        first = -1 - count
        each = np.arange(period.size)
        drift = (recorded.travelled[:, -1] - recorded.travelled[each, first]) / count[:, None]
        lasts = (recorded.numbers[:, -1] - recorded.numbers[each, first]) * recorded.windows
        lasts += recorded.phases[:, -1] - recorded.phases[each, first]
        events, impacts = (
            each / count for each in self._passed.counts(self._passed.between(first))
        )
        begins = -1 - period
        taken = self._taken()
        words = self._passed.words(begins, self._passed.between(begins), period > 0)
        return [
            Look(
                Status.COMPLETED, *taken[k], int(period[k]), words[k],
                float(events[k]), float(impacts[k]), drift[k],
                int(motions.uncertain[k]), int(motions.estimated[k]), float(lasts[k] / count[k]),
                self._transient,
            )
            if self._done[k]
            else nothing(
                Status(int(recorded.statuses[k])), drift.shape[1], float(recorded.windows[k])
            )
            for k in each
        ]  # fmt: skip

    def _taken(self) -> list[tuple[Floats, Integers, Floats, Integers]]:
        """Points of each motion, with outputs as further columns; windows, phases and modes."""
        counts, points, numbers, phases, modes = (
            self._strobes() if self._protocol.exits is None else self._events(self._protocol.exits)
        )
        if self._protocol.outputs:
            parameter = self._protocol.parameter
            parameters = {parameter: np.repeat(self._group.values_of(parameter), counts)}
            windows = np.repeat(self._recorded.windows, counts)
            clock = SweptClock(numbers, phases, windows, parameters)
            found = output_values(self._protocol.system, clock, points.T, modes)
            points = np.column_stack([points, *found.values()])
        ends = np.cumsum(counts).tolist()
        return [
            (points[a:b], numbers[a:b], phases[a:b], modes[a:b]) for a, b in pairwise([0, *ends])
        ]

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
        chosen = rows_passing(self._protocol.system, rows, exits)
        chosen &= self._done[self._passed.motion]
        return (
            np.bincount(self._passed.motion[chosen], minlength=self._done.size),
            self._recorded.event_states[chosen, 1 if after else 0],
            rows["number"][chosen],
            rows["phase"][chosen],
            rows["to_mode" if after else "from_mode"][chosen],
        )
