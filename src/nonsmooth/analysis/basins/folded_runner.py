"""A map whose images have their angles within one turn, so that attractors recur.

Motions go on as they are; what they are compared by is folded. The circle of an angle is cut open
where no machine has a special place: a motion that comes to rest on the cut would fall on either
side of it by rounding.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.lanes import SAME
from nonsmooth.runs.whole_turns import folded, periods_of_states

__all__ = ["runner_within_turns", "turned", "within_turns"]

_CUT = -0.381966  # of a period, where the circle is cut open

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def runner_within_turns(chosen: Any, tolerance: float, grid: Grid | None = None) -> Any:
    """What applies a map to many starts; angles of its images lie within one turn.

    That begins at the lower end of a ``grid``, so that images fall into its cells.
    """
    runner, periods = chosen.runner(tolerance), periods_of_states(chosen.system)
    if not np.any(periods):
        return runner
    cuts = _CUT * periods
    if grid is not None:
        for name, low in zip(grid.completion.given, grid.lower_ends, strict=True):
            cuts[chosen.system.states.index(name)] = low
    return _FoldedRunner(runner, periods, cuts)


class _FoldedRunner:
    """A runner with folded images; all else it leaves to the runner itself."""

    def __init__(self, runner: Any, periods: Floats, cuts: Floats) -> None:
        self._runner, self._periods, self._cuts = runner, periods, cuts

    def __getattr__(self, name: str) -> Any:
        return getattr(self._runner, name)

    def fold(self, states: Floats) -> Floats:
        """States with their angles within one turn."""
        return folded(states, self._cuts, self._periods)

    def iterate(
        self, lanes: Any, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """All images, (L, count, n), and their modes."""
        states, modes = self._runner.iterate(lanes, count, stop)
        return self.fold(states), modes

    def last(
        self, lanes: Any, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """The last images, (L, n), and their modes."""
        states, modes = self._runner.last(lanes, count, stop)
        return self.fold(states), modes

    def images(
        self, state: Floats, mode: int, count: int
    ) -> tuple[Floats, Integers, Floats] | None:
        """Images of one point, their modes, and the derivative of the last one by the point."""
        found = self._runner.images(state, mode, count)
        if found is None:
            return None
        states, modes, derivative = found
        return self.fold(states), modes, derivative

    def turned(self, state: Floats, mode: int, count: int) -> Floats:
        """How far angles turn along some images of a point, nan where the motion ends."""
        last, _ = self._runner.last(self._runner.start(state[None], np.array([SAME - mode])), count)
        return np.where(self._periods > 0.0, last[0] - state, 0.0)


def turned(runner: Any, state: Floats, mode: int, count: int) -> Floats:
    """How far angles turn along some images of a point, zero of other states, (n,)."""
    if not isinstance(runner, _FoldedRunner):
        return np.zeros(len(state))
    return runner.turned(state, mode, count)


def within_turns(runner: Any, states: Floats) -> Floats:
    """States as the images of a runner are, with their angles within one turn, (..., n)."""
    return runner.fold(states) if isinstance(runner, _FoldedRunner) else states
