"""Straight lines through logarithms, with an error that knows that counts are correlated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["PowerLaw", "fit_power_law", "leave_one_out_error"]

Vector = npt.NDArray[np.float64]


class PowerLaw(NamedTuple):
    """The law ``factor * size**exponent``; nan where fewer than two counts are positive."""

    exponent: float
    factor: float
    scatter: float  # standard error of the exponent, from the distances to the line
    bend: float  # half the difference between the lines through either half of the sizes

    def at(self, sizes: Vector) -> Vector:
        """Values of the law."""
        return self.factor * sizes**self.exponent


def fit_power_law(sizes: Vector, values: Vector) -> PowerLaw:
    """Least squares of the logarithms, all with the same weight; zeros are left out."""
    used = (values > 0.0) & np.isfinite(values)
    count = int(np.count_nonzero(used))
    if count < 2:
        return PowerLaw(np.nan, np.nan, np.nan, np.nan)
    x, y = np.log(sizes[used]), np.log(values[used])
    slope, rest = _line(x, y)
    constant = float(np.exp(y.mean() - slope * x.mean()))
    if count == 2:
        return PowerLaw(slope, constant, np.nan, np.nan)
    scatter = np.sqrt(float(rest @ rest) / (count - 2)) / (x.std() * np.sqrt(count))
    middle = count // 2
    lower, _ = _line(x[: middle + 1], y[: middle + 1])
    upper, _ = _line(x[middle:], y[middle:])
    return PowerLaw(slope, constant, float(scatter), abs(upper - lower) / 2.0)


def _line(x: Vector, y: Vector) -> tuple[float, Vector]:
    """Slope of the line of least squares, and what lies off it."""
    away = x - x.mean()
    slope = float(away @ y) / float(away @ away)
    return slope, y - y.mean() - slope * away


def leave_one_out_error(estimates: Vector) -> float:
    """Jackknife error out of estimates, each of which has left out one block.

    Counts at several sizes share their cells, so they scatter together; leaving out whole
    blocks keeps that. M. H. Quenouille (1956); for dependent data H. R. Kuensch (1989).
    """
    finite = estimates[np.isfinite(estimates)]
    if finite.size < 2:
        return float("nan")
    away = finite - finite.mean()
    return float(np.sqrt((finite.size - 1) / finite.size * (away @ away)))
