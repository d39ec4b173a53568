"""Two windows of strobes in a row, and what a motion does within them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.statistics.periodicity import nearest_return, scales
from nonsmooth.engine.record import Rows
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.impacts import happened, impacts_of
from nonsmooth.runs.words import word_of_modes
from nonsmooth.system.system import System

__all__ = ["Windows", "cyclic_word"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Windows:
    """Strobes of two windows of equal length, the last of one being the first of the other.

    K = 2 record + 1 strobes, n states.
    """

    points: Floats  # (K, n)
    modes: Integers  # (K,)
    numbers: Integers  # (K,): window of the clock, and phase in it
    phases: Floats  # (K,)
    rows: Rows  # events, as in `Records`
    event_phases: Floats
    clock: float  # length of a window of the clock

    @property
    def record(self) -> int:
        """Strobe intervals of each window."""
        return (len(self.points) - 1) // 2

    @property
    def end(self) -> Instant:
        """Instant of the last strobe."""
        return Instant(int(self.numbers[-1]), float(self.phases[-1]))

    def returns(
        self, drifting: npt.NDArray[np.bool_], sizes: Floats, match: float
    ) -> tuple[tuple[int, float], tuple[int, float]]:
        """Period and residual of each window.

        ``sizes`` are those of the states since the start: what has died away to ``match`` times
        ``match`` of them is at rest.
        """
        rounding = 4.0 * _EPSILON / match * np.abs(self.points).max(axis=0)
        floor = np.where(drifting, rounding, match * sizes)
        found = []
        for points in (self.points[: self.record + 1], self.points[self.record :]):
            scale = np.maximum(scales(points, drifting), floor)
            found.append(nearest_return(points, drifting, scale, match))
        return found[0], found[1]

    def word(self, system: System, first: int, last: int) -> str:
        """Modes between two strobes, in order."""
        within = self._between(first, last)
        entered = [int(self.modes[first]), *self.rows["to_mode"][within]]
        return word_of_modes(system, np.array(entered))

    def counts(self, system: System, first: int, last: int) -> tuple[int, int]:
        """Events between two strobes, and the impacts among them."""
        within = self._between(first, last)
        return int(np.count_nonzero(within)), impacts_of(system).count(self.rows[within])

    def _between(self, first: int, last: int) -> npt.NDArray[np.bool_]:
        # an event at the instant of a strobe comes behind it: it has not changed its state
        return happened(self.rows) & (self._since(first) >= 0.0) & (self._since(last) < 0.0)

    def _since(self, k: int) -> Floats:
        """Time of every event since a strobe."""
        whole = (self.rows["number"] - self.numbers[k]) * self.clock
        return np.asarray(whole + (self.event_phases - self.phases[k]))


def cyclic_word(word: str) -> tuple[str, ...]:
    """Modes of a period that begins anywhere: the first of its rotations in alphabetical order.

    A strobe may lie on an event, or be moved across one by a parameter; the motion is the same.
    """
    modes = tuple(word.split())
    if len(modes) > 1 and modes[0] == modes[-1]:
        modes = modes[:-1]
    return min((modes[k:] + modes[:k] for k in range(len(modes))), default=modes)
