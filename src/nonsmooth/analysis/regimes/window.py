"""Two windows of strobes in a row, and what motions that go side by side do within them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.periodicity import nearest_returns, scales
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.sweep_runner import Recorded, Times

__all__ = ["Windows", "cyclic_word", "window_times"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_EPSILON = float(np.finfo(float).eps)
# parts of the last strobe interval at which motions are looked at once more: the states there tell
# how large they are, and whether they rest
_BETWEEN = np.array([0.25, 0.5, 0.75])
_OTHERS = np.arange(-1 - _BETWEEN.size, -1)  # places of those looks


def window_times(group: Group, record: int, first: int | Integers, chosen: Bools) -> Times:
    """Strobes of two windows of the chosen motions after so many ones, with the looks between."""
    numbers, phases = group.strobes(first, 2 * record + 1, chosen)
    more, inside = np.zeros((2, group.count, _BETWEEN.size))
    for i in np.flatnonzero(chosen).tolist():
        since = phases[i, -2] + _BETWEEN * group.length(i)
        more[i], inside[i] = instants(since, float(group.windows[i]))
    between = numbers[:, -2:-1] + more.astype(np.int64)
    return Times(
        np.concatenate([numbers[:, :-1], between, numbers[:, -1:]], axis=1),
        np.concatenate([phases[:, :-1], inside, phases[:, -1:]], axis=1),
    )


@dataclass(frozen=True)
class Windows:
    """Strobes of two windows of equal length, the last of one being the first of the other.

    M motions, K = 2 record + 1 strobes, n states.
    """

    points: Floats  # (M, K, n)
    modes: Integers  # (M, K)
    numbers: Integers  # (M, K): window of the clock, and phase in it
    phases: Floats  # (M, K)
    between: Floats  # (M, 3, n): states between the last two strobes
    modes_between: Integers  # (M, 3)
    events: PassedEvents

    @staticmethod
    def of(group: Group, recorded: Recorded) -> Windows:
        """Windows of motions that were recorded at the times of `window_times`."""
        kept = {
            name: np.delete(getattr(recorded, name), _OTHERS, axis=1)
            for name in ("states", "modes", "numbers", "phases")
        }
        return Windows(
            kept["states"], kept["modes"], kept["numbers"], kept["phases"],
            recorded.states[:, _OTHERS], recorded.modes[:, _OTHERS],
            PassedEvents(group.system, recorded._replace(**kept)),
        )  # fmt: skip

    @property
    def record(self) -> int:
        """Strobe intervals of each window."""
        return (self.points.shape[1] - 1) // 2

    def end(self, i: int) -> Instant:
        """Instant of the last strobe of motion i."""
        return Instant(int(self.numbers[i, -1]), float(self.phases[i, -1]))

    def returns(
        self, motions: Integers, drifting: Bools, sizes: Floats, match: float
    ) -> tuple[Integers, Floats]:
        """Period and residual of both windows of some motions, (m, 2) each.

        ``sizes``, (m, n), are those of the states since the start: what has died away to ``match``
        times ``match`` of them is at rest.
        """
        points, record = self.points[motions], self.record
        rounding = 4.0 * _EPSILON / match * np.abs(points).max(axis=1)
        floor = np.where(drifting, rounding, match * sizes)
        both = np.stack([points[:, : record + 1], points[:, record:]], axis=1)
        scale = np.maximum(scales(both, drifting), floor[:, None])
        flat = both.reshape(-1, *both.shape[2:])
        scales_of_all = scale.reshape(len(flat), -1)
        periods, residuals = nearest_returns(flat, drifting, scales_of_all, match)
        return periods.reshape(-1, 2), residuals.reshape(-1, 2)


def cyclic_word(word: str) -> tuple[str, ...]:
    """Modes of a period that begins anywhere: the first of its rotations in alphabetical order.

    A strobe may lie on an event, or be moved across one by a parameter; the motion is the same.
    """
    modes = tuple(word.split())
    if len(modes) > 1 and modes[0] == modes[-1]:
        modes = modes[:-1]
    return min((modes[k:] + modes[:k] for k in range(len(modes))), default=modes)
