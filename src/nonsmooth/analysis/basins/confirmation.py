"""Runs that confirm that motions near a cycle converge to it.

The ball around a point of a cycle is only as sure as the trial starts that have shown it, and a
chaotic motion may pass through some balls in order. So a lane that has come to a cycle is run on
until a motion that converges must have come nearer, and belongs to the cycle if it has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.engine.attractors import Visits

__all__ = ["Cycles", "confirm_visits"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_SHRINKS = 0.01  # by which the slowest direction of a cycle shrinks in a run that confirms
_NEARER = 0.1  # of its distance from a point to which a lane must have come by then
_CLOSE = 1e-5  # beside the scale: cycles that are nearer to each other are one
_MOST = 2000  # iterates of such a run; a cycle that needs more is not confirmed


@dataclass(frozen=True)
class Cycles:
    """Cycles that may be confirmed: their points, and the iterates that this takes."""

    columns: Integers  # states that are compared
    scale: Floats  # of them
    points: dict[int, Floats]  # (p, d) in these units, by the number of the attractor
    iterates: dict[int, int]  # 0 where it would take too many

    @classmethod
    def of(cls, attractors: Sequence[Attractor], measure: Any) -> Cycles:
        """The cycles among some attractors, numbered from 1 on."""
        cycles = {i + 1: one for i, one in enumerate(attractors) if one.is_cycle}
        return cls(
            measure.columns,
            measure.scale[measure.columns],
            {number: measure.scaled(one.points) for number, one in cycles.items()},
            {number: _iterates(one) for number, one in cycles.items()},
        )

    def unconfirmed(self, label: Integers) -> int:
        """How many labels rest on the balls of their cycles alone."""
        return sum(
            int(np.count_nonzero(label == number))
            for number, count in self.iterates.items()
            if count == 0
        )

    def distances(self, states: Floats, number: int) -> Floats:
        """Distances of states from the points of a cycle, (K, p)."""
        scaled = states[:, self.columns] / self.scale
        return np.asarray(np.linalg.norm(scaled[:, None] - self.points[number][None], axis=2))


def confirm_visits(runner: Any, lanes: Any, states: Floats, cycles: Cycles, visits: Visits) -> None:
    """Take back the labels of lanes that do not come nearer to the cycle they were given.

    The lanes themselves stay where they are. shapes: states (L, n), in which they are
    """
    for number, count in cycles.iterates.items():
        arrived = np.flatnonzero(visits.label == number)
        if not count or not arrived.size:
            continue
        distances = cycles.distances(states[arrived], number)
        point = np.argmin(distances, axis=1)[:, None]
        ends, _ = runner.last(lanes.select(arrived), count)  # whole turns later
        before = np.take_along_axis(distances, point, axis=1)[:, 0]
        after = np.take_along_axis(cycles.distances(ends, number), point, axis=1)[:, 0]
        lost = arrived[~(after <= np.maximum(_NEARER * before, _CLOSE))]  # nan: it has ended
        visits.label[lost] = visits.candidate[lost] = visits.score[lost] = visits.needed[lost] = 0
        visits.point[lost] = -1


def _iterates(cycle: Attractor) -> int:
    """Iterates in which motions near a cycle come nearer, 0 where it takes too many."""
    rate = np.abs(cycle.multipliers).max(initial=0.0) if cycle.multipliers is not None else 1.0
    turns = 1 if rate <= _SHRINKS else np.log(_SHRINKS) / np.log(min(rate, 1.0 - 1e-12))
    count = int(np.ceil(turns)) * cycle.period
    return count if count <= _MOST else 0
