"""Runs with slowly varying parameters: one period after the other, each with frozen values.

At the beginning of a period the tables are set up for the new values, and the run goes on
in its mode at phase zero: slaved states take the values of their relations, and exits whose
guards the change has made negative fire at once. So the phase of the forcing is continuous,
also where its frequency changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    ANY,
    GOES_ON,
    RESUMES,
    SAME,
    WORK,
    Anchor,
    Records,
    Segment,
    Tangent,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run_lanes,
)
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables, allocate_stack, set_up
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.clock import Instant, Plan, instants
from nonsmooth.runs.event_log import FIRST_CAPACITY, EventLog
from nonsmooth.runs.history import Frozen, History
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.runner import (
    NO_DERIVATIVES,
    UNLIMITED,
    Derivatives,
    NoMode,
    Outcome,
    WorkLimits,
    advance,
    build_derivatives,
    build_tables,
    last_instant,
    log_going_on,
)
from nonsmooth.runs.slow_plan import PlanPart, SlowPlan
from nonsmooth.runs.start import Start, resolve_start
from nonsmooth.system.slow import SlowParameters

__all__ = ["check_slow_tangent", "resolve_slow_start", "run_slow", "tables_of"]

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Make = Callable[[dict[str, float]], Tables]

_WHOLE = 1e-12  # of a turn: a frequency that turns whole times in a period
_AHEAD = 5000  # periods in one call at most: a tenth of a second for a beam
_TOGETHER = 2**24  # bytes of their tables
_NOTHING = np.empty(0, np.int64), np.empty(0)


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


class _Samples(NamedTuple):
    """Samples of some periods, s of them; C columns of derivatives."""

    number: Integers  # (s,)
    phase: Array  # (s,)
    state: Array  # (s, n)
    mode: Integers  # (s,)
    columns: Array  # (s, C, n)


@dataclass
class _SlowRun:
    """A run in progress: its place in the engine and what was recorded."""

    slow: SlowParameters
    chosen: tuple[str, ...] | None
    tolerance: float
    anchor: Anchor
    segment: Segment
    tangent: Tangent
    records: Records
    log: EventLog
    limits: WorkLimits = UNLIMITED
    mode: int = GOES_ON  # how the next period begins, see `run_lane`
    history: History = field(default_factory=History)
    pieces: list[_Samples] = field(default_factory=list)
    tables: Tables = field(init=False)  # of the period that was entered last
    derivatives: Derivatives = NO_DERIVATIVES
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
        passed = (period.number - self.anchor.number) * self.tables.window - self.anchor.phase
        self.records.counters["block_time"] += passed
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

    def _samples(self, count: int) -> _Samples:
        """The first samples of the records, so many of them."""
        records = self.records
        return _Samples(
            records.sample_number[:count], records.sample_phase[:count],
            records.sample_state[:count], records.sample_mode[:count], self.tangent.samples[:count],
        )  # fmt: skip

    def _keep_samples(self, part: PlanPart) -> int:
        """Keep the samples that were written, and give their number."""
        written = min(part.phase.size, int(self.records.counters["samples"]))
        self.pieces.append(self._samples(written))
        return written


def resolve_slow_start(
    slow: SlowParameters,
    make_tables: Make,
    initial: Any,
    t_start: float | None,
    mode: str | None,
    repeated: bool,
) -> tuple[Start, Frozen, Tables]:
    """Start of a run, the period in which it lies, and the tables of that period.

    A run goes on with the values that were frozen where it ended, and so does a start from a
    point within a period.
    """
    system = slow.system
    from_data = hasattr(initial, "data_vars") and t_start is None
    if from_data and "time" in initial.dims and _has_values(slow, initial.attrs):
        period = _period_of_run(initial)
        tables = make_tables(period.values)
        start = resolve_start(system, tables, initial, None, mode, repeated)
        if start.anchor is None:  # the system is another one: the share of the period is kept
            number, phase = int(initial.attrs["end_number"]), float(initial.attrs["end_phase"])
            phase *= tables.window / float(initial.attrs["window"])
            start = replace(start, instant=Instant(number, phase))
        return start, period, tables
    if from_data and _is_within(slow, initial):
        values = {name: float(initial[name]) for name in slow.names}
        instant = Instant(int(initial["period_number"]), float(initial["phase"]))
        period = Frozen(instant.number, float(initial["time"]) - instant.phase, values)
    else:
        period, instant = _fresh(slow, make_tables, _time_of(initial, t_start))
    tables = _checked(slow, make_tables, period.values)
    start = resolve_start(system, tables, initial, t_start, mode, repeated)
    return replace(start, instant=instant), period, tables


def _has_values(slow: SlowParameters, attrs: Any) -> bool:
    names = [pair.partition("=")[0] for pair in str(attrs.get("slow_values", "")).split()]
    return tuple(names) == slow.names


def _period_of_run(run: Any) -> Frozen:
    pairs = (pair.partition("=") for pair in run.attrs["slow_values"].split())
    values = {name: float(value) for name, _, value in pairs}
    return Frozen(int(run.attrs["slow_number"]), float(run.attrs["slow_origin"]), values)


def _is_within(slow: SlowParameters, data: Any) -> bool:
    """Whether a point lies within a period whose values are known."""
    needed = (*slow.names, "period_number", "phase", "time")
    return (
        "time" not in data.dims
        and all(name in data.variables for name in needed)
        and float(data["phase"]) > 0.0
    )


def _time_of(initial: Any, t_start: float | None) -> float:
    if t_start is not None:
        return finite_number("t_start", t_start)
    if not hasattr(initial, "data_vars"):
        return 0.0
    if "time" not in initial.dims:
        return float(initial.coords.get("time", 0.0))
    attrs = initial.attrs
    if "end_time" in attrs:
        return float(attrs["end_time"])
    if "end_number" not in attrs:  # no run of ours, which is refused later
        return 0.0
    return int(attrs["end_number"]) * float(attrs["window"]) + float(attrs["end_phase"])


def _fresh(slow: SlowParameters, make_tables: Make, time: float) -> tuple[Frozen, Instant]:
    """Period in which a time lies, as if the values there had always been."""
    values = slow.at(time)
    window = _checked(slow, make_tables, values).window
    number, phase = instants([time], window)
    instant = Instant(int(number[0]), float(phase[0]))
    return Frozen(instant.number, time - instant.phase, values), instant


def _checked(slow: SlowParameters, make_tables: Make, values: dict[str, float]) -> Tables:
    fault = slow.fault(values)
    if fault:
        raise ModelError(f"{slow.system.name}, slow= at the start: {fault}")
    tables = make_tables(values)
    if not math.isfinite(tables.window):
        raise ModelError(f"{slow.system.name}, slow= at the start: the period is not finite")
    return tables


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
    limits: WorkLimits = UNLIMITED,
) -> Outcome:
    """Run a plan from the period of its start; `NoMode` where no mode admits the start."""
    sizes = tables.sizes
    n_chosen = -1 if chosen is None else len(chosen)
    run = _SlowRun(
        slow, chosen, tolerance,
        anchor=start.anchor or allocate_anchor(sizes),
        segment=allocate_segment(sizes, max(0, n_chosen)),
        tangent=allocate_tangent(sizes, n_chosen, 0),
        records=allocate_records(sizes, *_NOTHING, FIRST_CAPACITY),
        log=EventLog(keep_events, most=limits.foreseen_events),
        limits=limits,
    )  # fmt: skip
    run.enter(period, tables)
    status = Status.COMPLETED
    if start.anchor is None:
        run.anchor.move_to(start.instant)
        run.anchor.state[:] = start.state
        run.mode = mode
    else:
        log_going_on(run.records, start.instant, run.anchor, start.state)
        run.records.since[()] = tuple(start.instant)
        run.records.end_state[:] = start.state
    end = None
    try:
        with HeldInterrupts() as held, Progress("simulating", plan.total) as progress:
            while status == Status.COMPLETED:
                part = plan.part(run.history.last, run.history.last_window)
                status, end = run.pass_period(part, held.check), part.end
                if status == Status.INADMISSIBLE and run.records.n_events == 0:
                    raise NoMode(run.segment.z.copy())
                if end is not None or status != Status.COMPLETED:
                    break
                if limits.time_is_up:
                    status = Status.WORK_LIMIT
                    break
                status = run.pass_ahead(plan, held.check)
                progress.update(plan.done(run.history.last))
                if status == Status.COMPLETED:
                    status = run.next_period()
                held.check()
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    return _outcome(run, status, end, plan.grid)


def _outcome(
    run: _SlowRun, status: Status, end: Instant | None, times: npt.NDArray[np.float64] | None
) -> Outcome:
    if status == Status.REFUSED:
        end = Instant(run.history.last.number + 1, 0.0)
    elif end is None or status != Status.COMPLETED:
        end = last_instant(run.anchor, run.records)
    samples = _joined([run._samples(0), *run.pieces])
    records = run.records.replace(
        sample_number=samples.number,
        sample_phase=samples.phase,
        sample_state=samples.state,
        sample_mode=samples.mode,
    )
    rows, states = run.log.rows(run.records)
    return Outcome(
        status=status,
        tables=run.tables,
        columns=None if run.chosen is None else samples.columns,
        chosen=run.chosen or (),
        plan=Plan(end, samples.number, samples.phase, times),
        anchor=run.anchor,
        records=records,
        n_samples=samples.number.size,
        events=rows,
        event_states=states,
        keeps_events=run.log.keep,
        n_events=run.log.n_left_out + len(rows) - 1,  # the first row is the start
        end=end,
        history=run.history,
    )


def _joined(pieces: list[_Samples]) -> _Samples:
    """Samples of all periods, one after the other."""
    return _Samples(*map(np.concatenate, zip(*pieces, strict=True)))
