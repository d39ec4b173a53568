"""A series of numbers out of whatever holds one: a run, a variable of a dataset, a list."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.options import derived_attributes
from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.runs.options import finite_number
from nonsmooth.system.system import System

__all__ = [
    "Series",
    "clock_name",
    "drifts",
    "is_by_angle",
    "series_of",
    "slow_names",
    "uniform_step",
]

_SAME = 1e-6  # of a step, between samples that count as equidistant
_LARGEST = 1e100  # of the numbers of a series

Vector = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """Values in order, their times where they have some, and where they come from."""

    values: Vector
    times: Vector | None = None
    phases: Vector | None = None
    period: float | None = None
    label: dict[str, str] = field(default_factory=dict)
    attrs: dict[str, Any] = field(default_factory=dict)

    def part(self, chosen: Any) -> Series:
        """The same with some of the values only."""
        times, phases = (None if a is None else a[chosen] for a in (self.times, self.phases))
        return Series(self.values[chosen], times, phases, self.period, self.label, self.attrs)

    def after(self, transient: Any) -> Series:
        """What comes after a transient in periods, in time without one, in values without time."""
        length = finite_number("transient", transient)
        if length < 0.0:
            raise OptionError(f"transient = {transient} must not be negative")
        if self.times is None:
            rest = self.part(slice(round(length), None))
        else:
            unit = 1.0 if self.period is None else self.period
            first = float(self.times[0]) if self.times.size else 0.0
            begin = first + length * unit
            rest = self.part(self.times >= begin - 1e-9 * max(unit, abs(begin)))
        if rest.values.size == 0:
            raise OptionError(f"transient = {transient} leaves nothing of the series")
        return rest


def series_of(data: Any, variable: str | None) -> Series:
    """Series in a dataset by the name of a variable, in an array, or in a list of numbers."""
    if isinstance(data, xr.Dataset):
        known = [
            str(name)
            for name, each in data.data_vars.items()
            if each.ndim == 1 and "flag_meanings" not in each.attrs
        ]
        if variable is None:
            raise OptionError(f"variable= is needed; the dataset has {', '.join(known)}")
        if is_known(variable, [*data.data_vars]) and "flag_meanings" in data[variable].attrs:
            raise OptionError(
                f"variable = {variable!r}: its numbers stand for names, so sums and differences of"
                " them mean nothing; take a state or an output"
            )
        if not is_known(variable, known):
            raise OptionError(f"variable: {unknown_name('variable', variable, known)}")
        array: xr.DataArray | None = data[variable]
    elif variable is not None:
        raise OptionError(f"variable = {variable!r}: data without names; leave variable= out")
    else:
        array = data if isinstance(data, xr.DataArray) else None
    values = _numbers(data if array is None else array.values)
    if array is None:
        return Series(values)
    attrs = dict(data.attrs)
    times = None
    if array.dims[0] == "time" and "time" in array.coords:
        times = np.asarray(array["time"].values, float)
    phases = np.asarray(array["phase"].values, float) if "phase" in array.coords else None
    label = {key: str(array.attrs[key]) for key in ("long_name", "units") if key in array.attrs}
    label.setdefault("long_name", str(array.name or "value"))
    period = float(attrs["period"]) if "period" in attrs and times is not None else None
    kept = derived_attributes(data) | {"variable": variable or ""}
    return Series(values, times, phases, period, label, kept)


def drifts(series: Series) -> bool:
    """Whether the series is a drift state of the system of a run."""
    if "system" not in series.attrs:
        return False
    return series.attrs["variable"] in System.from_toml(series.attrs["system"]).drift_states


def uniform_step(series: Series) -> float:
    """Time between samples, which must be equidistant."""
    assert series.times is not None
    steps = np.diff(series.times)
    if steps.size == 0:
        raise OptionError(
            f"{series.times.size} samples are too few for a step between them; take a longer run"
        )
    if steps.max() - steps.min() > _SAME * steps.mean():
        raise OptionError(
            "the samples are not equidistant; simulate with samples_per_period=, or with"
            " equidistant times="
        )
    return float((series.times[-1] - series.times[0]) / steps.size)


def _numbers(values: Any) -> Vector:
    try:
        if np.asarray(values).dtype.kind == "c":  # of which numpy would drop a part
            raise TypeError
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"data = {quote(values)}: give a run, or a list of numbers") from None
    if numbers.ndim != 1 or not np.all(np.isfinite(numbers)):
        raise OptionError("data: give numbers in one dimension, all of them finite")
    if np.any(np.abs(numbers) > _LARGEST):
        raise OptionError(
            f"data: there are numbers above {_LARGEST:g}, whose squares no double holds; take"
            " another unit"
        )
    return numbers


def slow_names(run: xr.Dataset) -> list[str]:
    """Names of the slow parameters of a run."""
    texts = str(run.attrs.get("slow_values", "")).split()
    return [name for name in (text.partition("=")[0] for text in texts) if name in run]


def is_by_angle(run: xr.Dataset) -> bool:
    """Whether the samples are even in the angle of a shaft, as those of `measured.synchronous`.

    Their ``time`` is the angle over the mean speed.
    """
    return "measured_time" in run.coords


def clock_name(run: xr.Dataset) -> str:
    """Name of the coordinate that says when each sample was."""
    return "measured_time" if is_by_angle(run) else "time"
