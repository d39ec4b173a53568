"""Derivatives of motions over the strobe intervals that follow a strobe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.neighbours import Neighbours, orbit_maps
from nonsmooth.analysis.settle import Group
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import instants
from nonsmooth.runs.sweep_runner import SweepStarts, Times

__all__ = ["IntervalTangents", "PeriodMaps"]

_ELSEWHERE = (0.0, 0.382, 0.764)  # parts of a period at which derivatives may begin

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class PeriodMaps(NamedTuple):
    """Derivatives of K motions over a period of each; k states that do not drift."""

    known: Bools  # (K,)
    blocks: Floats  # (K, k, k)
    starts: SweepStarts  # the points at which they begin
    ends: Times  # (K, 1)


class IntervalTangents:
    """Derivatives of the motions of a group."""

    def __init__(self, group: Group) -> None:
        self._group = group
        # whether an interval is a window of the clock, so that whole ones need no rounding
        self._in_windows = np.array([period is None for period in group.periods])

    def over_part(self, strobes: SweepStarts, part: float, chosen: Bools) -> tuple[Bools, Floats]:
        """Derivatives over a part of the interval after a strobe, but for drifts; where known.

        shapes: chosen (K,); returns (K,) and (K, k, k)
        """
        known, blocks = self.over_parts(strobes, [part], chosen)
        return known[:, 0], blocks[:, 0]

    def over_parts(
        self, strobes: SweepStarts, parts: Sequence[float], chosen: Bools
    ) -> tuple[Bools, Floats]:
        """The same over several parts of it, P ever longer ones, in one call of the engine.

        shapes: chosen (K,); returns (K, P) and (K, P, k, k)
        """
        ends = [self._after(strobes, np.full(self._group.count, part)) for part in parts]
        times = Times(*(np.concatenate(each, axis=1) for each in zip(*ends, strict=True)))
        return orbit_maps(self.neighbours(strobes, times, chosen))

    def over_periods(self, chosen: Bools, strobes: SweepStarts, periods: Integers) -> PeriodMaps:
        """Derivatives of the chosen motions over so many intervals, (K,) each.

        At the last strobe, or elsewhere within two intervals: a strobe may lie on a guard. The
        motion is carried on to there, where it may end.
        """
        group, count = self._group, int(np.count_nonzero(~self._group.drifting))
        found, blocks = np.zeros(group.count, bool), np.zeros((group.count, count, count))
        starts, ends = strobes, self._after(strobes, periods)
        for part in _ELSEWHERE:
            begins = self._run_on(chosen & ~found, strobes, 1.0 + part) if part else strobes
            left = chosen & ~found & (group.motions.statuses == Status.COMPLETED)
            if not np.any(left):
                break
            until = self._after(begins, periods)
            (known,), (own,) = (
                each.swapaxes(0, 1) for each in orbit_maps(self.neighbours(begins, until, left))
            )
            found, blocks[known] = found | known, own[known]
            starts, ends = starts.replaced(known, begins), ends.replaced(known, until)
        return PeriodMaps(found, blocks, starts, ends)

    def neighbours(self, starts: SweepStarts, times: Times, chosen: Bools) -> Neighbours:
        """Neighbours of the chosen motions from some points on."""
        group = self._group
        return Neighbours(group.runner, starts, chosen, times, group.drifting, group.stop)

    def _run_on(self, chosen: Bools, strobes: SweepStarts, intervals: float) -> SweepStarts:
        """Points of motions that run on for so many intervals behind a strobe."""
        times = self._after(strobes, np.full(self._group.count, intervals))
        return self._group.run(times, chosen=chosen, log=False).last

    def _after(self, begins: SweepStarts, intervals: Floats | Integers) -> Times:
        """Instants some strobe intervals later, (K, 1); of whole periods without rounding."""
        numbers, phases = begins.numbers, begins.phases
        whole = self._in_windows & (intervals == np.floor(intervals))
        group = self._group
        exact = whole | ~group.usable  # also what was refused and has no window
        since = np.where(exact, 0.0, phases + intervals * group.lengths)
        number, phase = instants(since, np.where(exact, 1.0, group.windows))
        numbers = numbers + np.where(whole, intervals.astype(np.int64), number)
        return Times(numbers[:, None], np.where(whole, phases, phase)[:, None])
