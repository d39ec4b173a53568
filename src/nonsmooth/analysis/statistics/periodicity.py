"""The primitive period of points of a map, and what a motion does within it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.sweeps import REPEATS, primitive_periods, scales

__all__ = ["REPEATS", "nearest_return", "primitive_period", "scales", "whole_periods"]

Floats = npt.NDArray[np.float64]


def primitive_period(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, match: float
) -> int:
    """Smallest p with points that repeat after p steps, 0 where none is found.

    A drifting state repeats its steps. Points repeat where all states agree to ``match`` times
    their scale over all points, and p was seen `REPEATS` times.

    shapes: points (K, n), drifting (n,), scale (n,)
    """
    return int(primitive_periods(points[None], drifting, match, scale[None])[0])


def nearest_return(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, match: float
) -> tuple[int, float]:
    """The same with the residual: what is left of the scale after p steps.

    Where no p is found it is the least over all p.
    """
    least = np.inf
    if not np.all(np.isfinite(points)):
        return 0, least
    count = len(points)
    relative = points - np.where(drifting, points[0], 0.0)
    unit = np.where(scale > 0.0, scale, 1.0)
    for p in range(1, (count - 1) // REPEATS + 1):
        size = _largest_changes(relative, drifting, p)
        residual = float((size / unit).max(initial=0.0))
        if np.all(size <= match * scale):
            return p, residual
        least = min(least, residual)
    return 0, least


def whole_periods(count: int, period: Any) -> Any:
    """Steps in the last whole periods of so many; all of them where there is no period."""
    unit = np.maximum(period, 1)
    return count // unit * unit


def _largest_changes(relative: Floats, drifting: npt.NDArray[np.bool_], p: int) -> Floats:
    """Largest change of each state over p steps, of a drifting one from its first change."""
    change = relative[p:] - relative[:-p]
    change = np.where(drifting, change - change[0], change)
    return np.asarray(np.abs(change).max(axis=0))
