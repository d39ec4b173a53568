"""Iterates of a strobe map from many starts at once: arrays in, arrays out."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.loop import ANY
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.lane_runner import LaneRunner, Lanes
from nonsmooth.simulation.stroboscopic import strobes
from nonsmooth.system.system import System

__all__ = ["StrobeLanes", "StrobeRunner"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass
class StrobeLanes:
    """Lanes on their way, all after the same number of iterates."""

    lanes: Lanes
    done: int  # iterates so far

    @property
    def status(self) -> Integers:
        """How each lane stands, (L,): `COMPLETED` while it can go on."""
        return self.lanes.status

    def select(self, chosen: Integers) -> StrobeLanes:
        """Copy of some of the lanes, to go on without the others."""
        return replace(self, lanes=self.lanes.select(chosen))


class StrobeRunner:
    """Applies a strobe map; one runner belongs to one thread.

    ``period`` None stands for the system's own period; a point belongs to the given phase of it,
    and the map leads ``every`` periods on.
    """

    def __init__(
        self,
        system: System,
        tolerance: float,
        *,
        phase: float = 0.0,
        period: float | None = None,
        every: int = 1,
    ) -> None:
        self._runner = LaneRunner(system, tolerance)
        self._phase, self._period, self._every = phase, period, every

    def start(self, states: Floats, modes: Integers | int = ANY) -> StrobeLanes:
        """Lanes that begin at points of the section.

        shapes: states (L, n), modes (L,)
        """
        return StrobeLanes(self._runner.start(states, self._instants(0, 1)[0], modes), 0)

    def iterate(
        self, lanes: StrobeLanes, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """Apply the map some times; each image with its mode, nan and -1 once a lane has ended.

        returns: states (L, count, n), modes (L, count)
        """
        instants = self._instants(lanes.done + 1, count)
        numbers = np.array([one.number for one in instants], np.int64)
        phases = np.array([one.phase for one in instants])
        images = self._runner.run(lanes.lanes, instants[-1], numbers, phases, stop)
        lanes.done += count
        return images

    def _instants(self, first: int, count: int) -> list[Instant]:
        """Instants of some iterates; the start is iterate 0."""
        numbers, phases = strobes(
            self._runner.window, Instant(0, 0.0), self._period, self._phase,
            first * self._every, (count - 1) * self._every + 1,
        )  # fmt: skip
        chosen = slice(None, None, self._every)
        return [
            Instant(int(number), float(phase))
            for number, phase in zip(numbers[chosen], phases[chosen], strict=True)
        ]
