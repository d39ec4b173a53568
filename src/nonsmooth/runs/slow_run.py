"""A run with slow parameters in progress: one period, or many in a row, at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import GOES_ON, RESUMES, SAME, WORK, Anchor, Records, run_lanes
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables, allocate_stack, set_up
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.event_log import EventLog
from nonsmooth.runs.history import Frozen, History
from nonsmooth.runs.runner import (
    NO_DERIVATIVES,
    UNLIMITED,
    WorkLimits,
    advance,
    build_derivatives,
    build_tables,
)
from nonsmooth.runs.slow_plan import PlanPart, SlowPlan
from nonsmooth.system.slow import SlowParameters

__all__ = ["SlowRun", "tables_of"]

_WHOLE = 1e-12  # of a turn: a frequency that turns whole times in a period
Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_AHEAD = 5000  # periods in one call at most: a tenth of a second for a beam
_TOGETHER = 2**24  # bytes of their tables


def tables_of(slow: SlowParameters, values: Mapping[str, float]) -> Tables:
    """Tables for some values of the slow parameters."""
    tables = build_tables(slow.system, slow.all_values(values))
    turns = tables.harmonics[1]
    if np.any(np.abs(turns - np.rint(turns)) > _WHOLE * np.maximum(1.0, turns)):
        given = ", ".join(f"{name} = {value:g}" for name, value in values.items())
        raise ModelError(
            f"{slow.system.name}: with {given} the period {tables.window:g} is not a"
            " period of the equations; write period= as an expression of the parameters that"
            " change it"
        )
    return tables


@dataclass
class SlowRun:
    """A run in progress: its place in the engine and what was recorded."""

    slow: SlowParameters
    chosen: tuple[str, ...] | None
    tolerance: float
    anchor: Anchor
    segment: Any
    tangent: Any
    records: Records
    log: EventLog
    limits: WorkLimits = UNLIMITED
    mode: int = GOES_ON  # how the next period begins, see `run_lane`
    history: History = field(default_factory=History)
    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    tables: Any = None
    derivatives: Any = None
    _lent: Tables | None = None

    def enter(self, period: Frozen, tables: Tables) -> None:
        """Set up a period."""
        self.tables = tables
        self.derivatives = build_derivatives(
            self.slow.system, tables, self.chosen, self.slow.all_values(period.values)
        )
        self.history.add(period, tables.window)

    def pass_period(self, part: PlanPart, check: Callable[[], None]) -> Status:
        """Run to the end of the period, or of the run, and keep the samples.

        ``check`` raises KeyboardInterrupt where the run shall stop.
        """
        number = self.history.last.number
        end = part.end or Instant(number + 1, 0.0)
        carried = self.tangent.columns.shape[0]
        # derivatives are known at samples only, so there is one more at the end of the period
        extra = carried > 0 and part.end is None
        self._expect(part, end if extra else None)
        arrays = (
            self.tables, self.derivatives.rates, self.derivatives.scratch, self.anchor,
            self.segment, self.tangent,
        )  # fmt: skip
        status, self.records = advance(
            arrays, end, self.records, self.log, self.tolerance, lambda _: check(), mode=self.mode,
            limits=self.limits,
        )  # fmt: skip
        self.mode = GOES_ON
        self.history.note_samples(self._keep_samples(part))
        if extra and status == Status.COMPLETED:
            self.tangent.columns[:, : self.records.end_state.size] = self.tangent.samples[-1]
        return status

    def next_period(self) -> Status:
        """Enter the next period; REFUSED where the system refuses its values."""
        last, begins = self.history.last, self.history.end
        period = Frozen(last.number + 1, begins, self.slow.at(begins))
        fault = self.slow.fault(period.values)
        if not fault:
            try:
                tables = tables_of(self.slow, period.values)
            except ModelError as error:
                fault = str(error)
        if not fault and not begins + tables.window > begins:
            fault = "the period is too short to be told from none"
        if fault:
            self.history.fault = fault
            return Status.REFUSED
        self.enter(period, tables)
        self._begin(period.number)
        return Status.COMPLETED

    def _begin(self, number: int) -> None:
        """Put the anchor where a period begins, in the mode in which the last one ended."""
        anchor = self.anchor
        anchor.move_to((number, 0.0))
        anchor.state[:] = self.records.end_state
        anchor.order[:] = 0
        self.records.counters["window_events"] = 0
        self.mode = SAME - anchor.mode

    def pass_ahead(self, plan: SlowPlan, check: Callable[[], None]) -> Status:
        """Run through whole periods whose values are known beforehand, if there are any.

        They are where neither the period nor a frequency varies, and no columns of derivatives
        have to be restarted. A period alone costs several times as much, for its calls of kernels.
        """
        if self.chosen is not None or self.slow.changes_clock:
            return Status.COMPLETED
        last, window = self.history.last, self.history.last_window
        room = int(np.clip(_TOGETHER // self.tables.n_bytes, 1, _AHEAD))
        origins = np.add.accumulate(np.array([last.origin, *[window] * room]))[1:]
        origins = origins[: plan.whole(last.number + 1, origins, window)]
        values = self.slow.at_times(origins)
        refused = np.flatnonzero(~self.slow.admissible(values))
        origins = origins[: refused[0]] if refused.size else origins
        if origins.size == 0 or not np.all(np.diff(origins, prepend=last.origin) > 0.0):
            return Status.COMPLETED
        stack = self._stack(room)
        program = self.slow.system.compiled.program
        _, _, count = set_up(program, self.slow.rows(values)[: origins.size], stack)
        if count == 0:  # the next period is refused in so many words
            return Status.COMPLETED
        part = plan.parts(last.number + 1, origins[:count], window)
        self._expect(part)
        status, samples = self._pass_stack(stack.part(slice(count)), origins, plan, check)
        begun, written = samples.size, np.diff(samples, prepend=0)
        frozen = {name: values[name][:begun] for name in self.slow.names}
        self.history.add_stretch(origins[:begun], window, frozen, written)
        self.tables = stack.part(begun - 1).copied()
        self._keep_samples(part)
        return status

    def _stack(self, room: int) -> Tables:
        """Tables for so many periods, the same memory every time: new memory costs more."""
        if self._lent is None:
            self._lent = allocate_stack(self.slow.system.compiled.program, room)
        return self._lent

    def _pass_stack(
        self, stack: Tables, origins: Array, plan: SlowPlan, check: Callable[[], None]
    ) -> tuple[Status, Integers]:
        """Run through the periods of a stack; samples by the end of each that was begun."""
        count = stack.clock.shape[0]
        first = self.history.last.number + 1
        self._begin(first)
        modes, statuses = np.array([self.mode]), np.empty(1, np.int64)
        passed, status = np.zeros(1 + count, np.int64), Status.PAUSED
        try:
            while status in (Status.PAUSED, Status.BUFFER_FULL):
                run_lanes(
                    stack, NO_DERIVATIVES.rates, NO_DERIVATIVES.scratch, self.anchor.as_lanes,
                    self.segment, self.tangent.as_lanes, self.records.as_lanes, modes, 0, 1,
                    first + count, 0.0, passed, statuses, self.tolerance, WORK,
                    self.limits.most_events,
                )  # fmt: skip
                status = Status(int(statuses[0]))
                if status == Status.BUFFER_FULL:
                    reached = int(passed[0])
                    done = plan.done(Frozen(first + reached, float(origins[reached]), {}))
                    self.records = self.log.make_room(self.records, done / plan.total)
                if status == Status.PAUSED:
                    check()
                    if self.limits.time_is_up and modes[0] != RESUMES:
                        status = Status.WORK_LIMIT
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        return status, passed[1 : 2 + passed[0]]

    def _expect(self, part: PlanPart, extra: Instant | None = None) -> None:
        """Make room for samples, and for one more of which only the derivatives are read."""
        n, carried = self.records.end_state.size, self.tangent.columns.shape[0]
        more = [] if extra is None else [extra]
        count = part.phase.size + len(more)
        self.records.counters["samples"] = 0
        self.records = self.records.replace(
            sample_number=np.append(part.number, [each.number for each in more]).astype(np.int64),
            sample_phase=np.append(part.phase, [each.phase for each in more]),
            sample_state=np.full((count, n), np.nan),
            sample_mode=np.full(count, -1, np.int64),
        )
        self.tangent = self.tangent.replace(
            samples=np.full((count if carried else 0, carried, n), np.nan)
        )

    def _keep_samples(self, part: PlanPart) -> int:
        """Keep the samples that were written, and give their number."""
        written = min(part.phase.size, int(self.records.counters["samples"]))
        records = self.records
        self.pieces.append(
            (
                records.sample_number[:written],
                records.sample_phase[:written],
                records.sample_state[:written],
                records.sample_mode[:written],
                self.tangent.samples[:written],
            )
        )
        return written
