"""Where a run with slow parameters starts: the first period and the values frozen in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nonsmooth.engine.tables import Tables
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.history import Frozen
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.start import Start, resolve_start
from nonsmooth.system.slow import SlowParameters

__all__ = ["resolve_slow_start"]

Make = Callable[[dict[str, float]], Tables]


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
