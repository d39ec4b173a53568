"""Samples and end of a run whose periods are known only when they begin."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import Instant, check_one_end
from nonsmooth.runs.history import Frozen
from nonsmooth.runs.options import check_count, finite_number, time_grid, whole_number

__all__ = ["SlowPlan", "plan_slow_run"]

_UNIT = float(np.finfo(float).eps)
_SAME = 1e-9  # of the distance of samples: equal up to rounding

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class PlanPart(NamedTuple):
    """Samples in one period, and its end where the run ends in it."""

    number: Integers
    phase: Array
    end: Instant | None


@dataclass
class SlowPlan:
    """Samples and end, period by period.

    A sample at the end of a period belongs to it: it is the state before parameters change.
    """

    start: Instant
    begins: float  # time at the start
    share: float  # of its period that had passed at the start
    per_period: int
    periods: float | None = None  # after which the run ends
    t_end: float = math.inf  # at which it ends
    grid: Array | None = None  # times of the samples, instead of parts of a period
    taken: int = field(default=0)

    @property
    def total(self) -> float:
        """Amount of work for a bar of progress."""
        return self.periods or self.t_end - self.begins

    def done(self, period: Frozen) -> float:
        """Part of the work that is done when a period begins."""
        if self.periods is not None:
            return period.number - self.start.number
        return period.origin - self.begins

    def part(self, period: Frozen, window: float) -> PlanPart:
        """Samples of a period, and the end if it lies in it."""
        end = self._end(period, window)
        if self.grid is None:
            phase = self._parts(period.number - self.start.number, window)
        else:
            phase = self._times(period, window)
        last = window if end is None or end.number > period.number else end.phase
        same = _SAME * window / self.per_period
        if self.grid is None:
            phase = phase[phase <= last + same]
        self.taken += phase.size
        number, phase = _wrapped(period.number, phase, window)
        meets = end is not None and phase.size > 0 and number[-1] == end.number
        if meets and end is not None and abs(phase[-1] - end.phase) <= same:
            end = Instant(end.number, float(phase[-1]))
        return PlanPart(number, phase, end)

    def whole(self, first: int, origins: Array, window: float) -> int:
        """Number of periods, of some in a row from number ``first`` on, before that of the end."""
        if self.periods is not None:
            left = self.start.number - first + self.share + self.periods - np.arange(origins.size)
            return int(np.count_nonzero(left > 1.0 + 1e-12))
        slack = 4.0 * _UNIT * abs(self.t_end)
        return int(np.count_nonzero(self.t_end - origins > window + slack))

    def parts(self, first: int, origins: Array, window: float) -> PlanPart:
        """Samples of whole periods in a row, none of them that of the start or of the end."""
        numbers, phases = first + np.arange(origins.size, dtype=np.int64), np.empty(0)
        if self.grid is None:
            phase = self._parts(1, window)
            numbers, phases = np.repeat(numbers, phase.size), np.tile(phase, origins.size)
            self.taken += phases.size
        else:
            cuts = []
            for number, origin in zip(numbers, origins, strict=True):
                cuts.append(self._times(Frozen(int(number), float(origin), {}), window))
                self.taken += cuts[-1].size
            numbers = np.repeat(numbers, [cut.size for cut in cuts])
            phases = np.concatenate(cuts)
        return PlanPart(*_wrapped(numbers, phases, window), None)

    def _end(self, period: Frozen, window: float) -> Instant | None:
        if self.periods is not None:
            left = self.start.number - period.number + self.share + self.periods
            if left > 1.0 + 1e-12:
                return None
            phase = left * window if left < 1.0 - 1e-12 else window
        else:
            slack = 4.0 * _UNIT * abs(self.t_end)
            phase = self.t_end - period.origin
            if phase > window + slack:
                return None
            phase = window if phase >= window - slack else phase
        if phase == window:
            return Instant(period.number + 1, 0.0)
        return Instant(period.number, max(0.0, phase))

    def _parts(self, j: int, window: float) -> Array:
        """Phases of the samples at equal parts of period j since the start."""
        n = self.per_period
        if j < 0:  # the run goes on from the end of this period
            return np.array([window])
        first = math.floor(-self.share * n + _SAME) + 1 if j > 0 or self.taken else 0
        last = math.floor((1.0 - self.share) * n + _SAME)
        phase = self.share * window + np.arange(first, last + 1) * (window / n)
        if j == 0:
            phase = np.maximum(phase, self.start.phase)
        return np.where(phase >= window * (1.0 - 4.0 * _UNIT), window, phase)

    def _times(self, period: Frozen, window: float) -> Array:
        assert self.grid is not None
        slack = 4.0 * _UNIT * (abs(period.origin) + window)
        last = int(np.searchsorted(self.grid, period.origin + window + slack, side="right"))
        phase = self.grid[self.taken : last] - period.origin
        low = self.start.phase if period.number == self.start.number else 0.0
        return np.where(phase >= window - slack, window, np.maximum(phase, low))


def _wrapped(number: int | Integers, phase: Array, window: float) -> tuple[Integers, Array]:
    """Samples by number and phase: those at the end of a period begin the next one."""
    boundary = phase >= window * (1.0 - 4.0 * _UNIT)
    return number + np.asarray(boundary, np.int64), np.where(boundary, 0.0, phase)


def plan_slow_run(
    start: Instant,
    period: Frozen,
    window: float,
    *,
    periods: float | None,
    t_end: float | None,
    times: npt.ArrayLike | None,
    samples_per_period: int,
    sample_bytes: int = 0,
) -> SlowPlan:
    """Plan of a run from an instant of a period, or from its end."""
    begins = period.origin + (window if start.number > period.number else start.phase)
    per_period = whole_number("samples_per_period", samples_per_period)
    share = start.phase / window if start.number == period.number else 0.0
    plan = SlowPlan(start, begins, share, per_period)
    check_one_end(periods=periods, t_end=t_end, times=times)
    if periods is not None:
        if not finite_number("periods", periods) > 0:
            raise OptionError(f"periods = {periods} must be positive")
        check_count(np.floor(periods * per_period + _SAME), sample_bytes)
        plan.periods = float(periods)
    elif times is not None:
        plan.grid = time_grid(times)
        if plan.grid[0] < begins - 4.0 * _UNIT * abs(begins):
            raise OptionError(
                f"times[0] = {plan.grid[0]:g} lies before the start, t = {begins:g}; runs go"
                " forward only"
            )
        plan.t_end = float(plan.grid[-1])
    else:
        if not finite_number("t_end", t_end) > begins:
            raise OptionError(f"t_end = {t_end} must be later than the start, t = {begins:g}")
        assert t_end is not None
        check_count(np.floor((t_end - begins) / window * per_period), sample_bytes)
        plan.t_end = float(t_end)
    return plan
