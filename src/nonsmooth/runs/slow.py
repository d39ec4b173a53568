"""Runs with slowly varying parameters: one period after the other, each with frozen values.

At the beginning of a period the tables are set up for the new values, and the run goes on
in its mode at phase zero: slaved states take the values of their relations, and exits whose
guards the change has made negative fire at once. So the phase of the forcing is continuous,
also where its frequency changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    ANY,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
)
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.runs.clock import Instant, Plan, instants
from nonsmooth.runs.event_log import FIRST_CAPACITY, EventLog
from nonsmooth.runs.history import Frozen
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.progress import HeldInterrupts, Progress
from nonsmooth.runs.runner import UNLIMITED, NoMode, Outcome, WorkLimits, last_instant, log_going_on
from nonsmooth.runs.slow_plan import SlowPlan
from nonsmooth.runs.slow_run import SlowRun
from nonsmooth.runs.start import Start, resolve_start
from nonsmooth.system.slow import SlowParameters

__all__ = ["check_slow_tangent", "resolve_slow_start", "run_slow"]

Make = Callable[[dict[str, float]], Tables]

_NOTHING = np.empty(0, np.int64), np.empty(0)


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
    run = SlowRun(
        slow, chosen, tolerance,
        anchor=start.anchor or allocate_anchor(sizes),
        segment=allocate_segment(sizes, max(0, n_chosen)),
        tangent=allocate_tangent(sizes, n_chosen, 0),
        records=allocate_records(sizes, *_NOTHING, FIRST_CAPACITY),
        log=EventLog(keep_events),
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
    run: SlowRun, status: Status, end: Instant | None, times: npt.NDArray[np.float64] | None
) -> Outcome:
    if status == Status.REFUSED:
        end = Instant(run.history.last.number + 1, 0.0)
    elif end is None or status != Status.COMPLETED:
        end = last_instant(run.anchor, run.records)
    arrays = [_joined(run, i) for i in range(5)]
    records = run.records.replace(
        sample_number=arrays[0],
        sample_phase=arrays[1],
        sample_state=arrays[2],
        sample_mode=arrays[3],
    )
    rows, states = run.log.rows(run.records)
    return Outcome(
        status=status,
        tables=run.tables,
        columns=None if run.chosen is None else arrays[4],
        chosen=run.chosen or (),
        plan=Plan(end, arrays[0], arrays[1], times),
        anchor=run.anchor,
        records=records,
        n_samples=arrays[0].size,
        events=rows,
        event_states=states,
        keeps_events=run.log.keep,
        n_events=run.log.n_left_out + len(rows) - 1,  # the first row is the start
        n_uncertain=int(run.records.counters["uncertain"]),
        n_estimated=int(run.records.counters["estimated"]),
        end=end,
        history=run.history,
    )


def _joined(run: SlowRun, i: int) -> npt.NDArray[Any]:
    """Samples of all periods."""
    empty = (run.records.sample_number, run.records.sample_phase, run.records.sample_state,
             run.records.sample_mode, run.tangent.samples)[i][:0]  # fmt: skip
    return np.concatenate([empty, *(piece[i] for piece in run.pieces)])
