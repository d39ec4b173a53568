"""`zero_one_test`: chaotic or regular, from a series of numbers alone."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.options import check_seed
from nonsmooth.analysis.statistics.series import Series, drifts, series_of, uniform_step
from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.runs.options import whole_number

__all__ = ["correlations_of", "zero_one_test"]

_LEAST = 200  # values; of fewer the test tells nothing
_RANGE = (np.pi / 5, 4 * np.pi / 5)  # of c, away from the resonances at 0 and pi
_CONSTANT = 1e-10  # scatter beside the values that is rounding
_OVERSAMPLED = 0.9  # correlation of neighbours
_PART = 10  # of the series is the longest lag
_AT_ONCE = 2**18  # numbers in one go over several c

Vector = npt.NDArray[np.float64]


def zero_one_test(
    data: xr.Dataset | xr.DataArray | npt.ArrayLike,
    variable: str | None = None,
    *,
    transient: float = 0.0,
    every: int = 1,
    frequencies: int = 100,
    seed: int = 0,
) -> xr.Dataset:
    r"""0-1 test for chaos of a series: K near one for chaotic, near zero for regular motion.

    The series drives the translation :math:`p_c(n) = \sum_{j \le n} \varphi_j \cos jc`,
    :math:`q_c(n) = \sum_{j \le n} \varphi_j \sin jc`. For regular motion it stays bounded, for
    chaotic motion it wanders like a Brownian particle. K is the correlation of its mean
    square displacement with time, the median over many random c.

    Parameters
    ----------
    data : xarray.Dataset, xarray.DataArray, array_like
        A run of `simulate`, or any dataset or list of numbers. Of a run with a period one
        value per period is taken, at the phase of the last sample.
    variable : str, optional
        Name of the variable in a dataset. Of a state with drift the increments are tested.

    Other Parameters
    ----------------
    transient : float, optional
        What is dropped first: in periods for a run with a period, in units of time for one
        without, in values for plain numbers.
    every : int, optional
        Take only every n-th value, where the series is sampled too densely.
    frequencies : int, optional
        How many values of c, drawn evenly between pi/5 and 4 pi/5.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. They choose the
        values of c.

    Returns
    -------
    xarray.Dataset
        ``K``, the median, and ``K_low`` and ``K_high``, between which nine of ten values of
        ``K_of_c`` lie, over ``c``; ``p`` and ``q`` over ``point`` for one c in the middle,
        attribute ``c_shown``. Attributes: ``n_points`` and the options.

    Raises
    ------
    OptionError
        For an unknown variable, fewer than 200 values, or samples that are not equidistant.

    Warns
    -----
    ResultWarning
        When neighbouring values are so alike that the series may be oversampled, which makes
        chaotic motion look regular.

    See Also
    --------
    lyapunov_spectrum : exponents, from the equations.

    Notes
    -----
    The mean of the series is taken off first, and with it the oscillating term of the mean
    square displacement; lags go up to a tenth of the series. A series that is constant but
    for rounding is regular, K = 0. Weak chaos and noise need long series: compare K of half of
    it.

    References
    ----------
    G. A. Gottwald and I. Melbourne, On the implementation of the 0-1 test for chaos, SIAM
    Journal on Applied Dynamical Systems 8, 129-145 (2009).

    Examples
    --------
    The logistic map at 3.5 has period four, at 4 it is chaotic.

    >>> import nonsmooth as ns
    >>> def logistic(a, x=0.3):
    ...     series = []
    ...     for _ in range(2000):
    ...         x = a * x * (1 - x)
    ...         series.append(x)
    ...     return series
    >>> [float(ns.zero_one_test(logistic(a), transient=100)["K"].round(1)) for a in (3.5, 4)]
    [0.0, 1.0]
    """
    series = _prepared(series_of(data, variable), transient, whole_number("every", every))
    count = whole_number("frequencies", frequencies)
    values = series.values
    away = values - values.mean()
    if not _is_constant(values, away):
        _warn_of_oversampling(away)
    c, correlations = correlations_of(values, count, check_seed(seed))
    middle = float(np.median(correlations))
    shown = float(c[np.argmin(np.abs(correlations - middle))])
    path = np.cumsum(away * np.exp(1j * shown * np.arange(1, values.size + 1)))
    low, high = np.quantile(correlations, (0.05, 0.95))
    return xr.Dataset(
        {
            "K": ((), middle, {"long_name": "K of the 0-1 test"}),
            "K_low": ((), float(low), {"long_name": "5 % of the values of K are lower"}),
            "K_high": ((), float(high), {"long_name": "5 % of the values of K are higher"}),
            "K_of_c": ("c", correlations, {"long_name": "K of each c"}),
            "p": ("point", path.real.copy(), {"long_name": "translation p"}),
            "q": ("point", path.imag.copy(), {"long_name": "translation q"}),
        },
        {"c": ("c", c, {"long_name": "c of the 0-1 test"})},
        series.attrs
        | {
            "n_points": int(values.size),
            "c_shown": shown,
            "transient": float(transient),
            "every": int(every),
            "frequencies": count,
            "seed": int(seed),
        },
    )


def _prepared(series: Series, transient: Any, every: int) -> Series:
    """One value per period, or equidistant ones, without transient and drift."""
    series = series.after(transient)
    if series.phases is not None and series.period is not None:
        away = np.abs(series.phases - series.phases[-1])
        series = series.part(np.minimum(away, series.period - away) < 1e-9 * series.period)
    elif series.times is not None:
        uniform_step(series)
    series = series.part(slice((series.values.size - 1) % every, None, every))
    if drifts(series):
        series = Series(np.diff(series.values), attrs=series.attrs | {"increments": 1})
    if series.values.size < _LEAST:
        raise OptionError(
            f"the series has {series.values.size} values, and the test needs {_LEAST} at least,"
            " better some thousands; take a longer run (of one with a period, one value per period"
            " counts)"
        )
    return series


def correlations_of(values: Vector, count: int, seed: int) -> tuple[Vector, Vector]:
    """Values of c, drawn at random, and K of each; all zero for a series that is constant."""
    c = np.sort(np.random.default_rng(seed).uniform(*_RANGE, count))
    away = values - values.mean()
    if _is_constant(values, away):
        return c, np.zeros(count)
    rows = max(1, _AT_ONCE // values.size)
    parts = [_correlations(away, c[first : first + rows]) for first in range(0, count, rows)]
    return c, np.concatenate(parts)


def _is_constant(values: Vector, away: Vector) -> bool:
    return float(np.abs(away).max()) <= _CONSTANT * max(float(np.abs(values).max()), 1e-300)


def _correlations(values: Vector, c: Vector) -> Vector:
    """Correlation of the mean square displacement with the lag, for some c."""
    from scipy.signal import fftconvolve

    n = values.size
    path = np.cumsum(values * np.exp(1j * c[:, None] * np.arange(1, n + 1)), axis=1)
    path -= path.mean(axis=1, keepdims=True)
    longest = n // _PART
    base = path[:, : n - longest]
    # |z(j + k) - z(j)|^2 summed over j, for all lags k at once
    squares = np.cumsum(np.abs(path) ** 2, axis=1)
    squares = np.column_stack([np.zeros(c.size), squares])
    lags = np.arange(1, longest + 1)
    size = base.shape[1]
    later = squares[:, lags + size] - squares[:, lags]
    product = fftconvolve(path, base[:, ::-1].conj(), mode="valid", axes=1)[:, 1:].real
    displacement = (later + squares[:, size : size + 1] - 2.0 * product) / size
    still = displacement.std(axis=1) <= 1e-13 * np.maximum(np.abs(path).max(axis=1) ** 2, 1e-300)
    away = displacement - displacement.mean(axis=1, keepdims=True)
    lag = lags - lags.mean()
    power = np.sqrt((away * away).sum(axis=1) * (lag @ lag))
    return np.where(still, 0.0, away @ lag / np.where(still, 1.0, power))


def _warn_of_oversampling(away: Vector) -> None:
    power = float(away @ away)
    if float(away[1:] @ away[:-1]) <= _OVERSAMPLED * power:
        return
    lag = 1
    while 2 * lag < away.size and float(away[lag:] @ away[:-lag]) > 0.3 * power:
        lag += 1
    warnings.warn(
        "neighbouring values are nearly the same, so the series may be sampled too densely, which"
        f" makes chaotic motion look regular; try every={lag}, or one value per period",
        ResultWarning,
        stacklevel=3,
    )
