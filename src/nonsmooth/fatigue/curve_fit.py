"""Least squares for a length that grows exponentially from a constant."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.fatigue.checks import Array, finite_array
from nonsmooth.fatigue.regression import far_off

__all__ = ["Fit", "fitted_curve"]

_FEWEST = 6  # for three constants and an error worth the name
_GUESSES = 60
# of a3 over the duration; slower growth cannot be told from a straight line, nor faster from a jump
_SLOWEST, _FASTEST = 20.0, 0.005
_LARGEST_ERROR = 0.5  # of the logarithm of a3
_DOUBTFUL = 0.01  # a record without slips is called faulty this often
_EXACT = 1e-9  # of the growth, to which the search for the constants is good


class Fit(NamedTuple):
    """Constants of Eq. (49), their standard errors, and the points that lie off the curve."""

    a0: float
    a2: float
    a3: float
    errors: dict[str, float]
    outliers: tuple[int, ...]


def fitted_curve(times: Any, lengths: Any, a1: float) -> Fit:
    """Constants a0, a2, a3 of Eq. (49) for a given a1."""
    from scipy.optimize import least_squares

    t, a = _checked(times, lengths)
    duration, last = float(t[-1] - t[0]), float(t[-1])
    s = (t - last) / duration  # from -1 to 0, so that no exponential is large
    # for a given a3 the fit is a straight line in the exponential
    trials = np.geomspace(_FASTEST, _SLOWEST, _GUESSES)
    best = min(trials, key=lambda scale: _line(s, a, scale)[2])
    a0, grown, _ = _line(s, a, best)

    def residuals(p: Array) -> Array:
        return p[0] + p[1] * np.exp(s / math.exp(p[2])) - a

    def rates(p: Array) -> Array:
        scaled = s / math.exp(p[2])
        wave = np.exp(scaled)
        return np.stack([np.ones_like(s), wave, -p[1] * wave * scaled], axis=1)

    start = [a0, grown, math.log(best)]
    free, low, high = np.inf, math.log(_FASTEST) - 1.0, math.log(_SLOWEST) + 1.0
    found = least_squares(
        residuals, start, rates, bounds=([-free, -free, low], [free, free, high]),
        x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14,
    )  # fmt: skip
    a0, grown, scale = float(found.x[0]), float(found.x[1]), math.exp(float(found.x[2]))
    spread = math.sqrt(2.0 * found.cost / (t.size - 3))
    covariance = _covariance(rates(found.x), spread)
    _check_growth(grown, scale, covariance, duration)
    a3 = duration * scale
    a2 = last - a3 * math.log(grown / a1)
    # a2 by grown and log(a3)
    slope = np.array([0.0, -a3 / grown, a2 - last])
    errors = {
        "a0": math.sqrt(covariance[0, 0]),
        "a2": math.sqrt(float(slope @ covariance @ slope)),
        "a3": a3 * math.sqrt(covariance[2, 2]),
        "residual": spread,
    }
    return Fit(a0, a2, a3, errors, _outliers(residuals(found.x), rates(found.x), float(np.ptp(a))))


def _outliers(rest: Array, rates: Array, size: float) -> tuple[int, ...]:
    """Points too far off for noise, by the fit as it is linear near its constants."""
    basis, _, _ = np.linalg.svd(rates / np.linalg.norm(rates, axis=0), full_matrices=False)
    leverage = np.sum(basis**2, axis=1)
    return tuple(far_off(rest, leverage, rates.shape[1], _DOUBTFUL, _EXACT * size))


def _checked(times: Any, lengths: Any) -> tuple[Array, Array]:
    t, a = finite_array("times", times), finite_array("lengths", lengths)
    if t.ndim != 1 or t.shape != a.shape:
        raise OptionError(
            f"times and lengths have the shapes {t.shape} and {a.shape}; give one length for each"
            " time"
        )
    if t.size < _FEWEST:
        raise OptionError(
            f"{t.size} points are too few for three constants and their errors; give {_FEWEST} at"
            " least"
        )
    steps = np.diff(t)
    if np.any(steps < 0.0):
        place = int(np.flatnonzero(steps < 0.0)[0])
        raise OptionError(
            f"times[{place + 1}] = {t[place + 1]:g} comes after {t[place]:g}; sort both:"
            " order = np.argsort(times)"
        )
    if np.unique(t).size < 4:
        raise OptionError("there are less than four different times; measure at more of them")
    if a.min() == a.max():
        raise OptionError(f"all lengths are {a[0]:g}: there is no growth to fit a curve to")
    return t, a


def _line(s: Array, a: Array, scale: float) -> tuple[float, float, float]:
    """Constant, growth at the end, and sum of squares of the best line for one a3."""
    wave = np.exp(s / scale)
    x, y = wave - wave.mean(), a - a.mean()
    grown = float(x @ y / (x @ x))
    rest = y - grown * x
    return float(a.mean() - grown * wave.mean()), grown, float(rest @ rest)


def _covariance(rates: Array, spread: float) -> Array:
    # by singular values, since the columns are nearly parallel where the growth is slow
    _, sizes, rows = np.linalg.svd(rates, full_matrices=False)
    inverse = rows.T / sizes
    return np.asarray(spread**2 * inverse @ inverse.T)


def _check_growth(grown: float, scale: float, covariance: Array, duration: float) -> None:
    if not _FASTEST < scale < _SLOWEST or math.sqrt(covariance[2, 2]) > _LARGEST_ERROR:
        raise OptionError(
            f"a3 comes out as {scale * duration:.3g} for a record of {duration:.3g}, and is not"
            " determined by it: a straight line, a jump or noise fits as well; give a record in"
            " which the growth gets some times faster, with several points while it does"
        )
    if grown <= 3.0 * math.sqrt(covariance[1, 1]):
        raise OptionError(
            f"the lengths change by {grown:.3g} mm faster than evenly, which is no growth beyond"
            " their noise; give crack lengths in mm that grow ever faster"
        )
