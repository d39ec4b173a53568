"""The primitive period of points of a map, and what a motion does within it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.sweeps import REPEATS, primitive_periods, scales

__all__ = ["REPEATS", "nearest_returns", "primitive_period", "scales", "whole_periods"]

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


def nearest_returns(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, match: float
) -> tuple[npt.NDArray[np.int64], Floats]:
    """The same of M motions with their residuals: what is left of the scale after p steps.

    Where no p is found the residual is the least over all p; of points that are not finite it is
    infinite.

    shapes: points (M, K, n), drifting (n,), scale (M, n); returns (M,) and (M,)
    """
    periods, residuals = np.zeros(len(points), np.int64), np.full(len(points), np.inf)
    left = np.flatnonzero(np.all(np.isfinite(points), axis=(1, 2)))
    relative = (points - np.where(drifting, points[:, :1], 0.0))[left]
    scale = scale[left]
    for p in range(1, (points.shape[1] - 1) // REPEATS + 1):
        if left.size == 0:
            break
        size = _largest_changes(relative, drifting, p)
        residual = (size / np.where(scale > 0.0, scale, 1.0)).max(axis=1, initial=0.0)
        repeats = np.all(size <= match * scale, axis=1)
        residuals[left] = np.where(repeats, residual, np.minimum(residuals[left], residual))
        if np.any(repeats):
            periods[left[repeats]] = p
            left, relative, scale = left[~repeats], relative[~repeats], scale[~repeats]
    return periods, residuals


def whole_periods(count: int, period: Any) -> Any:
    """Steps in the last whole periods of so many; all of them where there is no period."""
    unit = np.maximum(period, 1)
    return count // unit * unit


def _largest_changes(relative: Floats, drifting: npt.NDArray[np.bool_], p: int) -> Floats:
    """Largest change of each state over p steps, of a drifting one from its first change."""
    change = relative[:, p:] - relative[:, :-p]
    change = np.where(drifting, change - change[:, :1], change)
    return np.asarray(np.abs(change).max(axis=1))
