"""The primitive period of points of a map, and what a motion does within it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["REPEATS", "nearest_return", "primitive_period", "scales", "whole_periods"]

Floats = npt.NDArray[np.float64]
REPEATS = 2  # times that a period must be seen to be believed


def scales(points: Floats, drifting: npt.NDArray[np.bool_]) -> Floats:
    """What a difference of each state is compared with: its largest size, or step of a drift.

    shapes: points (K, n), drifting (n,)
    """
    moving = np.abs(np.diff(points, axis=0)).max(axis=0, initial=0.0)
    return np.where(drifting, moving, np.abs(points).max(axis=0, initial=0.0))


def primitive_period(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, match: float
) -> int:
    """Smallest p with points that repeat after p steps, 0 where none is found.

    A drifting state repeats its steps. Points repeat where all states agree to ``match`` times
    their scale over all points, and p was seen `REPEATS` times.

    shapes: points (K, n), drifting (n,), scale (n,)
    """
    if not np.all(np.isfinite(points)):
        return 0
    relative = points - np.where(drifting, points[0], 0.0)
    # most steps are ruled out by the last point alone
    longest = (len(points) - 1) // REPEATS
    last = np.abs(points[len(points) - 1 - longest : -1] - points[-1]) <= match * scale
    for p in (1 + np.flatnonzero(np.all(last | drifting, axis=1)[::-1])).tolist():
        if np.all(_largest_changes(relative, drifting, p) <= match * scale):
            return p
    return 0


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


def whole_periods(count: int, period: int) -> int:
    """Steps in the last whole periods of so many; all of them where there is no period."""
    return count // period * period if period else count


def _largest_changes(relative: Floats, drifting: npt.NDArray[np.bool_], p: int) -> Floats:
    """Largest change of each state over p steps, of a drifting one from its first change."""
    change = relative[p:] - relative[:-p]
    change = np.where(drifting, change - change[0], change)
    return np.asarray(np.abs(change).max(axis=0))
