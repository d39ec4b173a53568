"""`synchronous`: a record resampled at equal angles of the shaft."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.measured.marking import check_marked
from nonsmooth.measured.quality.masks import masked, masks_at
from nonsmooth.measured.record import check_record
from nonsmooth.measured.sections import (
    first_samples,
    inside,
    interpolated,
    revolutions_of,
    speed_words,
)
from nonsmooth.runs.memory import free_memory, size_text
from nonsmooth.runs.options import whole_number

__all__ = ["synchronous"]

_FINER = 4  # times as many samples as the record has: more show the interpolation only
_ROUNDING = 1e-9  # of a number of samples
_BESIDE = 16  # numbers beside the variables that are held for each sample while it is made


def synchronous(record: xr.Dataset, samples_per_period: int = 64) -> xr.Dataset:
    """Record resampled at equal angles of the shaft (order tracking).

    Samples per revolution are then a whole number, however the speed wanders, as those of
    `simulate` are: harmonics of the speed fall on single lines of a spectrum.

    Parameters
    ----------
    record : xarray.Dataset
        Result of `read_csv` or `from_arrays`, with `velocities` where they are wanted.
    samples_per_period : int, optional
        Samples per revolution; more than the record has add nothing. Of fewer, half their number is
        the highest order that they show, and higher ones fold into it: take these out before, by
        `low_pass`.

    Returns
    -------
    xarray.Dataset
        Over ``time`` every variable of the record. ``time`` is the angle of the shaft over the
        mean speed, so the samples are equidistant; ``measured_time`` is the time it was, and
        ``speed`` that of the revolution. ``period_number`` and ``phase`` as in a result of
        `simulate`, attribute ``period``.

    Raises
    ------
    OptionError
        When the record has no marks, less than a revolution is left, or the samples would fill the
        memory.

    Warns
    -----
    ResultWarning
        When there are more than four times as many samples as the record has in its slowest
        revolution: nearly all of them are interpolated.

    See Also
    --------
    nonsmooth.power_spectrum : with harmonics, of this.
    nonsmooth.order_tracking : the same block by block, of a run-up.
    nonsmooth.zero_one_test : takes one value per revolution of it.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(5000) / 2000.0
    >>> angle = 100 * t + 0.5 * np.sin(2 * t)  # the speed wanders by one per cent
    >>> marks = np.interp(2 * np.pi * np.arange(1, 39), angle, t)
    >>> record = ns.measured.from_arrays({"x": np.cos(3 * angle)}, times=t, marks=marks)
    >>> orders = ns.power_spectrum(ns.measured.synchronous(record), "x")
    >>> over = orders["amplitude"].swap_dims(frequency="harmonic")
    >>> over.sel(harmonic=[2, 3, 4]).values.round(2)
    array([0., 1., 0.])
    """
    record = check_record(record)
    check_marked(record, "synchronous")
    count = whole_number("samples_per_period", samples_per_period)
    _check_room(record, count)
    times, number, speeds = revolutions_of(record, np.arange(count) / count)
    start, rate = float(record["time"][0]), float(record.attrs["sample_rate"])
    _tell_of_interpolation(count, 2.0 * math.pi / float(speeds.min()) * rate)
    places = (times - start) * rate
    here = inside(places, record.sizes["time"])
    if here.sum() < count:
        raise OptionError("the record holds less than a revolution; take a longer one")
    period = 2.0 * math.pi / float(record.attrs["speed"])
    k = np.flatnonzero(here)
    number, part = number[k] - number[k[0]], (k % count)
    variables: dict[str, Any] = {
        str(name): ("time", interpolated(values.values, places[k]), dict(values.attrs))
        for name, values in record.data_vars.items()
    }
    words = dict(record["time"].attrs)
    units = {key: words[key] for key in ("units",) if key in words}
    speed = float(record.attrs["speed"])
    attrs = dict(record.attrs) | {
        "period": period,
        "samples_per_period": count,
        "sample_rate": count / period,
        "speed": speed,
    }
    found = xr.Dataset(
        variables,
        {
            "time": (
                "time", (number * count + part) * (period / count),
                {"long_name": "angle over the mean speed"} | units,
            ),
            "measured_time": ("time", times[k], {"long_name": "time as measured"} | units),
            "speed": ("time", speeds[k], speed_words(record)),
            "period_number": ("time", number, {"long_name": "whole revolutions before the sample"}),
            "phase": (
                "time", part * (period / count), {"long_name": "time since the mark"} | units,
            ),
        },
        attrs,
    )  # fmt: skip
    flags = masks_at(record, first_samples(places[k], record.sizes["time"]), 4)
    return masked(found, flags) if flags else found


def _tell_of_interpolation(count: int, most: float) -> None:
    """Tell where a record has far fewer samples in any revolution than are asked for."""
    whole = math.ceil(most * (1.0 - _ROUNDING))
    if count > _FINER * whole:
        warnings.warn(
            f"samples_per_period = {count}: the record itself has {most:.3g} in its slowest"
            " revolution; the others are interpolated between them, and orders beyond"
            f" {0.5 * most:.3g} are of the interpolation: give {whole} or fewer",
            ResultWarning,
            stacklevel=3,
        )


def _check_room(record: xr.Dataset, count: int) -> None:
    """Refuse so many samples per revolution that they would fill the memory."""
    total = count * max(record.sizes["mark"] - 1, 0)
    need, free = 8 * (len(record.data_vars) + _BESIDE) * total, free_memory()
    if need > free:
        raise OptionError(
            f"samples_per_period = {count:g}: {total:.3g} samples take {size_text(need)}, and"
            f" {size_text(free)} of memory are free; give fewer, for more than the record has"
            " itself add nothing"
        )
