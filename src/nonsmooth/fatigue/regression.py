"""A straight line through readings, and the tests whether they follow it or another curve."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nonsmooth.fatigue.checks import Array

__all__ = ["Line", "curvature", "far_off", "outlying", "straight_line"]


class Line(NamedTuple):
    """A fitted line with standard errors; ``residual`` is the standard deviation from it."""

    constant: float
    slope: float
    constant_error: float
    slope_error: float
    residual: float


def straight_line(x: Array, y: Array) -> Line:
    """Least squares with errors in y alone."""
    middle = x.mean()
    spread = float(np.sum((x - middle) ** 2))
    slope = float(np.sum((x - middle) * (y - y.mean()))) / spread
    rest = y - y.mean() - slope * (x - middle)
    residual = math.sqrt(float(rest @ rest) / (x.size - 2))
    constant_error = residual * math.sqrt(1.0 / x.size + middle**2 / spread)
    constant = float(y.mean() - slope * middle)
    return Line(constant, slope, constant_error, residual / math.sqrt(spread), residual)


def curvature(x: Array, y: Array, line: Line) -> tuple[float, float]:
    """Largest distance of the parabola from the line, and its chance by noise (F test)."""
    from scipy.stats import f

    # in a variable of order one, orthogonal to the line, so that the rest of it stays
    z = (x - x.mean()) / np.ptp(x)
    basis = np.stack([np.ones_like(z), z], axis=1)
    wave = z**2 - basis @ np.linalg.lstsq(basis, z**2, rcond=None)[0]
    rest = y - line.constant - line.slope * x
    share = float(wave @ rest) / float(wave @ wave)
    bent = share * wave
    left = float(np.sum((rest - bent) ** 2))
    freedom = x.size - 3
    bend = float(np.abs(bent).max())
    noise = np.spacing(float(np.abs(y).max())) * math.sqrt(x.size)
    if math.sqrt(left) <= noise:  # exact numbers: what is left is rounding
        return bend, 1.0 if bend <= 4.0 * noise else 0.0
    return bend, float(f.sf(float(bent @ bent) / (left / freedom), 1, freedom))


def outlying(x: Array, y: Array, line: Line, level: float) -> list[int]:
    """Readings that noise puts off a line with less than this chance, for all of them together."""
    rest = y - line.constant - line.slope * x
    leverage = 1.0 / x.size + (x - x.mean()) ** 2 / np.sum((x - x.mean()) ** 2)
    return far_off(rest, leverage, 2, level, 4.0 * np.spacing(float(np.abs(y).max())))


def far_off(
    rest: Array, leverage: Array, constants: int, level: float, rounding: float
) -> list[int]:
    """Places of residuals that noise makes so large with less than this chance, largest first.

    Each reading is compared with the fit to the others (externally studentised residuals), at the
    level over their number (Bonferroni). Below the rounding nothing is told.
    """
    from scipy.stats import t

    freedom = rest.size - constants - 1
    weight = np.maximum(1.0 - leverage, 1e-12)
    total = float(rest @ rest)
    others = np.maximum(total - rest**2 / weight, 0.0) / freedom
    floor = rounding**2 + 1e-14 * total
    away = np.abs(rest) / np.sqrt(weight * np.maximum(others, floor))
    limit = float(t.isf(0.5 * level / rest.size, freedom))
    order = np.argsort(-away)
    return [int(k) for k in order if away[k] > limit]
