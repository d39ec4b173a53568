"""How a record is taken: what is held back, where it is cut, and whether it repeats itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, is_known, quote
from nonsmooth.fitting.channels import ObservedChannel, Range
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.repetition import repeats_after
from nonsmooth.runs.options import whole_number
from nonsmooth.system.system import System

__all__ = ["FORMS", "Cut", "GivenRecord", "cut_for", "equations_of"]

Floats = npt.NDArray[np.float64]

FORMS = ("transient", "steady")
_PER_SEGMENT = 50  # samples, without a period
_PARTS = 4  # of a segment, with which the search begins
_MOST_UNKNOWNS = 480  # of all parts: a step of the solver decomposes a matrix of that size
_EVENTS = 1  # more than states, in a segment of a record that has events only
_SAME = 1e-12  # of a period: a difference that is rounding


class GivenRecord(NamedTuple):
    """A record with what is said of it."""

    label: str
    system: System  # with the parameters of this record
    channels: list[ObservedChannel]  # with all their data
    times: Floats  # of the samples


class Cut(NamedTuple):
    """Which part of a record is fitted, and into what it is cut."""

    held_back: float  # part at the end
    segments: int | None  # their number, where the caller gives it
    cycle: int | None  # periods after which a steady motion repeats itself
    length: float  # of the cycle


def cut_for(
    given: GivenRecord, free: Mapping[str, Range], form: Any, cycle: Any, segments: Any,
    held_back: float,
) -> Cut:  # fmt: skip
    """The cut of a record, as the caller wants it or as the data have it."""
    if form is not None and not is_known(form, FORMS):
        raise OptionError(f"form = {quote(form)}: give one of {', '.join(FORMS)}, or leave it out")
    number = None if cycle is None else whole_number("cycle", cycle)
    count = None if segments is None else whole_number("segments", segments)
    if form == "transient":
        if number is not None:
            raise OptionError(f"cycle = {number}: form='transient' has no cycle; leave one out")
        return Cut(held_back, count, None, np.nan)
    fault = _not_steady(given.system, free)
    if fault and (form == "steady" or number is not None):
        raise OptionError(f"form = 'steady': {fault}; give form='transient'")
    if fault:
        return Cut(held_back, count, None, np.nan)
    period = _period(given.system, free)
    assert period is not None
    if number is None:
        fitted, used = _fitted_part(given, held_back)
        number = repeats_after(fitted, given.times, period) if used.size else None
        if number is None and form == "steady":
            number = 1
    return Cut(held_back, count, number, np.nan if number is None else number * period)


def _not_steady(system: System, free: Mapping[str, Range]) -> str:
    """Why it is not known after which time a motion repeats itself; nothing where it is."""
    if system.drift_states:
        return f"{', '.join(system.drift_states)} may drift, so the motion need not come back"
    period = _period(system, free)
    if period is None:
        return (
            f"{system.name} has no period, so nothing says after which time the motion repeats"
            " itself"
        )
    for name, each in free.items():
        for value in (each.low, each.high):
            other = _period(system, {**free, name: Range(value, value, value)})
            if other is None or abs(other - period) > _SAME * period:
                return (
                    f"the period depends on {name!r}, which is in free=, so it is not known where"
                    " the motion repeats itself"
                )
    return ""


def _period(system: System, free: Mapping[str, Range]) -> float | None:
    """Period in the middle of the bounds, or where the system refuses that, its own."""
    middle = {name: each.guess for name, each in free.items()}
    try:
        return system.with_parameters(**middle).period_value
    except ModelError:
        return system.period_value


def equations_of(
    given: GivenRecord, free: Mapping[str, Range], shift: Range, cut: Cut, tolerance: float
) -> RecordEquations:
    """The equations of the part of a record that is fitted, cut into segments."""
    system = given.system
    fitted, used = _fitted_part(given, cut.held_back)
    for channel in fitted:
        _check_enough(given, channel, free)
    # an event at the very end of a run might be missed, so there is some time around the events
    spans = [(used[0], used[-1])] if used.size else []
    for each in fitted:
        if each.shows_events:
            kept, room = each.values[np.isfinite(each.values)], 0.5 * each.spread
            spans.append((kept[0] - room, kept[-1] + room))
    begin, end = min(low for low, _ in spans), max(high for _, high in spans)
    begin += shift.low - max(channel.delay.high for channel in fitted)
    end += shift.high - min(channel.delay.low for channel in fitted)
    if cut.cycle is not None:
        if end - begin < cut.length:
            raise OptionError(
                f"form = 'steady': what is fitted lasts {end - begin:.6g}, less than one cycle of"
                f" {cut.length:.6g}; give a longer record, or a smaller hold_back="
            )
        end = begin + cut.length
    number = _number(given, fitted, used, free, cut, end - begin)
    # picked events are told apart by the segment in which they are, so these stay
    may_change = cut.segments is None and not any(channel.shows_events for channel in fitted)
    together = _parts(number, used.size * len(fitted), len(system.states)) if may_change else 1
    bounds = np.linspace(begin, end, number * together + 1)
    for channel in fitted:
        if channel.shows_events:
            bounds = _between_events(bounds, channel.values - channel.delay.guess + shift.guess,
                                     cut)  # fmt: skip
    return RecordEquations(
        system, tuple(free), fitted, given.times, bounds, tolerance, shift,
        is_cycle=cut.cycle is not None, together=together, may_join=may_change,
    )  # fmt: skip


def _fitted_part(given: GivenRecord, held_back: float) -> tuple[list[ObservedChannel], Floats]:
    """Channels without what is held back, and the times of the samples that are left."""
    spans = [each for each in (given.times, *(c.values for c in given.channels if c.shows_events))
             if each.size]  # fmt: skip
    first, last = min(each[0] for each in spans), max(each[-1] for each in spans)
    last_kept = first + (1.0 - held_back) * (last - first)
    fitted = [
        channel._replace(
            values=np.where(
                (channel.values if channel.shows_events else given.times) <= last_kept,
                channel.values,
                np.nan,
            )
        )
        for channel in given.channels
    ]
    return fitted, given.times[given.times <= last_kept]


def _check_enough(given: GivenRecord, kept: ObservedChannel, free: Mapping[str, Range]) -> None:
    count = int(np.count_nonzero(np.isfinite(kept.values)))
    least = 2 if kept.shows_events else len(given.system.states) + len(free) + 2
    if count < least:
        where = f"record {given.label!r}, " if given.label else "record"
        raise OptionError(
            f"{where}[{kept.name!r}]: {count} {'events' if kept.shows_events else 'samples'} are"
            f" fitted, too few for {len(free)} parameters and {len(given.system.states)} states;"
            " give a longer record, or a smaller hold_back="
        )


def _number(
    given: GivenRecord, fitted: Sequence[ObservedChannel], used: Floats, free: Mapping[str, Range],
    cut: Cut, length: float,
) -> int:  # fmt: skip
    """Number of segments."""
    states = len(given.system.states)
    counts = [int(np.count_nonzero(np.isfinite(each.values))) for each in fitted]
    events = sum(count for count, each in zip(counts, fitted, strict=True) if each.shows_events)
    most = used.size // (4 * (states + 1)) if used.size else events // (states + _EVENTS)
    if cut.segments is not None:
        largest = max(used.size, events) // 2
        if cut.segments > largest:
            raise OptionError(
                f"segments = {cut.segments}: at most {largest}, half the"
                f" {'samples' if used.size else 'events'} that are fitted"
            )
        return cut.segments
    period = _period(given.system, free)
    number = used.size / _PER_SEGMENT if period is None else length / period
    if not used.size and period is None:
        number = most
    return int(np.clip(round(number), 1, max(1, most)))


def _parts(number: int, n_data: int, n_states: int) -> int:
    """Into how many parts each of some segments is cut at first, where the data allow it."""
    most = min(_MOST_UNKNOWNS // n_states, n_data // (2 * (n_states + 1)))
    return int(np.clip(most // number, 1, _PARTS))


def _between_events(bounds: Floats, events: Floats, cut: Cut) -> Floats:
    """Bounds moved into the middle between two picked events."""
    events = np.sort(events[np.isfinite(events)])
    if cut.cycle is not None:
        return bounds
    moved = bounds.copy()
    behind = np.searchsorted(events, bounds[1:-1])
    inside = (behind > 0) & (behind < events.size)
    here = np.flatnonzero(inside) + 1
    moved[here] = 0.5 * (events[behind[inside] - 1] + events[behind[inside]])
    if np.all(np.diff(moved) > 0.0):
        return moved
    return bounds
