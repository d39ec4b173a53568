"""Points of one motion on a section, as a dataset."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.engine.tables import Tables
from nonsmooth.errors import ModelError, OptionError, RunWarning
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.misfit import explain_misfit
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.rates import Rates
from nonsmooth.runs.runner import NoMode, build_tables
from nonsmooth.runs.section_dataset import section_dataset
from nonsmooth.runs.section_options import set_limits
from nonsmooth.runs.section_rows import AT_ONCE, BehindStart, Crossings, NamedEvents
from nonsmooth.runs.section_search import Pick, Search, search, some_points, to_begin
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.system.section import Section
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.poincare_map import PoincareMap

__all__ = ["SectionStart", "folded_tables", "misfit", "start_on_section", "take_points"]


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
    chosen: PoincareMap, initial: Any, mode: str | None, t_start: float | None, repeated: bool
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
    chosen: PoincareMap,
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
    record = whole_number("record", record)
    motion = start_on_section(chosen, initial, mode, t_start, repeated)
    window = motion.given_tables.window
    protocol = chosen.protocol | {
        "transient": float(transient),
        "record": record,
        "tolerance": float(tolerance),
        "mode": mode or "",
        "t_start": motion.given.instant.time(window),
        "t_end": math.inf if t_end is None else float(t_end),
        "changed_parameters": changed,
    }
    tables, begin = motion.tables, motion.begin
    limits = set_limits(system, tables, begin.instant, transient, record * chosen.every, t_end)
    try:
        found = search(tables, begin, limits, tolerance, motion.pick)
    except NoMode:
        raise misfit(chosen, motion, tolerance) from None
    result = section_dataset(system, tables, _every(found, chosen.every), protocol)
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
    rates = Rates(system, tables).at(start.instant, start.modes[0], start.state)
    number, phase = start.instant.number, start.instant.phase - step
    if phase < 0.0:
        number, phase = number - 1, phase + window
    return replace(start, state=start.state - step * rates, instant=Instant(number, phase))


def _every(found: Search, every: int) -> Search:
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


def misfit(chosen: PoincareMap, motion: SectionStart, tolerance: float) -> OptionError:
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


def folded_tables(split: Section) -> Tables:
    """Tables of a system with a section in it; errors speak of the system without."""
    try:
        return build_tables(split.system)
    except ModelError as fault:
        raise ModelError(split.folded(str(fault))) from None


def _on_either_side(start: Start, split: Section, window: float, used: float) -> Start:
    """The same start for the system with a section, where each mode may have become several."""
    if start.anchor is not None:
        start = start_at_end(start)
    instant = start.instant
    if used != window:
        number, phase = instants([instant.time(window)], used)
        instant = Instant(int(number[0]), float(phase[0]))
    modes = start.modes
    if modes != (-1,):
        modes = tuple(int(i) for m in modes for i in np.flatnonzero(split.origin == m))
    return Start(start.state, instant, modes)
