"""A single lane, called many times in a row with little around the call."""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.lanes import run_lanes
from nonsmooth.engine.layout import Segment, Tables
from nonsmooth.engine.records import Anchor, Records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import Tangent
from nonsmooth.simulation.runner import Derivatives

__all__ = ["OneLane"]

_SHARED = ("sample_number", "sample_phase")  # of Records, by all lanes


class OneLane:
    """One lane with its records, put into the form that the kernel takes once for all calls."""

    def __init__(
        self,
        derivatives: Derivatives,
        anchor: Anchor,
        segment: Segment,
        tangent: Tangent,
        records: Records,
        tolerance: float,
    ) -> None:
        arrays = {k: v if k in _SHARED else v[None] for k, v in records._asdict().items()}
        self._modes, self._statuses = np.empty(1, np.int64), np.empty(1, np.int64)
        self._tolerance = tolerance
        single = Anchor(
            anchor.place[None], anchor.phase[None], anchor.state[None], anchor.order[None]
        )
        self._before = (
            derivatives.rates, derivatives.scratch, single,
            segment, tangent._replace(columns=tangent.columns[None], samples=tangent.samples[None]),
            Records(**arrays), self._modes, 0, 1,
        )  # fmt: skip

    def run(self, tables: Tables, mode: int, number: int, phase: float) -> Status:
        """Run to an instant, ``mode`` and status being those of `run_lane`."""
        self._modes[0] = mode
        run_lanes(tables, *self._before, number, phase, self._statuses, self._tolerance)
        return Status(int(self._statuses[0]))
