"""`power_spectrum`: amplitudes and power of a variable over frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.statistics.series import Series, drifts, series_of, uniform_step
from nonsmooth.errors import OptionError
from nonsmooth.simulation.options import whole_number

__all__ = ["power_spectrum"]


def power_spectrum(
    run: xr.Dataset,
    variable: str,
    *,
    transient: float = 0.0,
    window: str = "boxcar",
    segments: int = 1,
) -> xr.Dataset:
    """One-sided amplitude and power spectrum of a variable of a run.

    The samples of a run are exact, and of a run with a period the last whole periods are
    taken, so the harmonics of the forcing fall on bins: amplitudes of a periodic motion are
    its Fourier amplitudes up to aliasing, without leakage.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate` with equidistant samples.
    variable : str
        A state or an output. Of a state with drift the mean progression is taken off first.

    Other Parameters
    ----------------
    transient : float, optional
        What is dropped first, in periods; in units of time for a run without a period.
    window : str, optional
        Name of a window of `scipy.signal.get_window`, such as ``"hann"``, against leakage
        where the motion does not repeat with the record; ``"boxcar"`` is none.
    segments : int, optional
        Parts of the record whose power is averaged: less scatter of a chaotic motion, at a
        coarser resolution.

    Returns
    -------
    xarray.Dataset
        Over ``frequency``, in cycles per unit time: ``amplitude`` of a sine at that frequency,
        the mean at zero, and ``power_density``, whose integral is the mean square. With a
        period ``harmonic`` counts frequencies in that of the forcing. Attributes: ``step``
        between samples, ``n_samples`` and ``resolution`` of a segment, and the options.

    Raises
    ------
    OptionError
        For an unknown variable or window, samples that are not equidistant, a record that is
        too short, or samples that do not fit into a period a whole number of times.

    See Also
    --------
    zero_one_test : chaotic or regular.

    Notes
    -----
    Frequencies above half of those of the samples are folded back; take more samples per period
    where amplitudes have not fallen to nothing there. A jump in velocity falls off as one over
    the frequency, one in acceleration as its square.

    Examples
    --------
    A linear oscillator answers a unit force of frequency 2 with the amplitude 1/sqrt(10)
    and nothing else.

    >>> import nonsmooth as ns
    >>> spring = ns.System(
    ...     states=["x", "v"], period="pi", equations={"x": "v", "v": "cos(2*t) - 0.5*v - x"}
    ... )
    >>> spectrum = ns.power_spectrum(ns.simulate(spring, periods=60), "x", transient=50)
    >>> over = spectrum["amplitude"].swap_dims(frequency="harmonic")
    >>> float(over.sel(harmonic=1).round(9))  # 1/sqrt(3**2 + 1)
    0.316227766
    """
    count = whole_number("segments", segments)
    if not isinstance(run, xr.Dataset) or "time" not in run.dims:
        raise OptionError("run: give a result of simulate, with samples over time")
    series = series_of(run, variable)
    if series.times is None:
        raise OptionError(f"variable: {variable!r} is no series over time")
    series = series.after(transient)
    step = uniform_step(series)
    length, periods = _segment(series, step, count)
    if series.period is not None:  # without the rounding of times
        step = series.period * periods / length
    values = series.values[series.values.size - length * count :]
    if drifts(series):
        values = _without_drift(series.values[series.values.size - length * count - 1 :])
    weights = _weights(window, length)
    transform = np.fft.rfft(values.reshape(count, length) * weights, axis=1)
    power = (np.abs(transform) ** 2).mean(axis=0)
    sides = np.full(power.size, 2.0)
    sides[0] = 1.0
    if length % 2 == 0:
        sides[-1] = 1.0
    amplitude = sides * np.sqrt(power) / weights.sum()
    density = sides * power * step / (weights @ weights)
    return _dataset(
        series, amplitude, density, periods,
        {
            "step": step,
            "n_samples": length,
            "resolution": 1.0 / (length * step),
            "window": window,
            "segments": count,
            "transient": float(transient),
        },
        run["time"].attrs.get("units", ""),
    )  # fmt: skip


def _segment(series: Series, step: float, count: int) -> tuple[int, int]:
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


def _without_drift(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """All but the first of some values, less the straight line from the first to the last."""
    lags = np.arange(values.size)
    return (values - lags * ((values[-1] - values[0]) / lags[-1]))[1:]


def _weights(window: Any, length: int) -> npt.NDArray[np.float64]:
    from scipy.signal import get_window

    try:
        return np.asarray(get_window(window, length), dtype=float)
    except (ValueError, TypeError):
        raise OptionError(
            f"window = {window!r:.60} is none of scipy.signal.get_window; for instance boxcar,"
            " hann, blackmanharris or flattop"
        ) from None


def _dataset(
    series: Series,
    amplitude: npt.NDArray[np.float64],
    density: npt.NDArray[np.float64],
    periods: int,
    options: dict[str, Any],
    time_unit: str,
) -> xr.Dataset:
    name, unit = series.label["long_name"], series.label.get("units", "")
    number = np.arange(amplitude.size)
    cycles = {"units": f"1/{time_unit}"} if time_unit else {}
    per_density = {"units": f"({unit})^2 {time_unit}".strip()} if unit else {}
    coords: dict[str, Any] = {
        "frequency": (
            "frequency", number * options["resolution"],
            {"long_name": "frequency in cycles"} | cycles,
        )
    }  # fmt: skip
    if series.period is not None:
        coords["harmonic"] = (
            "frequency", number / periods, {"long_name": "frequency over that of the forcing"},
        )  # fmt: skip
        options["period"] = series.period
    return xr.Dataset(
        {
            "amplitude": (
                "frequency", amplitude,
                {"long_name": f"amplitude of the {name}"} | ({"units": unit} if unit else {}),
            ),
            "power_density": (
                "frequency", density,
                {"long_name": f"power density of the {name}"} | per_density,
            ),
        },
        coords,
        series.attrs | options,
    )  # fmt: skip
