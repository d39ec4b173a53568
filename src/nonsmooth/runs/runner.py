"""Drives the engine loop: tables, chunks, the event buffer, interruption, progress, limits.

Where seconds are limited, the clock only decides when a run stops. The engine returns after a
bounded amount of counted work, and no digit depends on where.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import (
    Columns,
    Rates,
    allocate_rates,
    allocate_scratch,
    no_rates,
    no_scratch,
    set_up_rates,
)
from nonsmooth.engine.lanes import (
    GOES_ON,
    NO_LIMIT,
    RESUMES,
    SEARCHING,
    STOPPING,
    Anchor,
    Lane,
    Records,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
    run_some,
)
from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import SETUP_ERRORS, Certificate, EventKind, Status
from nonsmooth.engine.tables import MAX_AUGMENTED, Tables, allocate_tables, set_up
from nonsmooth.errors import ModelError
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.event_log import FIRST_CAPACITY, EventLog, LentRoom
from nonsmooth.runs.history import History
from nonsmooth.runs.options import positive_number, whole_number
from nonsmooth.system.system import System

__all__ = [
    "NO_DERIVATIVES",
    "UNLIMITED",
    "Derivatives",
    "NoMode",
    "Outcome",
    "WorkLimits",
    "advance",
    "build_derivatives",
    "build_tables",
    "last_instant",
    "limits_from",
    "log_going_on",
    "run_plan",
]


_ZERO = Instant(0, 0.0)
_ROUNDS = 8  # until a sum of times is rounded to the other side


@dataclass(frozen=True)
class WorkLimits:
    """Where a run has to stop: by the monotonic clock, and by the number of its events."""

    deadline: float = float("inf")
    most_events: int = NO_LIMIT

    @property
    def foreseen_events(self) -> float | None:
        """Largest number of events of a run; None where the clock may end it at any of them."""
        if self.deadline < UNLIMITED.deadline:
            return None
        return self.most_events if self.most_events != NO_LIMIT else float("inf")

    @property
    def time_is_up(self) -> bool:
        """Whether the run has taken as long as it may."""
        return time.monotonic() >= self.deadline


UNLIMITED = WorkLimits()


def limits_from(max_seconds: Any, max_events: Any) -> WorkLimits:
    """Limits from the options of a run, counted from now; None is no limit."""
    deadline, most_events = UNLIMITED.deadline, UNLIMITED.most_events
    if max_seconds is not None:
        deadline = time.monotonic() + positive_number("max_seconds", max_seconds)
    if max_events is not None:
        most_events = whole_number("max_events", max_events)
    return WorkLimits(deadline, most_events)


class NoMode(Exception):
    """No mode admits the start; carries the augmented coordinates of the start."""

    def __init__(self, z: npt.NDArray[np.float64]) -> None:
        super().__init__("no mode admits the start")
        self.z = z


@dataclass(frozen=True)
class Outcome:
    """What a run left behind, as arrays."""

    status: Status
    tables: Tables
    columns: npt.NDArray[np.float64] | None  # (sample, column, state) of derivatives
    chosen: tuple[str, ...]  # parameters of the last columns
    plan: Plan
    anchor: Anchor
    records: Records
    n_samples: int
    events: Rows  # the whole log, or its end where it was not kept
    event_states: npt.NDArray[np.float64]  # (event, 2, n) before and after
    keeps_events: bool
    n_events: int
    end: Instant
    history: History | None = None  # periods of a run with slow parameters

    def unless_interrupted(self) -> Outcome:
        """Raise `KeyboardInterrupt` after Ctrl-C, in parts of work that keep nothing; or itself."""
        if self.status == Status.INTERRUPTED:
            raise KeyboardInterrupt
        return self

    @property
    def n_uncertain(self) -> int:
        """Number of events that rounding leaves open."""
        return int(self.records.counters["uncertain"])

    @property
    def n_estimated(self) -> int:
        """Number of steps the errors of which are estimated."""
        return int(self.records.counters["estimated"])

    @property
    def window(self) -> float:
        """Length of the last window."""
        return self.tables.window

    def times(self, number: Any, phase: Any) -> Any:
        """Times as single numbers."""
        if self.history is not None:
            return self.history.times(number, phase)
        time = number * self.window
        time += phase
        return time

    @property
    def end_time(self) -> float:
        """Time at the end."""
        return float(self.times(self.end.number, self.end.phase))


@dataclass(frozen=True)
class Derivatives:
    """What a run needs to carry columns of derivatives along, or nothing of the kind."""

    rates: Rates
    scratch: Columns
    chosen: tuple[str, ...] | None  # parameters; None where no columns are carried

    @property
    def count(self) -> int:
        """Number of parameters, -1 where no columns are carried."""
        return -1 if self.chosen is None else len(self.chosen)


NO_DERIVATIVES = Derivatives(no_rates(), no_scratch(), None)


def build_derivatives(
    system: System,
    tables: Tables,
    chosen: tuple[str, ...] | None,
    values: Mapping[str, float] | None = None,
) -> Derivatives:
    """Rates of the tables by some parameters, given by name; None for no columns at all.

    ``values`` are those of all parameters, where they are not the system's.
    """
    if chosen is None:
        return NO_DERIVATIVES
    program = system.compiled.program
    values = system.parameter_values if values is None else values
    numbers = np.array([list(values).index(name) for name in chosen], np.int64)
    rates = allocate_rates(program, numbers)
    code, place = set_up_rates(program, np.array(list(values.values()), float), tables, rates)
    if code != Status.COMPLETED:
        name = chosen[place]
        raise ModelError(
            f"{system.name}: a coefficient has no finite derivative with respect to {name!r} at"
            f" {name} = {values[name]:g}; leave it out of tangent="
        )
    return Derivatives(rates, allocate_scratch(program, numbers), chosen)


def build_tables(system: System, values: Mapping[str, float] | None = None) -> Tables:
    """Tables of a system for its parameter values, or for others."""
    program = system.compiled.program
    if program.sizes.augmented > MAX_AUGMENTED:
        raise ModelError(
            f"{system.name}: states, powers of time, two per frequency and four per signal make"
            f" {program.sizes.augmented} coordinates; at most {MAX_AUGMENTED} are supported"
        )
    tables = allocate_tables(program)
    values = system.parameter_values if values is None else values
    given = np.array([[values[name] for name in system.parameters]], dtype=float)
    code, mode, _ = set_up(program, given, tables.as_lanes)
    if code != Status.COMPLETED:
        where, what = f"mode {system.mode_names[max(mode, 0)]!r}", SETUP_ERRORS[code]
        if mode < 0:
            where, what = "the period", "it is not a positive finite number for these parameters"
        numbers = ", ".join(f"{k} = {v:g}" for k, v in values.items())
        raise ModelError(f"{system.name}, {where}: {what} ({numbers})")
    return tables


def run_plan(
    tables: Tables,
    plan: Plan,
    tolerance: float,
    *,
    anchor: Anchor | None = None,
    state: npt.NDArray[np.float64] | None = None,
    begin: Instant = _ZERO,
    mode: int = -1,
    keep_events: bool = True,
    derivatives: Derivatives = NO_DERIVATIVES,
    limits: WorkLimits = UNLIMITED,
    room: LentRoom | None = None,
) -> Outcome:
    """Run a plan from an anchor, or from a state at an instant; `NoMode` when none fits.

    With ``room`` the log of the outcome is there only as long as the room is.
    """
    sizes = tables.sizes
    records = allocate_records(
        sizes, plan.sample_number, plan.sample_phase, FIRST_CAPACITY, filled=False
    )
    if room is not None:
        records = room.put_into(records)
    segment = allocate_segment(sizes, max(0, derivatives.count))
    tangent = allocate_tangent(sizes, derivatives.count, plan.sample_phase.size)
    if anchor is None:
        assert state is not None
        anchor = allocate_anchor(sizes)
        anchor.move_to(begin)
        anchor.state[:] = state
    else:
        mode = GOES_ON
        log_going_on(records, begin, anchor, state)
        records.since[()] = tuple(begin)
        if state is not None:
            records.end_state[:] = state
    log = EventLog(keep_events, lent=room is not None, most=limits.foreseen_events)
    lane = (tables, derivatives.rates, derivatives.scratch, anchor, segment, tangent)
    windows = max(1, plan.end.number - anchor.number)
    try:
        with HeldInterrupts() as held, Progress("simulating", windows) as progress:

            def report(done: int) -> None:
                progress.update(done)
                held.check()

            status, records = advance(
                lane, plan.end, records, log, tolerance, report, mode=mode, limits=limits
            )
    except KeyboardInterrupt:  # it came in the last call, whose results are kept too
        status = Status.INTERRUPTED
    if status == Status.INADMISSIBLE and records.n_events == 0:
        raise NoMode(segment.z.copy())
    end = plan.end if status == Status.COMPLETED else last_instant(anchor, records)
    keep_start(records, begin, anchor)
    rows, states = log.rows(records)
    return Outcome(
        status=status,
        tables=tables,
        columns=None if derivatives.chosen is None else tangent.samples,
        chosen=derivatives.chosen or (),
        plan=plan,
        anchor=anchor,
        records=records,
        n_samples=int(records.counters["samples"]),
        events=rows,
        event_states=states,
        keeps_events=keep_events,
        n_events=log.n_left_out + len(rows) - 1,  # the first row is the start
        end=end,
    )


def advance(
    lane: Lane,
    end: Instant,
    records: Records,
    log: EventLog,
    tolerance: float,
    report: Callable[[int], None],
    *,
    mode: int = GOES_ON,
    limits: WorkLimits = UNLIMITED,
) -> tuple[Status, Records]:
    """Run to an instant, in pieces; ``report`` is told how many windows are done.

    ``mode`` says how the first piece begins, see `run_lanes`. A run that is interrupted, or has
    reached its limits, ends where it has come to.
    """
    anchor = lane[3]
    first = anchor.number
    windows = max(1, end.number - first)
    while True:
        try:
            status, mode = run_some(lane, records, mode, end, tolerance, limits.most_events)
            if status == Status.BUFFER_FULL:
                records = log.make_room(records, (anchor.number - first) / windows)
            elif status != Status.PAUSED:
                return status, records
            report(anchor.number - first)
            if not limits.time_is_up:
                continue
            status = Status.WORK_LIMIT
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        if mode == RESUMES:
            _stop_within(lane, records, tolerance)
        return status, records


def _stop_within(lane: Lane, records: Records, tolerance: float) -> None:
    """End a run at the place in a segment to which the search for its next event has come.

    Up to there nothing happens. A run that goes on and has not come to its start yet stays there.
    """
    tables, anchor, pause = lane[0], lane[3], lane[4].pause
    reached, window = float(pause["reached"]), tables.window
    whole = np.floor((anchor.phase + reached) / window)
    phase = anchor.phase + reached - whole * window
    for _ in range(_ROUNDS):  # the engine must find this instant no later than what is reached
        late = whole * window + (phase - anchor.phase) - reached
        if late <= 0.0:
            break
        phase -= max(late, np.spacing(phase))
    end = Instant(anchor.number + int(whole), float(phase))
    since = records.since
    before = (float(since["number"]), float(since["phase"]))
    if late > 0.0 or phase < 0.0 or tuple(end) < before:
        return
    if pause["stage"] == SEARCHING:
        pause["stage"] = STOPPING
    run(lane, records, RESUMES, end, tolerance)


def keep_start(records: Records, begin: Instant, anchor: Anchor) -> None:
    """Write the sample at the start of a run that goes on and has not left it."""
    if records.counters["samples"] or not records.sample_number.size:
        return
    if Instant(int(records.sample_number[0]), float(records.sample_phase[0])) == begin:
        records.sample_state[0], records.sample_mode[0] = records.end_state, anchor.mode
        records.counters["samples"] = 1


def last_instant(anchor: Anchor, records: Records) -> Instant:
    """Instant that a run has come to which ended early: an event, or the end of a call before."""
    reached = Instant(anchor.number, anchor.phase)
    number, phase = records.since["number"], records.since["phase"]
    if not np.isfinite(number):
        return reached
    return max(reached, Instant(int(number), float(phase)))


def log_going_on(
    records: Records, begin: Instant, anchor: Anchor, state: npt.NDArray[np.float64] | None
) -> None:
    """Row of the event log for a run that goes on from an earlier one."""
    row = records.events[0]
    for name, value in (
        ("number", begin.number),
        ("kind", EventKind.START),
        ("from_mode", anchor.mode),
        ("to_mode", anchor.mode),
        ("exit", -1),
        ("certificate", Certificate.CERTIFIED),
        ("count", 1),
        ("phase", begin.phase),
    ):
        row[name] = value
    if state is not None:
        records.event_states[0] = state
    records.counters["events"] = 1
