"""Drives the engine loop: tables, chunks, the event buffer, interruption, progress."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.lanes import Lane, run
from nonsmooth.engine.layout import (
    MAX_AUGMENTED,
    Tables,
    allocate_segment,
    allocate_tables,
    augmented_size,
    stack_of_one,
)
from nonsmooth.engine.loop import GOES_ON
from nonsmooth.engine.records import Anchor, Records, allocate_anchor, allocate_records
from nonsmooth.engine.setup import set_up
from nonsmooth.engine.status import SETUP_ERRORS, EventKind, Status
from nonsmooth.engine.tangent import allocate_tangent
from nonsmooth.engine.variation_setup import set_up_rates
from nonsmooth.engine.variation_tables import (
    Columns,
    Rates,
    allocate_columns,
    allocate_rates,
    no_columns,
    no_rates,
)
from nonsmooth.errors import ModelError
from nonsmooth.simulation.clock import Instant, Plan
from nonsmooth.simulation.event_log import FIRST_CAPACITY, EventLog
from nonsmooth.simulation.history import History
from nonsmooth.simulation.interrupts import HeldInterrupts
from nonsmooth.simulation.kernels import announce_compilation, announce_derivatives
from nonsmooth.simulation.progress import Progress
from nonsmooth.system.system import System

__all__ = [
    "NO_DERIVATIVES",
    "Derivatives",
    "NoMode",
    "Outcome",
    "advance",
    "build_derivatives",
    "build_tables",
    "last_instant",
    "log_going_on",
    "run_plan",
]

_ZERO = Instant(0, 0.0)
_WINDOWS_PER_CALL = 10_000  # a few hundredths of a second: interruption and progress


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
    event_integers: npt.NDArray[np.int64]  # the whole log, or its end where it was not kept
    event_floats: npt.NDArray[np.float64]
    keeps_events: bool
    n_events: int
    n_uncertain: int
    end: Instant
    history: History | None = None  # periods of a run with slow parameters

    @property
    def window(self) -> float:
        """Length of the last window."""
        return float(self.tables.clock[0])

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


NO_DERIVATIVES = Derivatives(no_rates(), no_columns(), None)


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
    announce_derivatives()
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
    return Derivatives(rates, allocate_columns(program, numbers), chosen)


def build_tables(system: System, values: Mapping[str, float] | None = None) -> Tables:
    """Tables of a system for its parameter values, or for others."""
    program = system.compiled.program
    if augmented_size(program.sizes) > MAX_AUGMENTED:
        raise ModelError(
            f"{system.name}: states, powers of time, two per frequency and four per signal make"
            f" {augmented_size(program.sizes)} coordinates; at most {MAX_AUGMENTED} are supported"
        )
    announce_compilation()
    tables = allocate_tables(program)
    values = system.parameter_values if values is None else values
    given = np.array([[values[name] for name in system.parameters]], dtype=float)
    code, mode, _ = set_up(program, given, stack_of_one(tables))
    if code != Status.COMPLETED:
        where, what = f"mode {system.mode_names[max(mode, 0)]!r}", SETUP_ERRORS[Status(code)]
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
) -> Outcome:
    """Run a plan from an anchor, or from a state at an instant; `NoMode` when none fits."""
    sizes = tables.sizes
    records = allocate_records(sizes, plan.sample_number, plan.sample_phase, FIRST_CAPACITY)
    segment = allocate_segment(sizes, max(0, derivatives.count))
    tangent = allocate_tangent(sizes, derivatives.count, plan.sample_phase.size)
    if anchor is None:
        assert state is not None
        anchor = allocate_anchor(sizes)
        anchor.place[0], anchor.phase[0] = begin
        anchor.state[:] = state
    else:
        mode = GOES_ON
        log_going_on(records, begin, anchor, state)
        records.since[:] = begin
    log = EventLog(keep_events)
    lane = (tables, derivatives.rates, derivatives.scratch, anchor, segment, tangent)
    windows = max(1, plan.end.number - int(anchor.place[0]))
    try:
        with HeldInterrupts() as held, Progress("simulating", windows) as progress:

            def report(done: int) -> None:
                progress.update(done)
                held.check()

            status, records = advance(lane, plan.end, records, log, tolerance, report, mode=mode)
    except KeyboardInterrupt:  # it came in the last call, whose results are kept too
        status = Status.INTERRUPTED
    if status == Status.INADMISSIBLE and records.cursor[at.EVENTS] == 0:
        raise NoMode(segment.z.copy())
    end = plan.end if status == Status.COMPLETED else last_instant(anchor, records)
    integers, floats = log.rows(records)
    return Outcome(
        status=status,
        tables=tables,
        columns=None if derivatives.chosen is None else tangent.samples,
        chosen=derivatives.chosen or (),
        plan=plan,
        anchor=anchor,
        records=records,
        n_samples=int(records.cursor[at.SAMPLES]),
        event_integers=integers,
        event_floats=floats,
        keeps_events=keep_events,
        n_events=log.n_left_out + len(integers) - 1,  # the first row is the start
        n_uncertain=int(records.cursor[at.UNCERTAIN]),
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
) -> tuple[Status, Records]:
    """Run to an instant, in chunks; ``report`` is told how many windows are done.

    ``mode`` says how the first chunk begins, see `run_lane`.
    """
    anchor = lane[3]
    first = int(anchor.place[0])
    windows = max(1, end.number - first)
    while True:
        done = int(anchor.place[0]) + _WINDOWS_PER_CALL
        stop = Instant(done, 0.0) if done < end.number else end
        try:
            status = Status(run(*lane, records, mode, *stop, tolerance))
        except KeyboardInterrupt:
            return Status.INTERRUPTED, records
        mode = GOES_ON
        if status == Status.BUFFER_FULL:
            records = log.make_room(records, (int(anchor.place[0]) - first) / windows)
        elif status != Status.PAUSED and (status != Status.COMPLETED or stop == end):
            return status, records
        try:
            report(int(anchor.place[0]) - first)
        except KeyboardInterrupt:
            return Status.INTERRUPTED, records


def last_instant(anchor: Anchor, records: Records) -> Instant:
    """Instant that a run has come to which ended early: an event, or the end of a call before."""
    reached = Instant(int(anchor.place[0]), float(anchor.phase[0]))
    if not np.all(np.isfinite(records.since)):
        return reached
    return max(reached, Instant(int(records.since[0]), float(records.since[1])))


def log_going_on(
    records: Records, begin: Instant, anchor: Anchor, state: npt.NDArray[np.float64] | None
) -> None:
    """Row of the event log for a run that goes on from an earlier one."""
    mode = anchor.place[1]
    row = [begin.number, EventKind.START, mode, mode, -1, 0, 0, 1, 1]
    records.event_integers[0] = row
    records.event_floats[0, : at.EVENT_FLOATS] = begin.phase, 0.0, 0.0
    if state is not None:
        records.event_floats[0, at.EVENT_FLOATS :] = np.concatenate([state, state])
    records.cursor[at.EVENTS] = 1
