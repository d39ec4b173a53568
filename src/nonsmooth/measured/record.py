"""`from_arrays`: displacements and marks as a dataset over time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.measured.channel import check_name
from nonsmooth.measured.marks import check_marks, find_edges, given_marks
from nonsmooth.measured.speeds import speed_attributes
from nonsmooth.simulation.options import finite_number
from nonsmooth.version import __version__

__all__ = ["check_record", "from_arrays"]

_FEWEST = 16  # samples
_LARGEST = 1e30  # a reading; codes for none are often larger still
_OFF = 0.1  # of a step, a time may be off the even grid

Floats = npt.NDArray[np.float64]


def from_arrays(
    displacements: Mapping[str, npt.ArrayLike],
    *,
    times: npt.ArrayLike | None = None,
    sample_rate: float | None = None,
    marks: npt.ArrayLike | None = None,
    pulse: npt.ArrayLike | None = None,
    units: str | Mapping[str, str] = "",
    labels: Mapping[str, str] | None = None,
    threshold: float | None = None,
    hysteresis: float | None = None,
    edge: str = "rising",
    bad_marks: str = "refuse",
    time_range: tuple[float, float] | None = None,
    name: str = "measured",
) -> xr.Dataset:
    """Record of a measured motion out of arrays.

    Parameters
    ----------
    displacements : mapping of str to array_like
        Samples by the name of the variable.

    Other Parameters
    ----------------
    times : array_like, optional
        Time of each sample in s: increasing, and at most a tenth of a step off an even grid,
        which is then used in place of them. Or ``sample_rate``.
    sample_rate : float, optional
        Samples per s, the first one at time 0.
    marks : array_like, optional
        Times of the marks, one per revolution. Or ``pulse``.
    pulse : array_like, optional
        Samples of the signal that marks revolutions, whose edges are taken.
    units : str or mapping of str to str, optional
        Units of all displacements, or of each.
    labels : mapping of str to str, optional
        ``long_name`` of variables, for the labels of axes.
    threshold : float, optional
        Level of an edge; by default midway between the lowest and the highest sample.
    hysteresis : float, optional
        Width of the band about the threshold that an edge has to cross; by default a fifth of
        the range of the signal.
    edge : {"rising", "falling"}, optional
        Which edges are marks.
    bad_marks : {"refuse", "repair"}, optional
        What to do about revolutions shorter than 2/3 or longer than 3/2 of the median of eleven:
        refuse the record, or leave double marks out and put missing ones in evenly.
    time_range : tuple of float, optional
        First and last time of the part that is kept; before anything else is checked.
    name : str, optional
        Title of the record.

    Returns
    -------
    xarray.Dataset
        The displacements over ``time``, and ``mark_time`` over ``mark``. Attributes:
        ``sample_rate``, ``speed`` in rad/s (that of the whole revolutions between the first and
        the last mark) and ``speed_spread``, the standard deviation over single revolutions;
        ``mark_error``, a bound of what sampling the pulse does to the time of a mark;
        ``n_marks``, ``n_repaired``, ``time_off``, how far times were off the even grid, in steps.

    Raises
    ------
    OptionError
        For samples that are not finite or not even in time, and marks that are not one per
        revolution; the message says where.

    See Also
    --------
    read_csv : the same from a file.
    velocities : the next step.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(5000) / 2000.0
    >>> record = ns.measured.from_arrays(
    ...     {"x": np.cos(100 * t)}, times=t, marks=np.arange(39) * np.pi / 50, units="mm"
    ... )
    >>> round(record.attrs["speed"], 6), record.sizes["mark"]
    (100.0, 39)
    """
    arrays = _arrays(displacements)
    clock = _clock(times, sample_rate, next(iter(arrays.values())).size, time_range)
    start, step, first, last = clock.start, clock.step, clock.first, clock.last
    arrays = {key: values[first:last] for key, values in arrays.items()}
    count = last - first
    if count < _FEWEST:
        raise OptionError(f"{count} samples are too few; {_FEWEST} are needed at least")
    _check_finite(arrays, start, step)
    if (marks is None) == (pulse is None):
        raise OptionError("give the marks of revolutions, either marks= or pulse=")
    if marks is not None:
        places, error = given_marks(marks), 0.0
        places = places[(places >= start) & (places <= start + (count - 1) * step)]
    else:
        signal = _numbers("pulse", pulse)
        if signal.size < last:
            raise OptionError(f"pulse: {signal.size} samples came, and displacements have more")
        signal = signal[first:last]
        _check_finite({"pulse": signal}, start, step)
        edges = find_edges(signal, threshold, hysteresis, edge)
        places, error = start + step * edges.places, step * edges.error
    kept, repaired = check_marks(places, bad_marks)
    attrs: dict[str, Any] = {
        "system_name": str(name),
        "nonsmooth_version": __version__,
        "status": "completed",
        "message": "completed",
        "sample_rate": 1.0 / step,
        "time_off": clock.off,
        **speed_attributes(kept),
        "mark_error": error,
        "n_repaired": repaired,
    }
    words = _words(arrays, units, labels)
    return xr.Dataset(
        {key: ("time", values, words[key]) for key, values in arrays.items()},
        {
            "time": (
                "time", start + step * np.arange(count), {"long_name": "time", "units": "s"},
            ),
            "mark_time": ("mark", kept, {"long_name": "time of the mark", "units": "s"}),
        },
        attrs,
    )  # fmt: skip


def check_record(record: Any) -> xr.Dataset:
    """The record of a measured motion, or an error that says what is one."""
    if not isinstance(record, xr.Dataset) or "mark_time" not in record.coords:
        raise OptionError("record: give a result of measured.read_csv or measured.from_arrays")
    count, rate = record.sizes["time"], float(record.attrs.get("sample_rate", math.nan))
    if count < 2:
        raise OptionError("record: it has no samples")
    span = float(record["time"][-1] - record["time"][0]) * rate
    if not abs(span / (count - 1) - 1.0) < 1e-6:
        raise OptionError(
            "record: its samples are no longer one after the other, as its sample_rate has it; cut"
            " it by read_csv(..., time_range=) or by a slice of time without a step"
        )
    return record


def _arrays(displacements: Any) -> dict[str, Floats]:
    if not isinstance(displacements, Mapping) or not displacements:
        raise OptionError("displacements: give arrays by name, such as {'x': [...], 'y': [...]}")
    found: dict[str, Floats] = {}
    for name, values in displacements.items():
        check_name(name, found)
        found[name] = _numbers(name, values)
    sizes = {name: values.size for name, values in found.items()}
    if len(set(sizes.values())) > 1:
        raise OptionError(f"displacements differ in their number of samples: {sizes}")
    return found


def _numbers(name: str, values: Any) -> Floats:
    try:
        given = np.asarray(values)
        numbers = np.array(given, dtype=float) if given.dtype.kind != "c" else None
    except (TypeError, ValueError):
        raise OptionError(f"{name} = {values!r:.60}: give numbers") from None
    if numbers is None or numbers.ndim != 1 or numbers.size == 0:
        raise OptionError(f"{name}: give real samples in one dimension, one at least")
    return numbers


class _Clock(NamedTuple):
    """Even times of the samples from ``first`` to before ``last``, and how far off they were."""

    start: float
    step: float
    off: float
    first: int
    last: int


def _clock(times: Any, sample_rate: Any, count: int, time_range: Any) -> _Clock:
    if (times is None) == (sample_rate is None):
        raise OptionError("give either the times= of the samples or their sample_rate=")
    low, high = (-math.inf, math.inf) if time_range is None else _two_times(time_range)
    if times is None:
        rate = finite_number("sample_rate", sample_rate)
        if rate <= 0.0:
            raise OptionError(f"sample_rate = {rate:g} must be positive, in samples per s")
        given = np.arange(count) / rate
    else:
        given = _numbers("times", times)
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
        raise OptionError(f"times: sample {k} (from 0) has no time; give sample_rate= instead")
    if times is None:
        return _Clock(float(part[0]), 1.0 / rate, 0.0, first, last)
    return _Clock(*_even_grid(part, first), first, last)


def _even_grid(times: Floats, first: int) -> tuple[float, float, float]:
    """The even grid closest to some times, refused where they are not even."""
    if times.size < _FEWEST:
        raise OptionError(f"{times.size} samples are too few; {_FEWEST} are needed at least")
    steps = np.diff(times)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        k = int(back[0])
        raise OptionError(
            f"times must increase, and sample {first + k + 1} at {times[k + 1]:.9g} follows"
            f" {times[k]:.9g} (samples from 0); are two records in one file, or"
            " times rounded too coarsely? For even samples give sample_rate= instead"
        )
    number = np.arange(times.size) - 0.5 * (times.size - 1)
    step = float(number @ (times - times.mean()) / (number @ number))
    start = float(times.mean() + step * number[0])
    away = np.abs(times - (start + step * np.arange(times.size))) / step
    if away.max() > _OFF:
        k = int(np.argmax(steps))
        usual = float(np.median(steps))
        what = (
            f"the longest step, after sample {first + k} at {times[k]:.9g}, is"
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
    except (TypeError, ValueError):
        raise OptionError(f"time_range = {time_range!r:.60}: give two times") from None
    return low, high


def _check_finite(arrays: dict[str, Floats], start: float, step: float) -> None:
    """Refuse gaps, and say which part of the record has none."""
    for name, values in arrays.items():
        with np.errstate(invalid="ignore"):
            large = np.isfinite(values) & (np.abs(values) > _LARGEST)
        if large.any():
            k = int(np.argmax(large))
            raise OptionError(
                f"{name}: {values[k]:g} at t = {start + step * k:.7g} is beyond {_LARGEST:g}; what"
                " does the recorder write where it has no reading?"
            )
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size == 0:
            continue
        ends = np.concatenate([[-1], bad, [values.size]])
        k = int(np.argmax(np.diff(ends)))
        low, high = start + step * (ends[k] + 1), start + step * (ends[k + 1] - 1)
        raise OptionError(
            f"{name}: {bad.size} samples are not finite, the first at t ="
            f" {start + step * bad[0]:.7g}; the longest part without a gap is"
            f" time_range=({low:.9g}, {high:.9g})"
        )


def _words(arrays: dict[str, Floats], units: Any, labels: Any) -> dict[str, Any]:
    """Attributes of each displacement."""
    labels = {} if labels is None else labels
    if not isinstance(labels, Mapping) or not isinstance(units, (str, Mapping)):
        raise OptionError("units= is a text or a mapping by name, labels= a mapping by name")
    found = {}
    for name in arrays:
        unit = str(units.get(name, "")) if isinstance(units, Mapping) else units
        words = {"long_name": labels.get(name) or f"displacement {name}"}
        found[name] = words | ({"units": unit} if unit else {})
    return found
