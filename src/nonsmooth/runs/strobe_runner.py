"""Iterates of a strobe map from many starts at once: arrays in, arrays out."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.lane_runner import LaneRunner, Lanes
from nonsmooth.runs.runner import Derivatives, NoMode, build_derivatives, run_plan
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.runs.words import rebounds_of, word_of_modes
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
        self.system, self.tolerance = system, tolerance
        self._runner = LaneRunner(system, tolerance)
        self._phase, self._period, self._every = phase, period, every
        self._derivatives: Derivatives | None = None  # made when first asked for

    def start(self, states: Floats, modes: Integers | int = ANY) -> StrobeLanes:
        """Lanes that begin at points of the section.

        shapes: states (L, n), modes (L,)
        """
        return StrobeLanes(self._runner.start(states, self.begin, modes), 0)

    @property
    def begin(self) -> Instant:
        """Instant at which lanes begin."""
        return self._instants(0, 1)[0]

    def instant_of(self, iterate: int) -> Instant:
        """Instant of an iterate; the start is iterate 0."""
        return self._instants(iterate, 1)[0]

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

    def last(
        self, lanes: StrobeLanes, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """Apply the map some times and give the last images alone, with their modes.

        returns: states (L, n), modes (L,)
        """
        last = self._instants(lanes.done + count, 1)[0]
        numbers, phases = np.array([last.number], np.int64), np.array([last.phase])
        states, modes = self._runner.run(lanes.lanes, last, numbers, phases, stop)
        lanes.done += count
        return states[:, 0], modes[:, 0]

    def along(self, states: Floats, count: int) -> Floats:
        """States of motions at some times, spread evenly over the first application of the map.

        nan where a motion has ended, or no mode takes its start; states (L, n)

        returns: (L, count, n)
        """
        window, (begin, end) = self._runner.window, self._instants(0, 2)
        length = (end.number - begin.number) * window + end.phase - begin.phase
        times = begin.phase + length * np.arange(1, count + 1) / (count + 1)
        numbers = np.floor(times / window).astype(np.int64)
        phases, numbers = times - numbers * window, numbers + begin.number
        lanes = self._runner.start(states, begin)
        last = Instant(int(numbers[-1]), float(phases[-1]))
        return self._runner.run(lanes, last, numbers, phases)[0]

    def admits(self, states: Floats) -> npt.NDArray[np.bool_]:
        """Which states are starts that a mode takes; states (L, n)."""
        lanes = self.start(states)
        self.last(lanes, 1)
        return np.asarray(lanes.status != Status.INADMISSIBLE)

    def images(
        self, state: Floats, mode: int, count: int
    ) -> tuple[Floats, Integers, Floats] | None:
        """Images of one point with their modes, and the derivative of the last one by the point.

        ``mode`` holds at the start where it fits, else the first one that does. None where no mode
        fits or the motion ends before.

        returns: states (count, n), modes (count,), derivative (n, n)
        """
        tables = self._runner.tables
        if self._derivatives is None:
            self._derivatives = build_derivatives(self.system, tables, ())
        instants = self._instants(1, count)
        numbers = np.array([one.number for one in instants], np.int64)
        phases = np.array([one.phase for one in instants])
        begin = self._instants(0, 1)[0]
        for each in (mode, ANY):
            try:
                outcome = run_plan(
                    tables, Plan(instants[-1], numbers, phases), self.tolerance, state=state,
                    begin=begin, mode=each, keep_events=False, derivatives=self._derivatives,
                )  # fmt: skip
            except NoMode:
                continue
            if outcome.unless_interrupted().status != Status.COMPLETED or outcome.columns is None:
                return None
            records = outcome.records
            return records.sample_state, records.sample_mode, outcome.columns[-1].T.copy()
        return None

    def word(self, state: Floats, mode: int, count: int) -> str:
        """Modes that are visited along some applications of the map, from a point in a mode."""
        lanes = self._runner.start(state[None], self._instants(0, 1)[0], np.array([SAME - mode]))
        last = self._instants(count, 1)[0]
        numbers, phases = np.array([last.number], np.int64), np.array([last.phase])
        _, _, rows, _ = self._runner.record(lanes, 0, numbers, phases)
        passed = rows[rows["kind"] != EventKind.GRAZE]
        modes = np.array([mode, *passed["to_mode"]])
        return word_of_modes(self.system, modes, rebounds_of(passed))

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
