"""Short runs with derivatives, many with the same parameters: the segments of a record.

Segments begin at different times and have different samples, so each is a lane of its own; the
tables and their derivatives by parameters are set up once for all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    ANY,
    Tangent,
    allocate_anchor,
    allocate_columns,
    allocate_records,
    allocate_segment,
    run,
)
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.fitting.observation import MotionSamples
from nonsmooth.runs.clock import instants
from nonsmooth.runs.runner import build_derivatives, build_tables
from nonsmooth.system.model.value_checks import sure_values
from nonsmooth.system.system import System

__all__ = ["Flight", "Flights"]

Floats = npt.NDArray[np.float64]


class Flight(NamedTuple):
    """States at the samples of a run, and their derivatives by start and parameters."""

    samples: MotionSamples  # K of them
    columns: Floats  # (K, n, n + p)


class Flights:
    """Runs of a system at the values of the last `set_up`."""

    def __init__(self, system: System, chosen: Sequence[str], tolerance: float) -> None:
        self.system, self.chosen, self.tolerance = system, tuple(chosen), tolerance
        self.n = len(system.states)
        self.n_runs = 0
        self.values: dict[str, float] = {}

    def set_up(self, changed: dict[str, float]) -> bool:
        """Take values of the chosen parameters; whether the system admits them."""
        values = self.system.parameter_values | changed
        if values == self.values:
            return True
        self.values = {}
        grids = {name: np.array([value]) for name, value in changed.items()}
        try:
            if not sure_values(self.system, grids)[0]:
                self.system.with_parameters(**changed)
            self.tables = build_tables(self.system, values)
            self._derivatives = build_derivatives(self.system, self.tables, self.chosen, values)
        except ModelError:
            return False
        self._segment = allocate_segment(self.tables.sizes, len(self.chosen))
        self._scratch: Tangent | None = None
        self.values = values
        return True

    @property
    def window(self) -> float:
        """Length of a window: the period, where there is one."""
        return self.tables.window

    def fly(self, state: Floats, begin: float, times: Floats) -> Flight | None:
        """Run through some times, not decreasing; None where the run ends early."""
        sizes, p = self.tables.sizes, len(self.chosen)
        numbers, phases = instants(np.append(begin, times), self.window)
        records = allocate_records(sizes, numbers[1:], phases[1:], 0)
        if self._scratch is None:
            self._scratch = allocate_columns(sizes, self.n + p, 1)
        tangent = self._scratch.replace(samples=np.full((times.size, self.n + p, self.n), np.nan))
        tangent.columns[:], tangent.ready[:] = 0.0, 0
        anchor = allocate_anchor(sizes)
        anchor.move_to((int(numbers[0]), float(phases[0])))
        anchor.state[:] = state
        carried = self._derivatives
        lane = (self.tables, carried.rates, carried.scratch, anchor, self._segment, tangent)
        end = int(numbers[-1]), float(phases[-1])
        status = run(lane, records, ANY, end, self.tolerance)
        self.n_runs += 1
        if status != Status.COMPLETED or not np.isfinite(tangent.samples).all():
            return None
        samples = MotionSamples(numbers[1:], phases[1:], records.sample_mode, records.sample_state)
        return Flight(samples, tangent.samples.transpose(0, 2, 1))
