"""Derivatives of motions over the strobe intervals that follow a strobe."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.neighbours import OrbitTangent, orbit_map
from nonsmooth.analysis.settle import Group
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.runner import Derivatives, build_derivatives
from nonsmooth.runs.sweep_runner import Times
from nonsmooth.runs.tangent_flow import TangentFlow

__all__ = ["IntervalTangents", "Strobe"]

_ELSEWHERE = (0.0, 0.382, 0.764)  # parts of a period at which derivatives may begin

Floats = npt.NDArray[np.float64]


class Strobe(NamedTuple):
    """A point of a motion from where derivatives are taken."""

    state: Floats
    mode: int
    instant: Instant


class IntervalTangents:
    """Derivatives of the motions of a group, and what they need."""

    def __init__(self, group: Group) -> None:
        self._group, self._drifting = group, group.drifting
        self._known: dict[int, tuple[Tables, Derivatives]] = {}
        self._flow: TangentFlow | None = None

    def tables_of(self, i: int) -> tuple[Tables, Derivatives]:
        """Tables of a motion, and what derivatives by its initial state need."""
        if i not in self._known:
            group = self._group
            values = dict(zip(group.system.parameters, group.values[i].tolist(), strict=True))
            tables = group.runner.tables(i)
            self._known[i] = tables, build_derivatives(group.system, tables, (), values)
        return self._known[i]

    def over_part(self, i: int, strobe: Strobe, part: float) -> Floats | None:
        """Derivatives over a part of the interval after a strobe of motion i, but for drifts.

        None where they are not known.
        """
        return orbit_map(self._orbit(i, *strobe, part), self._drifting)

    def over_period(self, i: int, strobe: Strobe, p: int) -> tuple[OrbitTangent, Floats] | None:
        """Derivatives over p intervals, and the point at which they begin; None if not known.

        At the last strobe, or elsewhere within two intervals: a strobe may lie on a guard. The
        motion is carried on to there, where it may end.
        """
        state, mode, end = strobe
        for part in _ELSEWHERE:
            begin = self._after(i, end, 1.0 + part) if part else end
            if part:
                state, mode = self._state_at(i, begin)
                if int(self._group.motions.statuses[i]) != Status.COMPLETED:
                    return None
            orbit = self._orbit(i, state, mode, begin, p)
            block = orbit_map(orbit, self._drifting)
            if block is not None:
                return orbit, block
        return None

    def _orbit(
        self, i: int, state: Floats, mode: int, begin: Instant, intervals: float
    ) -> OrbitTangent:
        tolerance = self._group.runner.tolerance
        if self._flow is None:
            self._flow = TangentFlow(*self.tables_of(i), self._drifting.size, tolerance)
        return OrbitTangent(
            *self.tables_of(i), tolerance, state, mode, begin, self._after(i, begin, intervals),
            self._flow,
        )  # fmt: skip

    def _state_at(self, i: int, instant: Instant) -> tuple[Floats, int]:
        """State and mode of a motion that runs on to an instant."""
        count = self._group.count
        times = Times(np.full((count, 1), instant.number), np.full((count, 1), instant.phase))
        found = self._group.run(times, chosen=np.arange(count) == i, log=False)
        return found.states[i, 0], int(found.modes[i, 0])

    def _after(self, i: int, begin: Instant, intervals: float) -> Instant:
        """Instant some strobe intervals later; of whole periods without rounding."""
        group = self._group
        if group.periods[i] is None and intervals == int(intervals):
            return Instant(begin.number + int(intervals), begin.phase)
        window = float(group.windows[i])
        number, phase = instants([begin.phase + intervals * group.length(i)], window)
        return Instant(begin.number + int(number[0]), float(phase[0]))
