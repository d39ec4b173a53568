"""The map of a section: what it is, which crossings count, how long to search."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from numbers import Real
from typing import Any

from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import ModelError, OptionError, is_known, quote, unknown_name
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import check_run_options, check_signals, finite_number, whole_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.section_search import SearchLimits, event_names
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.section import Section, section_names, with_section
from nonsmooth.system.system import System
from nonsmooth.system.text.grammar import is_name

__all__ = ["SectionMap", "folded_tables", "set_limits"]

_SIDES = ("before", "after")


@dataclass(frozen=True)
class SectionMap(Map):
    """The map from a section to itself, as the search for its points reads it."""

    system: System
    section: str
    _: KW_ONLY
    direction: int | None = None
    side: str = "before"
    every: int = 1

    def __post_init__(self) -> None:
        check_run_options(self.system, None, None, 1e-12)
        _refuse_slow(self.system)
        _, way = _read_section(self.system, self.section, self.direction)
        _check_side(self.side)
        object.__setattr__(self, "direction", way)
        object.__setattr__(self, "every", whole_number("every", self.every))
        _ = self.split  # refuses an expression that never changes

    @property
    def way(self) -> int:
        """Direction that counts, zero for both and for events."""
        assert self.direction is not None  # filled in when the map is made
        return self.direction

    @property
    def is_crossing(self) -> bool:
        """Whether the section is an expression and not an event."""
        return _read_section(self.system, self.section, self.direction)[0]

    @property
    def split(self) -> Section | None:
        """The system with the section in it; None where the section is an event."""
        return with_section(self.system, self.section) if self.is_crossing else None

    @property
    def reads_time(self) -> bool:
        """Whether time, or what depends on it, stands in the system or in the section."""
        split = self.split
        return is_driven(build_tables(self.system) if split is None else folded_tables(split))

    @property
    def protocol(self) -> dict[str, Any]:
        """What the map is, as attributes of a result."""
        return {
            "section": self.section,
            "section_kind": "crossing" if self.is_crossing else "event",
            "direction": self.way,
            "side": self.side,
            "every": self.every,
        }

    @property
    def points_have_time(self) -> bool:
        """Whether points of a system with a period lie at different phases of it."""
        return self.system.period_value is not None

    def check_states_suffice(self, verb: str) -> None:
        """Refuse a section where it also matters when the motion comes to it.

        Parameters
        ----------
        verb : str
            What asks, as the message names it.
        """
        if self.reads_time:
            raise OptionError(
                f"{verb}: the motion of {self.system.name!r} depends on time, so that it also"
                f" matters when it comes to section = {self.section!r}; take its StroboscopicMap"
            )


def _one_of(events: Iterable[str]) -> str:
    """Names of events, or that the system has none."""
    known = sorted(events)
    return f"one of {', '.join(known)}" if known else "of which this system has none"


def _refuse_slow(system: System) -> None:
    """A section belongs to a map that does not change from period to period."""
    if system.slow:
        raise OptionError(
            f"{system.name}: {', '.join(system.slow)} varies slowly, so the points would belong to"
            " a different map in each period; leave slow= out and give a fixed value, or take"
            " the events of a run of simulate"
        )


def _read_section(system: System, section: Any, direction: Any) -> tuple[bool, int]:
    """Whether a section is an expression and not an event, and the direction that counts."""
    if not isinstance(section, str) or not section.strip():
        raise OptionError(
            f"section = {quote(section)}: give an expression, such as {system.states[0]!r}, or the"
            " name of an event"
        )
    events = event_names(system)
    variables = section_names(system)
    crossing = section in variables or section not in events
    if crossing and is_name(section) and section not in variables:
        known = {*variables, *events} - {"pi"}
        if section in {kind.word for kind in EventKind}:
            raise OptionError(
                f"section = {section!r} is a kind of events; give the name of the exit, surface or"
                f" mode that is meant, {_one_of(events)}"
            )
        raise OptionError(f"section: {unknown_name('variable or event', section, known)}")
    if direction is None:
        return crossing, int(crossing)
    if (
        isinstance(direction, bool)
        or not isinstance(direction, Real)
        or direction not in (-1, 0, 1)
    ):
        raise OptionError(
            f"direction = {quote(direction)}: give 1 where the section grows, -1 where it falls, 0"
            " for both"
        )
    if direction and not crossing:
        raise OptionError(
            f"direction = {direction}: the event {section!r} has no direction; leave it out"
        )
    return crossing, int(float(direction))


def _check_side(side: Any) -> None:
    """Before or after."""
    if not is_known(side, _SIDES):
        raise OptionError(f"side = {quote(side)}: give 'before' or 'after'")


def set_limits(
    system: System, tables: Tables, start: Instant, transient: Any, record: int, t_end: Any
) -> SearchLimits:
    """From when on points count, and when to end the search."""
    window = tables.window
    length = finite_number("transient", transient)
    if length < 0.0:
        raise OptionError(f"transient = {length:g} must not be negative")
    if system.period_value is not None:
        whole = math.floor(length)
        begin = Instant(start.number + whole, start.phase + (length - whole) * window)
        if begin.phase >= window:
            begin = Instant(begin.number + 1, begin.phase - window)
    elif length == 0.0:
        begin = start
    else:
        begin = _instant(start.time(window) + length, window)
    end = None
    if t_end is not None:
        end = _instant(finite_number("t_end", t_end), window)
    elif system.signals:
        end = _instant(min(signal.span[1] for signal in system.signals.values()), window)
    last = begin if end is None else end
    if end is not None and not begin < end:
        raise OptionError(
            f"the search ends at t = {end.time(window):g} and points count from t ="
            f" {begin.time(window):g} on; give a later t_end= or a shorter transient="
        )
    check_signals(system, start.time(window), last.time(window))
    return SearchLimits(begin, record, end)


def _instant(time: float, window: float) -> Instant:
    number, phase = instants([time], window)
    return Instant(int(number[0]), float(phase[0]))


def folded_tables(split: Section) -> Tables:
    """Tables of a system with a section in it; errors speak of the system without."""
    try:
        return build_tables(split.system)
    except ModelError as fault:
        raise ModelError(split.folded(str(fault))) from None
