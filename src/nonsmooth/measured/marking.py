"""Marks of a record, one per revolution: given, or told from a pulse; the speed by them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.measured.clock import Clock, Places, check_finite, numbers
from nonsmooth.runs.options import finite_number

__all__ = ["Marking", "check_marked", "faulty_marks", "marks_of", "speed_attributes"]

Floats = npt.NDArray[np.float64]

_FEWEST = 3  # marks: two revolutions, which may differ
_NEIGHBOURS = 11  # revolutions by whose median one is judged
_SHORT, _LONG = 2.0 / 3.0, 1.5  # of that median
_STRAIGHT = 1e-9  # of a sample, a bend of an edge that is rounding
_TOLD = 4  # faults named in a message


def speed_attributes(marks: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Mean speed in radians per unit time, its spread over revolutions, number of marks."""
    single = 2.0 * math.pi / np.diff(marks)
    mean = 2.0 * math.pi * (marks.size - 1) / float(marks[-1] - marks[0])
    spread = float(np.sqrt(np.mean((single - mean) ** 2)))
    return {"speed": mean, "speed_spread": spread, "n_marks": int(marks.size)}


class _Edges(NamedTuple):
    """Places of marks in samples, and how far off sampling may have put one."""

    places: Floats
    error: float


def _find_edges(pulse: Floats, threshold: Any, hysteresis: Any, edge: Any) -> _Edges:
    """Edges of a pulse train in samples from the first one, between samples by a straight line.

    The signal must go from below the band of width ``hysteresis`` about the threshold to above
    it; the edge is where it last passed the threshold on that way.
    """
    if not is_known(edge, ("rising", "falling")):
        raise OptionError(f"edge = {quote(edge)}: give 'rising' or 'falling'")
    low, high = float(pulse.min()), float(pulse.max())
    if low == high:
        raise OptionError(
            f"the mark channel is {low:g} throughout, so there are no marks; is it the right"
            " column?"
        )
    level = 0.5 * (low + high) if threshold is None else finite_number("threshold", threshold)
    width = 0.2 * (high - low) if hysteresis is None else finite_number("hysteresis", hysteresis)
    if width < 0.0:
        raise OptionError(f"hysteresis = {width:g} must not be negative")
    if not low < level - 0.5 * width <= level + 0.5 * width < high:
        raise OptionError(
            f"threshold = {level:g} with hysteresis = {width:g}: the band from"
            f" {level - 0.5 * width:g} to {level + 0.5 * width:g} must lie within the mark channel,"
            f" which goes from {low:g} to {high:g}"
        )
    signed = pulse - level if edge == "rising" else level - pulse
    side = np.where(signed > 0.5 * width, 1, np.where(signed < -0.5 * width, -1, 0))
    known = np.maximum.accumulate(np.where(side != 0, np.arange(side.size), 0))
    side = side[known]
    above = np.flatnonzero((side[1:] == 1) & (side[:-1] == -1)) + 1
    below = np.maximum.accumulate(np.where(signed < 0.0, np.arange(signed.size), 0))
    last = below[above - 1]  # the last sample below the threshold on the way up
    share = -signed[last] / (signed[last + 1] - signed[last])
    return _Edges(last + share, _sampling_error(signed, last, share))


def _sampling_error(signed: Floats, last: npt.NDArray[np.int64], share: Floats) -> float:
    """How far off edges may be, in samples.

    An edge that bends one way lies between the line through the two samples about it and the
    lines through the two before and the two after, prolonged. Where those are flat, as about an
    edge within one sample, it may be anywhere between the two.
    """
    if share.size == 0:
        return 0.0
    before = signed[last] - signed[np.maximum(last - 1, 0)]
    after = signed[np.minimum(last + 2, signed.size - 1)] - signed[last + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        from_before = np.where(before > 0.0, -signed[last] / before, 1.0)
        from_after = np.where(after > 0.0, 1.0 - signed[last + 1] / after, 0.0)
    ends = np.clip([from_before, from_after], 0.0, 1.0)
    found = float(np.abs(ends - share).max())
    return found if found > _STRAIGHT else 0.0


def _given_marks(marks: Any) -> Floats:
    """Times of marks given by the caller."""
    try:
        times = np.asarray(marks, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"marks = {quote(marks)}: give the times of the marks") from None
    if times.ndim != 1 or not np.all(np.isfinite(times)):
        raise OptionError("marks: give times in one dimension, all of them finite")
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if back.size:
        k = int(back[0])
        raise OptionError(
            f"marks must increase, and mark {k + 1} at {times[k + 1]:.9g} follows mark {k} at"
            f" {times[k]:.9g} (from 0)"
        )
    return times


def _check_marks(
    times: Floats, bad_marks: Any, arrays: Mapping[str, Floats], clock: Clock
) -> tuple[Floats, int]:
    """Marks one per revolution, and how many were repaired; refused where one is bad.

    arrays: samples of the channels, by which a recorder is told that stood still
    """
    if not is_known(bad_marks, ("refuse", "repair", "keep")):
        raise OptionError(
            f"bad_marks = {quote(bad_marks)}: give 'refuse' or 'repair', or 'keep' to look at them"
        )
    if times.size < _FEWEST:
        raise OptionError(
            f"{times.size or 'no'} marks lie within the record, and {_FEWEST} are needed at least;"
            " take a longer record, or look at threshold= and hysteresis="
        )
    if bad_marks == "keep":
        return times, 0
    kept, count = _repaired(times, arrays, clock) if bad_marks == "repair" else (times, 0)
    doubled, missed = faulty_marks(kept)
    if not (doubled or missed):
        return kept, count
    told = [f"a double one at t = {kept[k]:.7g} (mark {k})" for k in doubled[:_TOLD]]
    told += [
        f"{n} missing between t = {kept[k]:.7g} and {kept[k + 1]:.7g} (after mark {k})"
        for k, n in missed[:_TOLD]
    ]
    more = len(doubled) + len(missed) - len(told)
    raise OptionError(
        f"the marks are not one per revolution: {'; '.join(told)}"
        + (f"; and {more} more" if more else "")
        + ". A revolution may last from 2/3 to 3/2 of the median of its neighbours. "
        + (
            "This cannot be repaired; read the part of the record without it by time_range="
            if bad_marks == "repair"
            else "Look at threshold= and hysteresis=, or give bad_marks='repair' to leave double"
            " ones out and to put missing ones in evenly"
        )
    )


def _usual(intervals: Floats) -> Floats:
    """Length of a revolution about each interval; a few bad ones do not change a median."""
    from scipy.ndimage import median_filter

    size = min(_NEIGHBOURS, intervals.size | 1)
    usual: Floats = median_filter(intervals, size=size, mode="nearest")
    return usual


def faulty_marks(times: Floats) -> tuple[list[int], list[tuple[int, int]]]:
    """Marks that are one too many, and after which marks how many are missing."""
    intervals = np.diff(times)
    usual = _usual(intervals)
    doubled: list[int] = []
    for k in np.flatnonzero(intervals < _SHORT * usual).tolist():
        if k in doubled:  # the other side of the same mark
            continue
        # the one without which its neighbours are a revolution apart
        without_first = times[k + 1] - times[k - 1] if k > 0 else np.inf
        without_second = times[k + 2] - times[k] if k + 2 < times.size else np.inf
        first = abs(without_first - usual[k]) < abs(without_second - usual[k])
        doubled.append(k if first else k + 1)
    missed = [
        (k, max(1, round(intervals[k] / usual[k]) - 1))
        for k in np.flatnonzero(intervals > _LONG * usual).tolist()
    ]
    return sorted(set(doubled)), missed


def _repaired(times: Floats, arrays: Mapping[str, Floats], clock: Clock) -> tuple[Floats, int]:
    """Marks without the double ones, the missing ones put in evenly."""
    doubled, _ = faulty_marks(times)
    kept = np.delete(times, doubled)
    if kept.size < _FEWEST:
        return times, 0
    _, missed = faulty_marks(kept)
    if missed:
        _check_moving(kept, missed, arrays, clock)
    put_in = [kept[k] + (kept[k + 1] - kept[k]) * np.arange(1, n + 1) / (n + 1) for k, n in missed]
    return np.sort(np.concatenate([kept, *put_in])), len(doubled) + sum(n for _, n in missed)


def _check_moving(
    marks: Floats, missed: list[tuple[int, int]], arrays: Mapping[str, Floats], clock: Clock
) -> None:
    """Refuse to put marks in where all channels stand still: nobody knows how many are missing.

    A turn counts as standing still where all channels keep their values for half of it.
    """
    times = clock.times
    still = np.ones(times.size - 1, dtype=bool)
    for values in arrays.values():
        still &= np.diff(values) == 0.0
    changes = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    begins, ends = times[changes[::2]], times[changes[1::2]]
    for k, count in missed:
        within = np.minimum(ends, marks[k + 1]) - np.maximum(begins, marks[k])
        usual = (marks[k + 1] - marks[k]) / (count + 1)
        if within.size and within.max() > 0.5 * usual:
            j = int(np.argmax(within))
            raise OptionError(
                f"{count} marks are missing between t = {marks[k]:.7g} and {marks[k + 1]:.7g}, and"
                f" all channels stand still from t = {begins[j]:.7g} to {ends[j]:.7g}: the recorder"
                " may have stopped, and turns put in there would be invented. Read the part before"
                f" it, time_range=({times[0]:.7g}, {marks[k]:.7g}), or that behind it,"
                f" time_range=({marks[k + 1]:.7g}, {times[-1]:.7g})"
            )


class Marking(NamedTuple):
    """What the caller says of marks; neither ``marks`` nor ``pulse`` where there are none."""

    marks: Any = None
    pulse: Any = None
    threshold: Any = None
    hysteresis: Any = None
    edge: Any = "rising"
    bad_marks: Any = "refuse"


def marks_of(
    given: Marking, clock: Clock, places: Places, arrays: Mapping[str, Floats]
) -> tuple[Floats, dict[str, Any]] | None:
    """Marks within a record and the attributes they give it; None without any.

    arrays: the channels of the record
    """
    start, step, first, last = clock.start, clock.step, clock.first, clock.last
    if given.marks is not None and given.pulse is not None:
        raise OptionError("give the marks of revolutions by either marks= or pulse=")
    if given.marks is not None:
        found, error = _given_marks(given.marks), 0.0
        end = float(clock.at(np.array([last - first - 1.0]))[0])
        found = found[(found >= start) & (found <= end)]
    elif given.pulse is not None:
        signal = numbers(places.pulse, given.pulse)
        if signal.size < last:
            raise OptionError(
                f"{places.pulse}: {signal.size} samples came, and displacements have more"
            )
        signal = signal[first:last]
        if given.bad_marks == "keep":
            signal = _held(signal)
        check_finite({places.pulse: signal}, start, step, first, places)
        edges = _find_edges(signal, given.threshold, given.hysteresis, given.edge)
        found, error = clock.at(edges.places), step * edges.error
    else:
        _check_unused(given)
        return None
    kept, repaired = _check_marks(found, given.bad_marks, arrays, clock)
    return kept, {**speed_attributes(kept), "mark_error": error, "n_repaired": repaired}


def _held(signal: Floats) -> Floats:
    """A pulse whose missing samples are as the last one before."""
    good = np.isfinite(signal)
    last = np.maximum.accumulate(np.where(good, np.arange(signal.size), 0))
    return np.where(good, signal, signal[last])


def check_marked(record: xr.Dataset, what: str) -> None:
    """Refuse a record without marks where they are needed, and say how to give them."""
    if "mark_time" not in record.coords:
        raise OptionError(
            f"the record has no marks of revolutions, and {what} needs them; read it with mark=,"
            " the column of a pulse per revolution (pulse= in from_arrays), or with marks=, their"
            " times, such as multiples of the period of the forcing"
        )


def _check_unused(given: Marking) -> None:
    """Refuse options about marks that are not there: they would be passed over in silence."""
    for name, default in Marking._field_defaults.items():
        value = getattr(given, name)
        if not isinstance(value, str | float | int | None) or value != default:
            raise OptionError(
                f"{name}= is about marks of revolutions, and none came; give mark=, the column of a"
                " pulse in a file; or of arrays the signal of the pulse, or the times of the marks"
            )
