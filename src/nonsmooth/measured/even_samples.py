"""Samples in equal steps of time, of a record or of a run, and the noise that they carry."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.measured.quality.masks import carried, is_mask

__all__ = [
    "FEWEST",
    "check_even",
    "check_variables",
    "listed",
    "noise_before_filters",
    "over_time",
]


_OFF = 1e-6  # of a step, between samples that count as equidistant
FEWEST = 16  # samples
_NOISE_ORDER = 6  # of the differences by which noise is told from a sampled motion
_NORMAL = 0.674489750196082  # median of the size of a standard normal variable


def check_even(data: Any) -> float:
    """Time between samples, or an error that says what may be wrong with them."""
    if not isinstance(data, xr.Dataset) or "time" not in data.dims or "time" not in data.coords:
        raise OptionError(
            "data: give a record (measured.read_csv, measured.from_arrays) or a result of simulate"
        )
    times = data["time"].values.astype(float)
    if times.size < FEWEST:
        raise OptionError(f"data: {times.size} samples are too few; {FEWEST} are needed at least")
    steps = np.diff(times)
    step = float((times[-1] - times[0]) / steps.size)
    slack = _OFF * step + 4.0 * np.finfo(float).eps * np.abs(times).max()
    if step <= 0.0 or float(np.abs(steps - step).max()) > slack:
        raise OptionError(
            "data: the samples are not equidistant; simulate whole periods with"
            " samples_per_period=, or with equidistant times="
        )
    return step


def listed(names: Any, option: str) -> list[Any]:
    """Names in a list; one name alone stands for a list of it."""
    if isinstance(names, str):
        return [names]
    if not isinstance(names, Iterable):
        raise OptionError(f"{option} = {quote(names)}: give a name, or a list of names")
    return list(names)


def check_variables(data: xr.Dataset, names: Any, option: str) -> list[str]:
    """Names of variables over time, each of them finite; all there are without names."""
    known = [
        str(name)
        for name, v in data.data_vars.items()
        if v.dims == ("time",) and v.dtype.kind == "f"
    ]
    chosen = known if names is None else listed(names, option)
    if not chosen:
        raise OptionError(f"{option}: name some of {', '.join(known)}")
    for name in chosen:
        if not is_known(name, known):
            raise OptionError(f"{option}: {unknown_name('variable', name, known)}")
        if not np.all(np.isfinite(data[name].values)):
            raise OptionError(f"{name}: some samples are not finite; cut the data to where all are")
    return [str(name) for name in chosen]


def over_time(
    data: xr.Dataset, variables: dict[str, Any], part: slice, sources: Mapping[str, str], reach: int
) -> xr.Dataset:
    """Dataset of new variables with the coordinates and attributes of the old one.

    The log of events of a run stays behind: the states in it have not been through the filter.
    Masks go on: a sample is as bad as those that it was made of.

    sources: the old variable of each new one; reach: samples that the filter takes in on either
    side
    """
    kept = {
        name: coord
        for name, coord in data.coords.items()
        if (coord.dims == ("time",) or "mark" in coord.dims)
    }
    bare = xr.Dataset(coords=kept, attrs=dict(data.attrs)).isel(time=part)
    bare = bare.drop_vars([name for name in bare.coords if is_mask(bare, str(name))])
    return carried(data, bare.assign(variables), sources, reach, part)


def _white_noise(values: npt.NDArray[np.float64]) -> float:
    """Standard deviation of white noise on a motion that is smooth from sample to sample.

    Differences of sixth order leave next to nothing of the motion; their median size does not
    feel the few samples about a contact.
    """
    differences = np.diff(values, _NOISE_ORDER)
    gain = math.sqrt(math.comb(2 * _NOISE_ORDER, _NOISE_ORDER))
    return float(np.median(np.abs(differences))) / _NORMAL / gain


def noise_before_filters(variable: xr.DataArray) -> float:
    """Standard deviation of its white noise; of a filtered variable that before the filter.

    What a low-pass leaves of noise looks smooth, and is as strong as ever at low frequencies.
    """
    words = variable.attrs
    if "low_pass" in words and "noise" in words:
        return float(words["noise"]) / float(words["noise_gain"])
    return _white_noise(variable.values.astype(float))
