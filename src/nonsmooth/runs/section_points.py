"""Points of one motion on a section, as a dataset."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from nonsmooth.engine.status import CURES, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, RunWarning
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.first_mode import explain_misfit
from nonsmooth.runs.labels import labels_of, with_doubts
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.outputs import SampleClock, StateRates, output_values
from nonsmooth.runs.runner import NoMode, build_tables
from nonsmooth.runs.section_map import SectionMap, folded_tables, set_limits
from nonsmooth.runs.section_search import (
    AT_ONCE,
    PATIENCE,
    BehindStart,
    Crossings,
    NamedEvents,
    Pick,
    SectionPoints,
    SectionSearch,
    joined_points,
    search,
    some_points,
    to_begin,
)
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.system.section import Section
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["SectionStart", "misfit", "start_on_section", "take_points"]


_ROUNDING = 1e-15  # of a period
_WAYS = {1: "upward", -1: "downward", 0: "in either direction"}


class SectionStart(NamedTuple):
    """Where a motion begins whose points on a section are wanted.

    ``tables`` and ``begin`` belong to the system with the section in it, which is the system
    itself where the section is an event; ``given`` is the start in the system itself.
    """

    tables: Tables
    begin: Start
    pick: Pick
    given: Start
    given_tables: Tables


def start_on_section(
    chosen: SectionMap, initial: Any, mode: str | None, t_start: float | None, repeated: bool
) -> SectionStart:
    """Start of a motion, and what finds its points."""
    system, split = chosen.system, chosen.split
    tables = build_tables(system)
    start = resolve_start(system, tables, initial, t_start, mode, repeated)
    window = tables.window
    if split is None:
        begin = start
        if _is_at_event(initial):
            begin = just_before(system, tables, start)
        events = NamedEvents(system, chosen.section)
        pick = BehindStart(events, begin.instant, window)
        return SectionStart(tables, begin, pick, start, tables)
    used = folded_tables(split)
    begin = _on_either_side(start, split, window, used.window)
    crossings = Crossings(split, used, chosen.way)
    pick = BehindStart(crossings, begin.instant, used.window)
    return SectionStart(used, begin, pick, start, tables)


def take_points(
    chosen: SectionMap,
    initial: Any,
    *,
    transient: float,
    record: Any,
    tolerance: float,
    mode: str | None,
    t_start: float | None,
    t_end: float | None,
    changed: str = "",
    repeated: bool = True,
) -> xr.Dataset:
    """Dataset of the points of one motion; a warning where there are too few.

    ``changed`` tells of parameters that were changed for this motion, ``repeated`` that they were
    given again to go on from a run made with some.
    """
    system = chosen.system
    record, tolerance = whole_number("record", record), finite_number("tolerance", tolerance)
    left_out = finite_number("transient", transient)
    last = math.inf if t_end is None else finite_number("t_end", t_end)
    motion = start_on_section(chosen, initial, mode, t_start, repeated)
    window = motion.given_tables.window
    protocol = chosen.protocol | {
        "transient": left_out,
        "record": record,
        "tolerance": tolerance,
        "mode": mode or "",
        "t_start": motion.given.instant.time(window),
        "t_end": last,
        "changed_parameters": changed,
    }
    tables, begin = motion.tables, motion.begin
    limits = set_limits(system, tables, begin.instant, transient, record * chosen.every, t_end)
    try:
        found = search(tables, begin, limits, tolerance, motion.pick)
    except NoMode:
        raise misfit(chosen, motion, tolerance) from None
    result = _section_dataset(system, tables, _every(found, chosen.every), protocol)
    if not result.attrs["message"].startswith("completed"):
        # told where the user calls the verb or method that calls this
        warnings.warn(f"{system.name}: {result.attrs['message']}", RunWarning, stacklevel=3)
    return result


def _is_at_event(initial: Any) -> bool:
    """Whether a start is a point just before an event, up to rounding perhaps beyond its guard."""
    attrs = getattr(initial, "attrs", {})
    return attrs.get("section_kind") == "event" and attrs.get("side") == "before"


def just_before(system: System, tables: Tables, start: Start) -> Start:
    """The same motion a little earlier, by less than a point must be behind a start."""
    if start.modes == (-1,):
        return start
    window = tables.window
    step = 0.1 * AT_ONCE * window
    rates = StateRates(system, tables).at(start.instant, start.modes[0], start.state)
    number, phase = start.instant.number, start.instant.phase - step
    if phase < 0.0:
        number, phase = number - 1, phase + window
    return replace(start, state=start.state - step * rates, instant=Instant(number, phase))


def _every(found: SectionSearch, every: int) -> SectionSearch:
    """One of so many points."""
    if every == 1:
        return found
    parts, passed = [], 0
    for part in found.parts:
        size = part.number.size
        here = np.arange((every - 1 - passed) % every, size, every)
        parts.append(some_points(part, here))
        passed += size
    return replace(found, parts=parts, n_points=passed // every)


def misfit(chosen: SectionMap, motion: SectionStart, tolerance: float) -> OptionError:
    """Why no mode admits a start: the system, or a section that is not smooth there."""
    given = motion.given
    try:
        to_begin(motion.given_tables, given, given.instant, tolerance)
    except NoMode as fault:
        return OptionError(explain_misfit(chosen.system, motion.given_tables, given, fault.z))
    return OptionError(
        f"section = {chosen.section!r}: at the start it has no finite value or derivative; start a"
        " little beside, or write it without what is singular there, such as x**2 + y**2 - 1 in"
        " place of sqrt(x**2 + y**2) - 1"
    )


def _on_either_side(start: Start, split: Section, window: float, used: float) -> Start:
    """The same start for the system with a section, where each mode may have become several."""
    start = start_at_end(start)
    instant = start.instant
    if used != window:
        number, phase = instants([instant.time(window)], used)
        instant = Instant(int(number[0]), float(phase[0]))
    modes = start.modes
    if modes != (-1,):
        modes = tuple(int(i) for m in modes for i in np.flatnonzero(split.origin == m))
    return Start(start.state, instant, modes)


def _within_periods(points: SectionPoints, window: float) -> SectionPoints:
    """Points that come with the end of a period, to rounding, at the begin of the next one."""
    ended = points.phase >= window * (1.0 - _ROUNDING)
    number = points.number + ended
    return replace(points, number=number, phase=np.where(ended, 0.0, points.phase))


def _section_dataset(
    system: System, tables: Tables, found: SectionSearch, protocol: dict[str, Any]
) -> xr.Dataset:
    """Dataset over ``point`` from what a search has found."""
    labels = labels_of(system)
    points = _within_periods(joined_points(found.parts, len(system.states)), tables.window)
    side = 0 if protocol["side"] == "before" else 1
    states, modes = points.states[side].T.copy(), points.modes[side]
    clock = SampleClock(points.number, points.phase, tables)
    columns = dict(zip(system.states, states, strict=True))
    columns |= output_values(system, clock, states, modes)
    variables: dict[str, Any] = {
        name: ("point", values, labels.attributes(name)) for name, values in columns.items()
    }
    words = labels.mode_flags(f"mode just {protocol['side']}")
    variables["mode"] = ("point", modes.astype(labels.mode_type), words)
    if protocol["section_kind"] == "crossing":
        words = {"long_name": "1 where the section grows, -1 where it falls"}
        variables["direction"] = ("point", points.direction.astype("int8"), words)
    words = {"long_name": "whether neither rounding nor an estimate leaves a doubt about the point"}
    variables["certified"] = ("point", points.certified, words)
    coords: dict[str, Any] = {"time": ("point", clock.time, labels.attributes("time"))}
    if system.period_value is not None:
        words = {"long_name": "whole periods before the point"}
        coords["period_number"] = ("point", points.number, words)
        words = {"long_name": "time since the period began"}
        coords["phase"] = ("point", points.phase, words)
    return xr.Dataset(variables, coords, _attributes(system, tables, found, protocol))


def _attributes(
    system: System, tables: Tables, found: SectionSearch, protocol: dict[str, Any]
) -> dict[str, Any]:
    end = found.instant.time(tables.window)
    attrs = {
        "system_name": system.name,
        "system": labels_of(system).system,
        "nonsmooth_version": __version__,
        "status": _status(found),
        "message": _message(found, protocol, end),
        "certified": int(found.n_uncertain == found.n_estimated == 0),
        "n_points": found.n_points,
        "n_uncertain": found.n_uncertain,
        "n_estimated": found.n_estimated,
        "n_grazes": found.n_grazes,
        "end_time": end,
    }
    if system.period_value is not None:
        attrs["period"] = system.period_value
    return attrs | protocol


def _status(found: SectionSearch) -> str:
    if found.at_rest:
        return "at_rest"
    return "time_limit" if found.gave_up else found.status.word


def _message(found: SectionSearch, protocol: dict[str, Any], end: float) -> str:
    """What became of the search, and what to do where it found less than was asked for."""
    status, count, record = found.status, found.n_points, protocol["record"]
    few = f"{count} of {record} points until t = {end:.9g}"
    if found.at_rest:
        return (
            f"{few}; there the motion comes to rest on the section, as far as rounding tells: the"
            " points that are not certified mean nothing"
        )
    if status != Status.COMPLETED:
        return f"{status.word} at t = {end:.9g}, {count} of {record} points: {CURES[status]}"
    if count == record or (count and protocol["t_end"] < np.inf):
        return with_doubts(status.word, found.n_uncertain, found.n_estimated)
    reason = f"; none came in the last {PATIENCE} periods or windows" if found.gave_up else ""
    if count:
        return f"{few}{reason}; does the motion come to rest, or leave the section?"
    name = protocol["section"]
    if protocol["section_kind"] == "event":
        return f"{few}{reason}; no event {name!r} came: draw the motion, or give a later t_end="
    if found.n_grazes:
        return (
            f"{few}; the motion touches section = {name!r} {found.n_grazes} times, within rounding"
            " of crossing it: move the section a little into the motion"
        )
    way = _WAYS[protocol["direction"]]
    return (
        f"{few}{reason}; nothing crosses section = {name!r} {way}: draw the motion"
        " with simulate, move the section into it, or give direction=0 or a later t_end="
    )
