"""Records cut into segments of whole periods, and what is taken off before a transform."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.statistics.series import Series, drifts, series_of, uniform_step
from nonsmooth.errors import OptionError, quote

__all__ = [
    "Segments",
    "check_run",
    "check_window",
    "record_attributes",
    "record_of",
    "segments_of",
    "without_drift",
]

Floats = npt.NDArray[np.float64]


class Segments(NamedTuple):
    """Values of equal parts of a record; ``periods`` of the forcing in each, zero without one."""

    values: Floats  # (segment, sample)
    periods: int
    step: float


def check_run(run: Any) -> None:
    """Refuse what is no run."""
    if not isinstance(run, xr.Dataset) or "time" not in run.dims:
        raise OptionError("run: give a result of simulate, with samples over time")


def record_of(run: xr.Dataset, variable: str) -> Series:
    """Series of a variable of a run."""
    check_run(run)
    over_time = [name for name, each in run.data_vars.items() if each.dims == ("time",)]
    series = series_of(run[over_time], variable)
    if series.times is None:
        raise OptionError(f"variable: {variable!r} is no series over time")
    return series


def segments_of(series: Series, count: int) -> Segments:
    """So many segments at the end of a series, of a drift state less its mean progression."""
    step = uniform_step(series)
    length, periods = _length(series, step, count)
    if series.period is not None:  # without the rounding of times
        step = series.period * periods / length
    size = series.values.size
    values = series.values[size - length * count :]
    if drifts(series):
        values = without_drift(series.values[size - length * count - 1 :])
    return Segments(values.reshape(count, length), periods, step)


def _length(series: Series, step: float, count: int) -> tuple[int, int]:
    """Samples of a segment, and whole periods in it, zero without a period."""
    size = series.values.size - (1 if drifts(series) else 0)
    if series.period is None:
        length, periods = size // count, 0
    else:
        per_period = series.period / step
        if abs(per_period - round(per_period)) > 1e-6 * per_period or round(per_period) < 2:
            raise OptionError(
                f"a period holds {per_period:.6g} samples, and it must hold a whole number, at"
                " least two; simulate with samples_per_period="
            )
        periods = size // round(per_period) // count
        length = periods * round(per_period)
    if length < 4:
        what = "periods" if series.period is not None else "samples"
        raise OptionError(
            f"{series.values.size} samples are too few for {count} segments of whole {what}; take a"
            " longer run or fewer segments="
        )
    return length, periods


def without_drift(values: Floats) -> Floats:
    """All but the first of some values, less the straight line from the first to the last."""
    lags = np.arange(values.size)
    return (values - lags * ((values[-1] - values[0]) / lags[-1]))[1:]


def check_window(window: Any, length: int) -> Floats:
    """Weights of a window by its name."""
    from scipy.signal import get_window

    try:
        return np.asarray(get_window(window, length), dtype=float)
    except (ValueError, TypeError, IndexError):
        raise OptionError(
            f"window = {quote(window)} is none of scipy.signal.get_window; for instance boxcar,"
            " hann, blackmanharris or flattop"
        ) from None


def record_attributes(
    series: Series, parts: Segments, window: str, transient: float
) -> dict[str, Any]:
    """What of a record and of the options stands in a result."""
    count, length = parts.values.shape
    attrs = {
        "step": parts.step,
        "n_samples": length,
        "resolution": 1.0 / (length * parts.step),
        "window": window,
        "segments": count,
        "transient": float(transient),
        "mean": float(parts.values.mean()),
    }
    return attrs if series.period is None else attrs | {"period": series.period}
