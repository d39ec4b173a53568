"""A run that carries columns of derivatives, driven in pieces from outside.

A run that ends in the middle of a segment keeps its anchor at the start of that segment, so that
going on repeats the same operations. Columns may be exchanged for other ones at the anchor, since
the flow takes them from there linearly; the trajectory does not depend on them, so it stays that of
a run that was never cut, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    GOES_ON,
    Anchor,
    Lane,
    Records,
    Tangent,
    allocate_anchor,
    allocate_columns,
    allocate_records,
    allocate_segment,
    run,
)
from nonsmooth.engine.record import Rows, dtype_of
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.event_log import FIRST_CAPACITY
from nonsmooth.runs.impacts import Impacts, happened
from nonsmooth.runs.runner import Derivatives, NoMode, last_instant

__all__ = ["Saved", "TangentFlow"]

Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Saved:
    """What a piece starts from, so that it can be done again."""

    anchor: Anchor
    columns: Matrix
    counters: Rows
    since: Rows
    counts: tuple[int, int, int, int]


class TangentFlow:
    """Trajectory of a system with columns of derivatives by its initial state.

    Columns are rows of arrays here, as in the engine: ``columns[c]`` is a vector of n states.
    """

    def __init__(
        self,
        tables: Tables,
        derivatives: Derivatives,
        count: int,
        tolerance: float,
        impacts: Impacts | None = None,
    ):
        self.impacts = impacts  # None: they are not counted
        self.tolerance = tolerance
        self.tables, self.derivatives, self.window = tables, derivatives, tables.window
        self.n = tables.sizes.states
        sizes = tables.sizes
        self.anchor = allocate_anchor(sizes)
        self.segment = allocate_segment(sizes, 0)
        self._tangent = allocate_columns(sizes, count, 1)
        self._whole = allocate_columns(sizes, self.n, 1)  # of all states, at a start
        self.last_event = np.zeros((), dtype_of("EventRow"))
        self.states_at_ends = np.empty((0, self.n))  # of the instants of the last `run_with`
        self._many = allocate_records(sizes, np.zeros(1, np.int64), np.zeros(1), FIRST_CAPACITY)

    @cached_property
    def _one(self) -> Records:
        """A buffer that is full after one event; the other arrays are shared."""
        return self._many.replace(
            events=self._many.events[:2].copy(),
            event_states=self._many.event_states[:2].copy(),
        )

    def start(self, state: Matrix, begin: Instant, mode: int) -> Status:
        """Start at a state; ``columns`` are then derivatives by the initial states, all n.

        `NoMode` where the mode does not fit.
        """
        self._forget()
        whole = self._whole
        whole.columns[:, : self.n] = np.eye(self.n)  # also where parameters are taken as changed
        self.anchor.move_to(begin)
        self.anchor.state[:] = state
        status = self._run(begin, mode, whole, one_event=False)
        if status == Status.INADMISSIBLE and self._many.counters["events"] == 0:
            raise NoMode(self.segment.z.copy())
        self.passed_at_start = bool(self.last_event["passes"] > 0)
        self.n_events = self.n_impacts = 0  # what happens at the start is none
        self.first_columns = whole.columns[:, : self.n].copy()
        return status

    def _forget(self) -> None:
        """Leave nothing of the motion before."""
        for tangent in (self._tangent, self._whole):
            tangent.columns[:], tangent.ready[:] = 0.0, 0
        self.anchor.place[()], self.anchor.order[:] = 0, 0
        self._many.counters[()] = 0
        self._many.since["number"] = self._many.since["phase"] = -np.inf
        self.n_events = self.n_impacts = self.n_uncertain = self.n_estimated = 0
        self.last_event = np.zeros((), dtype_of("EventRow"))

    @property
    def here(self) -> Instant:
        """Instant of the anchor."""
        return Instant(self.anchor.number, self.anchor.phase)

    @property
    def reached(self) -> Instant:
        """Instant that the last piece has come to, also where it ended early."""
        return last_instant(self.anchor, self._many)

    @property
    def mode(self) -> int:
        """Mode that holds at the anchor."""
        return self.anchor.mode

    @property
    def counts(self) -> tuple[int, int, int, int]:
        """Events, impacts, events that rounding left open and steps with estimated errors.

        Up to the anchor or the end.
        """
        return self.n_events, self.n_impacts, self.n_uncertain, self.n_estimated

    @property
    def columns(self) -> Matrix:
        """Columns at the anchor."""
        return self._tangent.columns[:, : self.n]

    @property
    def end_state(self) -> Matrix:
        """State at the instant to which the last piece was asked to run."""
        state: Matrix = self._many.end_state
        return state

    @property
    def columns_at_end(self) -> Matrix:
        """Columns at the instant to which the last piece was asked to run."""
        columns: Matrix = self._tangent.samples[0]
        return columns

    @property
    def columns_before_event(self) -> Matrix:
        """Columns just before the last event, at its time."""
        return self._tangent.now[:, : self.n]

    @property
    def time_shifts(self) -> Matrix:
        """How much earlier the last event comes, by each column."""
        return self._tangent.shifts[0, : self.n]

    @property
    def last_rows(self) -> tuple[Rows, Matrix]:
        """Rows of the event log of the last piece, run with ``one_event``, and their states."""
        count = self._one.n_events
        return self._one.events[:count], self._one.event_states[:count]

    def set_columns(self, columns: Matrix) -> None:
        """Exchange the columns at the anchor; those that are not given are zero."""
        self._tangent.columns[:] = 0.0
        self._tangent.columns[: len(columns), : self.n] = columns

    def columns_of_mode(self) -> Matrix | None:
        """Derivatives of a start in the mode and the state of the anchor; None where it is none.

        Their span has the directions in which the mode lets the state differ: fewer than all where
        states are slaved, stick or rest.
        """
        other = TangentFlow(self.tables, self.derivatives, self.n, self.tolerance)
        try:
            status = other.start(self.anchor.state, self.here, self.mode)
        except NoMode:
            return None
        stays = status == Status.COMPLETED and other.mode == self.mode
        return other.first_columns if stays and not other.passed_at_start else None

    def save(self) -> Saved:
        """Copy of all that changes along a run."""
        return Saved(
            self.anchor.copied(),
            self.columns.copy(),
            self._many.counters.copy(),
            self._many.since.copy(),
            self.counts,
        )

    def restore(self, saved: Saved) -> None:
        """Go back to where a copy was taken."""
        self.anchor.put(..., saved.anchor)
        self.set_columns(saved.columns)
        self._many.counters[()] = saved.counters
        self._many.since[()] = saved.since
        self.n_events, self.n_impacts, self.n_uncertain, self.n_estimated = saved.counts

    def run_to(self, end: Instant, *, one_event: bool = False) -> Status:
        """Run on to an instant, or with ``one_event`` to just behind the next event.

        returns: COMPLETED at the instant, BUFFER_FULL at an event, else why the run ended
        """
        return self._run(end, GOES_ON, self._tangent, one_event=one_event)

    def between(self, first: Instant, last: Instant) -> float:
        """Time from one instant to another."""
        return (last.number - first.number) * self.window + (last.phase - first.phase)

    def after(self, first: Instant, duration: float) -> Instant:
        """Instant some time after another one."""
        whole = np.floor((first.phase + duration) / self.window)
        phase = first.phase + (duration - whole * self.window)
        return Instant(first.number + int(whole), min(max(phase, 0.0), self.window))

    def run_with(self, tangent: Tangent, ends: Sequence[Instant]) -> tuple[Status, int]:
        """Run on through some instants with other columns, and how many of them are reached.

        The columns have a sample for each instant.
        """
        count = len(ends)
        records = self._many.replace(
            sample_number=np.array([end.number for end in ends], np.int64),
            sample_phase=np.array([end.phase for end in ends]),
            sample_state=np.empty((count, self.n)),
            sample_mode=np.empty(count, np.int64),
        )
        status = self._record(records, ends[-1], GOES_ON, tangent)
        reached = int(records.counters["samples"])
        self.states_at_ends = records.sample_state[:reached]
        return status, reached

    def _run(self, end: Instant, mode: int, tangent: Tangent, *, one_event: bool) -> Status:
        records = self._one if one_event else self._many
        records.sample_number[0], records.sample_phase[0] = end
        return self._record(records, end, mode, tangent, one_event=one_event)

    def _record(
        self,
        records: Records,
        end: Instant,
        mode: int,
        tangent: Tangent,
        *,
        one_event: bool = False,
    ) -> Status:
        records.counters["samples"] = records.counters["segments"] = 0
        while True:
            for name in ("events", "uncertain", "estimated"):
                records.counters[name] = 0
            status = run(self._lane(tangent), records, mode, end, self.tolerance)
            self._count(records)
            mode = GOES_ON
            if status != Status.BUFFER_FULL or one_event:
                return status

    def _lane(self, tangent: Tangent) -> Lane:
        rates, scratch = self.derivatives.rates, self.derivatives.scratch
        return self.tables, rates, scratch, self.anchor, self.segment, tangent

    def _count(self, records: Records) -> None:
        rows = records.events[: records.n_events]
        passed = rows[rows["kind"] != EventKind.GRAZE]
        if len(passed):
            self.last_event = passed[-1].copy()
        self.n_events += int(np.count_nonzero(happened(rows)))
        if self.impacts is not None:
            self.n_impacts += self.impacts.count(rows)
        self.n_uncertain += int(records.counters["uncertain"])
        self.n_estimated += int(records.counters["estimated"])
