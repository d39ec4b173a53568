"""The primitive period of points of a map, and what a motion does within it.

A motion that spirals in with a multiplier near exp(2 pi i / p) repeats after p points to any
accuracy long before it repeats after one. So points that repeat after p > 1 of them show a period
only where they lie far apart beside the way that is left to go, see `settled_periods`.

A motion that has settled still does not repeat to the last digit: rounding keeps its points apart
by a floor that lies far above one unit in the last place where a state is small at the strobes and
large between them. Such differences do not contract, and lead nowhere: points whole periods apart
span no more over the whole record than over half of it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.extremes import state_maxima
from nonsmooth.engine.sweeps import REPEATS, primitive_periods, scales

__all__ = [
    "REPEATS", "nearest_returns", "primitive_period", "scales", "settled_periods", "whole_periods",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_APART = 30.0  # times the way that is left, and match, between different points of a period
_SLIGHT = 1e-3  # of the largest change, or of match: such a change tells no contraction
_TRAVELS = 1.75  # times the span of half a record; on a way that does not bend it is two or more
_ROUNDING = 64.0 * float(np.finfo(float).eps)  # of the largest state: no change over a period


def primitive_period(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, match: float
) -> int:
    """Smallest p with points that repeat after p steps, 0 where none is found.

    A drifting state repeats its steps. Points repeat where all states agree to ``match`` times
    their scale over all points, and p was seen `REPEATS` times.

    shapes: points (K, n), drifting (n,), scale (n,)
    """
    return int(primitive_periods(points[None], drifting, match, scale[None])[0])


def settled_periods(
    points: Floats,
    drifting: npt.NDArray[np.bool_],
    match: float,
    scale: Floats | None = None,
    natural: Floats | None = None,
) -> Integers:
    """Primitive period of each of M motions that have come as far as to show it, 0 for others.

    After p steps the points repeat to d, and a period of them earlier to d/q. So they are d/(1 - q)
    away from where they go. On the way to a shorter period r the change over r steps is at most
    twice that distance. A true period p has points much farther apart, and not the same to
    ``match``.

    shapes: points (M, K, n), drifting (n,), scale (M, n), that of `scales` without another one;
    natural (M, n): sizes of the states, of which some part is rounding; the largest of the points
    without them
    """
    scale = scales(points, drifting) if scale is None else scale
    sizes = state_maxima(np.abs(points - np.where(drifting, points[:, :1], 0.0)))
    if natural is not None:
        sizes = np.where(drifting, sizes, np.maximum(sizes, natural))
    periods = primitive_periods(points, drifting, match, scale)
    for p in np.unique(periods[periods > 1]).tolist():
        which = np.flatnonzero(periods == p)
        left = _way_left(points[which], drifting, scale[which], sizes[which], match, p)
        for r in _next_divisors(p):
            apart = _changes(points[which], drifting, scale[which], r)[:, -p:].max(axis=(1, 2))
            periods[which[~(apart > _APART * np.maximum(left, match))]] = 0
    return periods


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
    return np.asarray(state_maxima(np.abs(change)))


def _changes(points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, p: int) -> Floats:
    """Change of each state over p steps from each point on, in its scale; (M, K - p, n).

    The change of a drifting state is compared with its last one.
    """
    relative = points - np.where(drifting, points[:, :1], 0.0)
    change = relative[:, p:] - relative[:, :-p]
    change -= np.where(drifting, change[:, -1:], 0.0)
    return np.asarray(np.abs(change) / np.where(scale > 0.0, scale, 1.0)[:, None])


def _way_left(
    points: Floats,
    drifting: npt.NDArray[np.bool_],
    scale: Floats,
    sizes: Floats,
    match: float,
    p: int,
) -> Floats:
    """How far motions that repeat after p steps are from where they go, (M,) in their scales.

    Without any contraction it is infinite, unless nothing but rounding is left, or changes far
    below ``match`` that lead nowhere.
    """
    change = _changes(points, drifting, scale, p)
    rounding = _ROUNDING * sizes / np.where(scale > 0.0, scale, 1.0)
    left = state_maxima(change[:, -p:])
    is_rounding = np.all(left <= np.maximum(rounding, match * match), axis=1)
    span = _span_of_noise(points, drifting, scale, rounding, p)
    change = np.where(change > rounding[:, None], change, 0.0)
    way = change[:, change.shape[1] // 2 :].max(axis=(1, 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.where(way > 0.0, way / np.maximum(1.0 - _contraction(change, p), 0.0), 0.0)
    way = np.where(span <= _SLIGHT * match, span, way)
    return np.where(is_rounding, left.max(axis=1), way)


def _span_of_noise(
    points: Floats, drifting: npt.NDArray[np.bool_], scale: Floats, rounding: Floats, p: int
) -> Floats:
    """Largest distance of points whole periods apart, (M,); infinite where they travel.

    All states have to stay: near a turning point of a slow oscillation a position hardly moves, but
    the velocity does. It takes three periods to tell. Of a drifting state the steps are compared.
    """
    own = np.where(drifting, np.diff(points, axis=1), points[:, 1:])
    own /= np.where(scale > 0.0, scale, 1.0)[:, None]
    count = own.shape[1] // p
    if count < 3:
        return np.full(len(points), np.inf)
    periods = own[:, -count * p :].reshape(len(own), count, p, -1)
    half = (count + 1) // 2
    whole, first, last = (
        state_maxima(np.ptp(part, axis=1))
        for part in (periods, periods[:, :half], periods[:, -half:])
    )
    travels = whole > _TRAVELS * np.maximum(np.maximum(first, last), rounding)
    return np.where(np.any(travels, axis=1), np.inf, whole.max(axis=1))


def _contraction(change: Floats, p: int) -> Floats:
    """Part of the change that is left p steps later, (M,).

    Points are compared with those whole periods earlier, so that each has its like. States that
    turn into each other count alike, or their turning would look like a contraction. A fast part
    that dies away first would hide a slow one, so the second half of the record is asked again, and
    the slower contraction counts.
    """
    own = state_maxima(change)[:, None]
    size = np.maximum(own, _SLIGHT * own.max(axis=2, keepdims=True))
    change = np.linalg.norm(change / np.where(size > 0.0, size, 1.0), axis=2)
    count = change.shape[1]
    found = np.zeros(len(change))
    for part in (1, 2):
        looked_at = change[:, -max(count // part, p + 1) :]
        steps = max(looked_at.shape[1] // 2 // p, 1) * p
        earlier, later = looked_at[:, :-steps].max(axis=1), looked_at[:, steps:].max(axis=1)
        ratio = np.divide(later, earlier, out=np.zeros_like(later), where=earlier > 0.0)
        found = np.maximum(found, ratio ** (p / steps))
    return found


@cache
def _next_divisors(p: int) -> list[int]:
    """Largest proper divisors of p: one for each of its prime factors."""
    proper = [r for r in range(1, p) if p % r == 0]
    return [r for r in proper if not any(s > r and s % r == 0 for s in proper)]
