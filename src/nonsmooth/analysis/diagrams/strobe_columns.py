"""Columns of a diagram of strobes: what is seen of motions that were recorded side by side."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.columns import DiagramProtocol, Look, nothing
from nonsmooth.analysis.exponents.interval_tangents import IntervalTangents, Strobe
from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.periodicity import settled_periods, whole_periods
from nonsmooth.analysis.statistics.rest import comes_to_rest, natural_sizes
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.runs.strobe_times import is_driven
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
        self._period = np.zeros(group.count, np.int64)
        self._period[self._done] = settled_periods(
            recorded.states[self._done], protocol.drifting, protocol.match
        )
        self._period[self._resting()] = 1

    def _resting(self) -> Bools:
        """Which motions have died away, or without forcing come to rest, (K,).

        What decays to zero repeats to no part of its own size, and rounding has other periods.
        """
        recorded, group, match = self._recorded, self._group, self._protocol.match
        still, found = ~self._protocol.drifting, np.zeros(self._period.size, bool)
        open_yet = self._done & (self._period != 1)
        if not np.any(open_yet) or not np.any(still):
            return found
        driven = is_driven(group.runner.tables(0))
        states, tangents = recorded.states[..., still], IntervalTangents(group)
        begun = self._begun()[:, still]
        ranges, largest = np.ptp(states, axis=1), np.abs(states).max(axis=1)
        sizes, left = np.maximum(largest, begun), largest if driven else ranges
        first = np.full(open_yet.size, -recorded.states.shape[1])
        events, _ = self._passed.counts(self._passed.between(first))
        # states that began with a size say whether it may be so, their rates afterwards
        faded = np.any(begun > 0.0, axis=1) & np.all(
            (left <= match**2 * sizes) | (begun == 0.0), axis=1
        )
        maybe = faded | (np.any(ranges <= match * sizes, axis=1) & (not driven))
        for i in np.flatnonzero(open_yet & maybe).tolist():
            instant = Instant(int(recorded.numbers[i, -1]), float(recorded.phases[i, -1]))
            strobe = Strobe(recorded.states[i, -1], int(recorded.modes[i, -1]), instant)
            block_over = partial(tangents.over_part, i, strobe)
            natural = natural_sizes(sizes[i], block_over)
            found[i] = faded[i] and bool(np.all(left[i] <= match**2 * natural))
            if not driven and not found[i]:
                found[i] = comes_to_rest(
                    states[i], ranges[i], natural, block_over(1.0), match, passes=events[i] > 0
                )
        return found

    def _begun(self) -> Floats:
        """Sizes of the states at the start of each motion, (K, n)."""
        n = self._recorded.states.shape[2]
        states = [np.zeros(n) if each is None else each.state for each in self._group.starts]
        return np.nan_to_num(np.abs(np.array(states)))  # a state that is left out begins at rest

    def looks(self) -> list[Look]:
        """A look for each motion."""
        recorded, period, motions = self._recorded, self._period, self._group.motions
        count = whole_periods(self._protocol.record, period)
        first = -1 - count
        each = np.arange(period.size)
        drift = (recorded.states[:, -1] - recorded.states[each, first]) / count[:, None]
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
        chosen = (rows["exit"] >= 0) & exits[rows["from_mode"], rows["exit"]]
        chosen &= self._done[self._passed.motion]
        return (
            np.bincount(self._passed.motion[chosen], minlength=self._done.size),
            self._recorded.event_states[chosen, 1 if after else 0],
            rows["number"][chosen],
            rows["phase"][chosen],
            rows["to_mode" if after else "from_mode"][chosen],
        )
