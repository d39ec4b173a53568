"""Runs with slowly varying parameters: one period after the other, each with frozen values.

At the beginning of a period the tables are set up for the new values, and the run goes on
in its mode at phase zero: slaved states take the values of their relations, and exits whose
guards the change has made negative fire at once. So the phase of the forcing is continuous,
also where its frequency changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.layout import Tables, allocate_segment
from nonsmooth.engine.loop import ANY, GOES_ON, SAME
from nonsmooth.engine.records import Anchor, Records, allocate_anchor, allocate_records
from nonsmooth.engine.status import Status
from nonsmooth.engine.tangent import allocate_tangent
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.simulation.clock import Instant, Plan
from nonsmooth.simulation.event_log import FIRST_CAPACITY, EventLog
from nonsmooth.simulation.history import Frozen, History
from nonsmooth.simulation.progress import Progress
from nonsmooth.simulation.runner import (
    NoMode,
    Outcome,
    advance,
    build_derivatives,
    build_tables,
    log_going_on,
)
from nonsmooth.simulation.slow_plan import Part, SlowPlan
from nonsmooth.simulation.start import Start
from nonsmooth.system.slow import SlowParameters

__all__ = ["check_slow_tangent", "run_slow", "tables_of"]

_WHOLE = 1e-12  # of a turn: a frequency that turns whole times in a period
_NOTHING = np.empty(0, np.int64), np.empty(0)


def check_slow_tangent(slow: SlowParameters, chosen: tuple[str, ...] | None) -> None:
    """Refuse derivatives by parameters that change the periods or what is frozen in them."""
    for name in chosen or ():
        if name in slow.names:
            raise OptionError(
                f"tangent: {name!r} varies by slow=, so there is no derivative by it; name the"
                " other parameters in a list, as in tangent=['b'], or none by tangent=[]"
            )
        if slow.followed_by(name):
            raise OptionError(
                f"tangent: the period or a parameter of slow= changes with {name!r}, and"
                " derivatives are taken for given values and times of the periods; name the other"
                " parameters in a list, as in tangent=['b'], or none by tangent=[]"
            )


def tables_of(slow: SlowParameters, values: Mapping[str, float]) -> Tables:
    """Tables for some values of the slow parameters."""
    tables = build_tables(slow.system, slow.all_values(values))
    turns = tables.harmonics[1]
    if np.any(np.abs(turns - np.rint(turns)) > _WHOLE * np.maximum(1.0, turns)):
        given = ", ".join(f"{name} = {value:g}" for name, value in values.items())
        raise ModelError(
            f"{slow.system.name}: with {given} the period {float(tables.clock[0]):g} is not a"
            " period of the equations; write period= as an expression of the parameters that"
            " change it"
        )
    return tables


@dataclass
class _Run:
    """A run in progress: its place in the engine and what was recorded."""

    slow: SlowParameters
    chosen: tuple[str, ...] | None
    tolerance: float
    anchor: Anchor
    segment: Any
    tangent: Any
    records: Records
    log: EventLog
    mode: int = GOES_ON  # how the next period begins, see `run_lane`
    history: History = field(default_factory=History)
    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    tables: Any = None
    derivatives: Any = None

    def enter(self, period: Frozen, tables: Tables) -> None:
        """Set up a period."""
        self.tables = tables
        self.derivatives = build_derivatives(
            self.slow.system, tables, self.chosen, self.slow.all_values(period.values)
        )
        self.history.add(period, float(tables.clock[0]))

    def pass_period(self, part: Part) -> Status:
        """Run to the end of the period, or of the run, and keep the samples."""
        number = self.history.periods[-1].number
        end = part.end or Instant(number + 1, 0.0)
        n, count = self.records.end_state.size, part.phase.size
        carried = self.tangent.columns.shape[0]
        # derivatives are known at samples only, so there is one more at the end of the period
        extra = 1 if carried and part.end is None else 0
        self.records.cursor[at.SAMPLES] = 0
        self.records = self.records._replace(
            sample_number=np.append(part.number, np.full(extra, end.number)),
            sample_phase=np.append(part.phase, np.full(extra, end.phase)),
            sample_state=np.full((count + extra, n), np.nan),
            sample_mode=np.full(count + extra, -1, np.int64),
        )
        self.tangent = self.tangent._replace(
            samples=np.full((count + extra if carried else 0, carried, n), np.nan)
        )
        arrays = (
            self.tables, self.derivatives.rates, self.derivatives.scratch, self.anchor,
            self.segment, self.tangent,
        )  # fmt: skip
        status, self.records = advance(
            arrays, end, self.records, self.log, self.tolerance, lambda _: None, mode=self.mode
        )
        self.mode = GOES_ON
        written = min(count, int(self.records.cursor[at.SAMPLES]))
        self.history.samples[-1] = written
        records, columns = self.records, self.tangent.samples
        self.pieces.append(
            (
                records.sample_number[:written],
                records.sample_phase[:written],
                records.sample_state[:written],
                records.sample_mode[:written],
                columns[:written],
            )
        )
        if extra and status == Status.COMPLETED:
            self.tangent.columns[:, :n] = columns[-1]
        return status

    def next_period(self) -> Status:
        """Enter the next period; REFUSED where the system refuses its values."""
        last, begins = self.history.periods[-1], self.history.end
        period = Frozen(last.number + 1, begins, self.slow.at(begins))
        fault = self.slow.fault(period.values)
        if not fault:
            try:
                tables = tables_of(self.slow, period.values)
            except ModelError as error:
                fault = str(error)
        if not fault and not begins + float(tables.clock[0]) > begins:
            fault = "the period is too short to be told from none"
        if fault:
            self.history.fault = fault
            return Status.REFUSED
        self.enter(period, tables)
        anchor = self.anchor
        anchor.place[0], anchor.phase[0] = period.number, 0.0
        anchor.state[:] = self.records.end_state
        anchor.order[:] = 0
        self.mode = SAME - int(anchor.place[1])
        return Status.COMPLETED


def run_slow(
    slow: SlowParameters,
    tables: Tables,
    period: Frozen,
    plan: SlowPlan,
    start: Start,
    tolerance: float,
    *,
    mode: int = ANY,
    keep_events: bool = True,
    chosen: tuple[str, ...] | None = None,
) -> Outcome:
    """Run a plan from the period of its start; `NoMode` where no mode admits the start."""
    sizes = tables.sizes
    n_chosen = -1 if chosen is None else len(chosen)
    run = _Run(
        slow, chosen, tolerance,
        anchor=start.anchor or allocate_anchor(sizes),
        segment=allocate_segment(sizes, max(0, n_chosen)),
        tangent=allocate_tangent(sizes, n_chosen, 0),
        records=allocate_records(sizes, *_NOTHING, FIRST_CAPACITY),
        log=EventLog(keep_events),
    )  # fmt: skip
    run.enter(period, tables)
    status = Status.COMPLETED
    if start.anchor is None:
        run.anchor.place[0], run.anchor.phase[0] = start.instant
        run.anchor.state[:] = start.state
        run.mode = mode
    else:
        log_going_on(run.records, start.instant, run.anchor, start.state)
        run.records.since[:] = start.instant
    end = None
    try:
        with Progress("simulating", plan.total) as progress:
            while status == Status.COMPLETED:
                part = plan.part(run.history.periods[-1], run.history.windows[-1])
                status, end = run.pass_period(part), part.end
                if status == Status.INADMISSIBLE and run.records.cursor[at.EVENTS] == 0:
                    raise NoMode(run.segment.z.copy())
                if end is not None or status != Status.COMPLETED:
                    break
                progress.update(plan.done(run.history.periods[-1]))
                status = run.next_period()
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    return _outcome(run, status, end)


def _outcome(run: _Run, status: Status, end: Instant | None) -> Outcome:
    if status == Status.REFUSED:
        end = Instant(run.history.periods[-1].number + 1, 0.0)
    elif end is None or status != Status.COMPLETED:
        end = Instant(int(run.anchor.place[0]), float(run.anchor.phase[0]))
    arrays = [_joined(run, i) for i in range(5)]
    records = run.records._replace(
        sample_number=arrays[0],
        sample_phase=arrays[1],
        sample_state=arrays[2],
        sample_mode=arrays[3],
    )
    integers, floats = run.log.rows(run.records)
    return Outcome(
        status=status,
        tables=run.tables,
        columns=None if run.chosen is None else arrays[4],
        chosen=run.chosen or (),
        plan=Plan(end, arrays[0], arrays[1]),
        anchor=run.anchor,
        records=records,
        n_samples=arrays[0].size,
        event_integers=integers,
        event_floats=floats,
        keeps_events=run.log.keep,
        n_events=run.log.n_left_out + len(integers) - 1,  # the first row is the start
        n_uncertain=int(run.records.cursor[at.UNCERTAIN]),
        end=end,
        history=run.history,
    )


def _joined(run: _Run, i: int) -> npt.NDArray[Any]:
    """Samples of all periods."""
    empty = (run.records.sample_number, run.records.sample_phase, run.records.sample_state,
             run.records.sample_mode, run.tangent.samples)[i][:0]  # fmt: skip
    return np.concatenate([empty, *(piece[i] for piece in run.pieces)])
