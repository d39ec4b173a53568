"""Curves of a run: samples merged with the states at events, cut to a range, thinned.

Nothing is simulated here; between two known points a curve is straight.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.clock import rounding_of_logged

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "DENSE",
    "Trace",
    "broken",
    "check_log",
    "check_range",
    "check_variables",
    "curve",
    "thinned",
]

Floats = npt.NDArray[np.float64]

DENSE = 20_000  # points of one curve above which it is thinned or drawn as an image
_INSTANT = 1e-12  # part of a run that is no time
_COLUMNS = 2_000  # pixel columns: 8 cm at 600 dots per inch are 1890


class Trace(NamedTuple):
    """Points of a curve in order of time.

    ``mode`` is the mode on the way to the next point; ``jumps`` says that this way takes no
    time: from the state just before an event to the one just after.
    """

    time: Floats
    values: Floats  # (variable, time)
    mode: npt.NDArray[np.int64]
    jumps: npt.NDArray[np.bool_]

    def take(self, index: Any) -> Trace:
        """Some of the points."""
        return Trace(self.time[index], self.values[:, index], self.mode[index], self.jumps[index])


def check_variables(run: xr.Dataset, variables: str | Sequence[str]) -> list[str]:
    """Names of variables over time; an unknown one is an error that lists the known ones."""
    if "time" not in run.dims:
        raise OptionError(
            "the dataset has no dimension 'time'; give it a run of simulate, or a measured motion"
        )
    names = [variables] if isinstance(variables, str) else list(variables)
    known = [str(v) for v in run.data_vars if run[v].dims == ("time",) and v not in ("mode", "leg")]
    if not names:
        raise OptionError(f"variables: name at least one of {', '.join(known)}")
    for name in names:
        if name not in known:
            raise OptionError(unknown_name("variable", name, known))
    if run.sizes["time"] == 0:
        raise OptionError("the run has no samples to draw; see its attribute 'message'")
    return names


def check_log(run: xr.Dataset) -> None:
    """The run has kept its event log."""
    if "event_time" not in run:
        raise OptionError("the run has no event log to draw; simulate without events=False")


def check_range(
    run: xr.Dataset, time_range: tuple[float, float] | None
) -> tuple[float, float] | None:
    """Two times in order that meet the run."""
    if time_range is None:
        return None
    try:
        low, high = (float(value) for value in time_range)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(
            f"time_range = {quote(time_range)}: give two times, such as (800, 1200)"
        ) from None
    first, last = float(run["time"][0]), float(run["time"][-1])
    if not (low < high and low < last and high > first):
        raise OptionError(
            f"time_range = ({low:g}, {high:g}) must run forward and meet the run, which"
            f" covers {first:g} to {last:g}"
        )
    return low, high


def curve(
    run: xr.Dataset, names: Sequence[str], time_range: tuple[float, float] | None = None
) -> Trace:
    """Curve of some variables on common times.

    States have the points just before and just after each event among their samples, so
    kinks and jumps stand at their exact place. Outputs are known at samples only; where one
    of the names is an output, all of them are taken there. A measured motion has neither modes
    nor events.
    """
    measured = "mode" not in run
    mode = (
        np.zeros(run.sizes["time"], np.int64) if measured else run["mode"].values.astype(np.int64)
    )
    samples = np.stack([run[name].values.astype(float) for name in names])
    trace = Trace(run["time"].values.astype(float), samples, mode, np.zeros(mode.size, bool))
    if "leg" in run:  # samples of each leg from end to end: nothing is between them
        time = trace.time
        jumps = (np.diff(run["leg"].values) != 0) & (np.diff(time) <= _INSTANT * np.ptp(time))
        trace = trace._replace(jumps=np.append(jumps, False))
        return trace if time_range is None else _cut(trace, *time_range)
    states = [] if measured else [str(name) for name in run["state"].values]
    if run.sizes.get("event") and all(name in states for name in names):
        trace = _merged(run, trace, [states.index(name) for name in names])
    return trace if time_range is None else _cut(trace, *time_range)


def _merged(run: xr.Dataset, samples: Trace, columns: list[int]) -> Trace:
    """Samples with two points per event among them."""
    if samples.time.size != run.attrs.get("n_samples", samples.time.size):
        # a part of a run, cut out by its samples, still has the events of all of it
        when = run["event_time"].values
        run = run.isel(event=(when >= samples.time[0]) & (when <= samples.time[-1]))
        if run.sizes["event"] == 0:
            return samples
    count = 2 * run.sizes["event"]
    time = np.repeat(run["event_time"].values.astype(float), 2)
    values = np.empty((len(columns), count))
    mode = np.empty(count, np.int64)
    for k, side in enumerate(("before", "after")):
        values[:, k::2] = run[f"state_{side}"].values[:, columns].T
    mode[0::2], mode[1::2] = run["event_from"].values, run["event_to"].values
    jumps = np.arange(count) % 2 == 0
    # A sample at the time of an event, or behind it by rounding, holds the state before it, but at
    # the start the state after it.
    latest = np.maximum.accumulate(time + np.repeat(rounding_of_logged(run), 2))
    place = np.searchsorted(latest, samples.time, side="left")
    if run["event_kind"].values[0] == "start":
        place = np.where(samples.time <= time[0], 2, place)
    return Trace(
        np.insert(time, place, samples.time),
        np.insert(values, place, samples.values, axis=1),
        np.insert(mode, place, samples.mode),
        np.insert(jumps, place, samples.jumps),
    )


def _cut(trace: Trace, low: float, high: float) -> Trace:
    """The part between two times, with a point of the straight line at either end."""
    parts = [trace.take((trace.time >= low) & (trace.time <= high))]
    for end in (low, high):
        k = int(np.searchsorted(trace.time, end))  # the point at or after the end
        if k == 0 or k == trace.time.size or trace.time[k] == end:
            continue
        share = (end - trace.time[k - 1]) / (trace.time[k] - trace.time[k - 1])
        point = trace.take([k - 1])
        step = trace.values[:, [k]] - point.values
        point = point._replace(time=np.array([end]), values=point.values + share * step)
        parts.insert(0 if end == low else len(parts), point)
    time, values, mode, jumps = zip(*parts, strict=True)
    return Trace(
        np.concatenate(time),
        np.concatenate(values, axis=1),
        np.concatenate(mode),
        np.concatenate(jumps),
    )


def broken(values: Floats, ways: npt.NDArray[np.bool_]) -> Floats:
    """Points at either end of some ways to the next point, with a gap after each chain."""
    ways = np.append(ways[:-1], False)  # no way leads on from the last point
    kept = ways | np.append(False, ways[:-1])
    last = np.flatnonzero(kept & ~ways)
    points = values[:, kept]
    # where the chains end among the points kept
    ends = np.searchsorted(np.flatnonzero(kept), last) + 1
    return np.insert(points, ends[:-1], np.nan, axis=1)


def thinned(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """First, last, lowest and highest point of each pixel column, where points are many.

    The picture is the same at the size of a page, and a million samples are drawn as quickly
    as some thousand. Points kept are unchanged; those dropped cannot be zoomed into.
    """
    if time.size > DENSE:  # a value that is no number would count as the highest
        finite = np.isfinite(values)
        time, values = time[finite], values[finite]
    if time.size <= DENSE:
        return time, values
    width = max(time[-1] - time[0], np.finfo(float).tiny)
    column = np.minimum((time - time[0]) / width * _COLUMNS, _COLUMNS - 1).astype(np.int64)
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    ends = np.append(starts[1:], time.size) - 1
    by_value = np.lexsort((values, column))  # columns stay where they were, sorted inside
    keep = np.unique(np.concatenate([starts, ends, by_value[starts], by_value[ends]]))
    return time[keep], values[keep]
