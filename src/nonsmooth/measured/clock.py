"""Times of samples: the even grid that they stand for, gaps, and where a sample stands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote
from nonsmooth.measured.csv_text import Table, cells_of
from nonsmooth.runs.options import finite_number

__all__ = [
    "FEWEST",
    "GAP",
    "LARGEST",
    "Clock",
    "FilePlaces",
    "Places",
    "check_finite",
    "clock_of",
    "lost_samples",
    "numbers",
    "usual_step",
]  # fmt: skip

Floats = npt.NDArray[np.float64]

LARGEST = 1e30  # a reading; codes for none are often larger still
FEWEST = 16  # samples
_ROUNDING = 1e-6  # of a step, that means over many times are off
_OFF = 0.1  # of a step, a time may be off the even grid
_BESIDE = 32  # samples on each side of a long step that say how many are lost
_CERTAIN = 4.0  # usual steps that no jitter makes
_LAG = 64  # samples between which steps are looked at, so that jitter counts little
GAP = 1.5  # usual steps are no gap yet


class Places:
    """Samples of arrays, numbered from 0."""

    note = " (samples from 0)"
    pulse = "pulse"  # what the signal of the marks is called

    def at(self, sample: int) -> str:
        """Where a sample stands."""
        return f"sample {sample}"

    def fault(self, variable: str, sample: int) -> str:
        """What stands in place of a number; of an array its time says enough."""
        return ""


@dataclass(frozen=True)
class FilePlaces(Places):
    """Samples of a file, by line and column."""

    note = ""
    pulse = "mark"
    table: Table
    columns: Mapping[str, int] = field(
        default_factory=dict
    )  # of each variable, of "time" and "mark", from 0

    def at(self, sample: int) -> str:
        """Line of a sample, from 1."""
        return f"line {self.table.row_lines[sample] + 1}"

    def fault(self, variable: str, sample: int) -> str:
        """The line, its column, and what stands there in place of a number."""
        cells = cells_of(self.table.lines[self.table.row_lines[sample]], self.table.delimiter)
        column = self.columns[variable]
        cell = cells[column] if column < len(cells) else ""
        what = f"holds {quote(cell)}, which is no finite number" if cell else "is missing"
        return f"{self.at(sample)}, {self.table.called(column)} {what}. "


def check_finite(
    arrays: Mapping[str, Floats], start: float, step: float, first: int, places: Places
) -> None:
    """Refuse gaps, and say where the first one is and which part of the record has none.

    first: number of the first sample, before a part was cut out
    """
    for name, values in arrays.items():
        with np.errstate(invalid="ignore"):
            large = np.isfinite(values) & (np.abs(values) > LARGEST)
        if large.any():
            k = int(np.argmax(large))
            raise OptionError(
                f"{name}: {values[k]:g} at t = {start + step * k:.7g} is beyond"
                f" {LARGEST:g} ({places.at(first + k)}{places.note}); what"
                " does the recorder write where it has no reading?"
            )
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size == 0:
            continue
        ends = np.concatenate([[-1], bad, [values.size]])
        k = int(np.argmax(np.diff(ends)))
        low, high = start + step * (ends[k] + 1), start + step * (ends[k + 1] - 1)
        raise OptionError(
            f"{places.fault(name, first + int(bad[0]))}{name}: {bad.size} samples are not finite,"
            f" the first at t = {start + step * bad[0]:.7g}; the longest part without a gap is"
            f" time_range=({low:.9g}, {high:.9g})"
        )


def numbers(name: str, values: Any) -> Floats:
    """Real samples in one dimension, or an error that names what they are."""
    try:
        given = np.asarray(values)
        found = np.array(given, dtype=float) if given.dtype.kind != "c" else None
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name} = {quote(values)}: give numbers") from None
    if found is None or found.ndim != 1 or found.size == 0:
        raise OptionError(f"{name}: give real samples in one dimension, one at least")
    return found


class Clock(NamedTuple):
    """Even times of the samples from ``first`` to before ``last``, and how far off they were."""

    start: float
    step: float
    off: float
    first: int
    last: int
    uneven: Floats | None = None  # the times themselves, where they are kept as they are

    @property
    def times(self) -> Floats:
        """Time of each sample that is kept."""
        if self.uneven is not None:
            return self.uneven
        return self.at(np.arange(self.last - self.first, dtype=np.float64))

    def at(self, places: Floats) -> Floats:
        """Times at some places, in samples from the first one that is kept."""
        if self.uneven is None:
            found: Floats = self.start + self.step * places
            return found
        return np.interp(places, np.arange(self.uneven.size), self.uneven)


def clock_of(
    times: Any, sample_rate: Any, count: int, time_range: Any, places: Places, keep: bool = False
) -> Clock:
    """Even times of the samples that are kept, by their times or their rate.

    keep: whether uneven times stay as they are, to be looked at
    """
    if (times is None) == (sample_rate is None):
        raise OptionError("give either the times= of the samples or their sample_rate=")
    low, high = (-math.inf, math.inf) if time_range is None else _two_times(time_range)
    if times is None:
        rate = finite_number("sample_rate", sample_rate)
        if rate <= 0.0:
            raise OptionError(f"sample_rate = {rate:g} must be positive, in samples per s")
        given = np.arange(count) / rate
    else:
        given = numbers("times", times)
        if given.size != count:
            raise OptionError(f"{given.size} times came for {count} samples")
    # what is outside the part that is kept does no harm; the rounding of a time neither
    slack = 1e-9 * max(abs(float(v)) for v in (low, high, 1.0) if math.isfinite(v))
    kept = np.flatnonzero((given >= low - slack) & (given <= high + slack))
    if time_range is not None and kept.size == 0:
        raise OptionError(
            f"time_range = ({low:g}, {high:g}) must run forward and meet the record, which covers"
            f" {np.nanmin(given):g} to {np.nanmax(given):g}"
        )
    first, last = (int(kept[0]), int(kept[-1]) + 1) if time_range is not None else (0, count)
    part = given[first:last]
    if not np.all(np.isfinite(part)):
        k = first + int(np.flatnonzero(~np.isfinite(part))[0])
        raise OptionError(
            f"{places.fault('time', k)}times: {places.at(k)} has no time{places.note}; give"
            " sample_rate= instead"
        )
    if times is None:
        return Clock(float(part[0]), 1.0 / rate, 0.0, first, last)
    if keep:
        return _kept_clock(part, first, last, places)
    return Clock(*_even_grid(part, first, places), first, last)


def _kept_clock(times: Floats, first: int, last: int, places: Places) -> Clock:
    """Even times where the given ones are even, and else the given ones."""
    try:
        return Clock(*_even_grid(times, first, places), first, last)
    except OptionError:
        if times.size < FEWEST:
            raise
    step = usual_step(times)
    if step < 0.0:
        raise OptionError(
            "times: most samples are earlier than the one before; put the rows in order of time"
        )
    if step == 0.0:
        raise OptionError(
            "times: most samples have the time of the one before; give sample_rate= instead"
        )
    off = float(np.abs(np.diff(times) / step - 1.0).max())
    return Clock(float(times[0]), step, off, first, last, times)


def usual_step(times: Floats) -> float:
    """Step of even times between their gaps: the slope of lines, one through each part.

    Times that are rounded to a few decimals have steps of two sizes only, of which the median is
    one. Where most times do not increase it is zero or negative.
    """
    steps = np.diff(times)
    low, middle, high = np.quantile(steps, (0.05, 0.5, 0.95))
    if middle <= 0.0:
        return float(middle)
    rough = float(steps[(steps >= low) & (steps <= high)].mean())
    lag = min(_LAG, times.size // 4)
    over = float(np.median(times[lag:] - times[:-lag])) / lag if lag else rough
    # a lag that gaps lengthen tells nothing
    rough = over if 0.0 < over < GAP * rough else rough
    apart = (lost_samples(times, rough) > 0) | (steps <= 0.0)
    part = np.concatenate([[0], np.cumsum(apart)])
    number = np.arange(times.size, dtype=float)
    size = np.bincount(part)
    from_mean = [v - (np.bincount(part, v) / size)[part] for v in (number, times - times[0])]
    square = float(from_mean[0] @ from_mean[0])
    return float(from_mean[0] @ from_mean[1]) / square if square > 0.0 else rough


def lost_samples(times: Floats, usual: float) -> npt.NDArray[np.int64]:
    """Samples that are lost in each step.

    Of a step of a few usual ones they are those by which times behind it stay late: by the
    median over the times on each side, up to the next step that is certain.
    """
    steps = np.diff(times) / usual
    certain = steps > _CERTAIN
    found = np.where(certain, np.round(steps) - 1.0, 0.0).astype(np.int64)
    parts = np.concatenate([[0], np.flatnonzero(certain) + 1, [times.size]])
    late = times / usual - np.arange(times.size)
    for k in np.flatnonzero((steps > GAP) & ~certain):
        part = int(np.searchsorted(parts, k, side="right"))
        before = late[max(k + 1 - _BESIDE, parts[part - 1]) : k + 1]
        behind = late[k + 1 : min(k + 1 + _BESIDE, parts[part])]
        found[k] = max(round(float(np.median(behind) - np.median(before))), 0)
    return found


def _even_grid(times: Floats, first: int, places: Places) -> tuple[float, float, float]:
    """The even grid closest to some times, refused where they are not even."""
    if times.size < FEWEST:
        raise OptionError(f"{times.size} samples are too few; {FEWEST} are needed at least")
    steps = np.diff(times)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        k = int(back[0])
        raise OptionError(
            f"times must increase, and {places.at(first + k + 1)} at {times[k + 1]:.9g} follows"
            f" {times[k]:.9g}{places.note}; are two records in one file, or"
            " times rounded too coarsely? For even samples give sample_rate= instead"
        )
    number = np.arange(times.size) - 0.5 * (times.size - 1)
    step = float(number @ (times - times.mean()) / (number @ number))
    start = float(times.mean() + step * number[0])
    if abs(start - times[0]) <= _ROUNDING * step:
        start = float(times[0])  # so that a record from 0 on begins there
    away = np.abs(times - (start + step * np.arange(times.size))) / step
    if away.max() > _OFF:
        k = int(np.argmax(steps))
        usual = usual_step(times)
        what = (
            f"the longest step, after {places.at(first + k)} at {times[k]:.9g}, is"
            f" {steps[k] / usual:.3g} usual ones"
        )
        raise OptionError(
            f"times are up to {away.max():.3g} steps off an even grid, allowed is {_OFF}; {what}."
            " Where samples were lost take a part without a gap by time_range=; resample uneven"
            " ones; where only the times are bad give sample_rate= instead"
        )
    return start, step, float(away.max())


def _two_times(time_range: Any) -> tuple[float, float]:
    try:
        low, high = (float(value) for value in time_range)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"time_range = {quote(time_range)}: give two times") from None
    return low, high
