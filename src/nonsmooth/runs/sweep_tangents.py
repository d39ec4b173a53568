"""Columns of derivatives along the motions of a sweep, in one call of the engine for all of them.

What `TangentFlow` does for one motion. Columns are rows of arrays here, as in the engine:
``columns[k, c]`` is a vector of n states, of motion k.
"""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.engine.sweeps import Division
from nonsmooth.runs.sweep_runner import SweepRunner, SweepStarts, Times

__all__ = ["SweepTangents"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class SweepTangents:
    """K motions at their starts, what happens there being behind them, with all n columns.

    Those that are not ``chosen``, (K,), are left out. With ``until``, (K, s), they have gone on to
    the last of some times; ``samples``, (K, s, n, n), are the columns at those that they have
    ``reached``, (K, s).
    """

    def __init__(
        self,
        runner: SweepRunner,
        starts: SweepStarts,
        chosen: Bools,
        stop: threading.Event | None = None,
        until: Times | None = None,
    ) -> None:
        self._runner, self._stop = runner, stop
        self._motions = runner.start(starts, chosen)
        count, n = starts.states.shape
        begin = Times(starts.numbers[:, None].copy(), starts.phases[:, None].copy())
        self.samples, _ = self.run(until or begin, np.tile(np.eye(n), (count, 1, 1)))

    def run(
        self,
        times: Times,
        columns: Floats,
        growth: Floats | None = None,
        *,
        division: Division | None = None,
        chosen: Bools | None = None,
    ) -> tuple[Floats, Floats]:
        """Run with some columns at the anchors through some times; columns and growth at these.

        Where their ``growth`` up to the anchors is given, the columns stay orthonormal, and it is
        added up. Without it nothing looks after them on the way, but for the ``division`` of one.

        shapes: times (K, s), columns (K, C, n), growth (K, C); returns (K, s, C, n) and (K, s, C)
        """
        lanes = self._runner.columns(columns, times.numbers.shape[1], growth)
        recorded = self._runner.run(
            self._motions, times, chosen=chosen, log=False, columns=lanes, division=division,
            stop=self._stop,
        )  # fmt: skip
        self.reached = recorded.modes >= 0
        self.columns, self.growth = lanes.columns[..., : columns.shape[2]], lanes.growth
        return lanes.samples, lanes.growth_samples

    @property
    def statuses(self) -> Integers:
        """How each motion ended, or COMPLETED, (K,)."""
        return self._motions.statuses

    @property
    def goes_on(self) -> Bools:
        """Which motions have not ended, (K,)."""
        return np.asarray(self.statuses == Status.COMPLETED)

    @property
    def has_mode(self) -> Bools:
        """Which motions could begin, (K,): a start on a guard is of a mode by what came before."""
        return np.asarray(self._motions.places["mode"] >= 0)

    @property
    def anchors(self) -> tuple[Integers, Floats]:
        """Windows and phases of the anchors, (K,) each; ``columns`` and ``growth`` are there."""
        places = self._motions.places
        return places["number"], places["phase"]
