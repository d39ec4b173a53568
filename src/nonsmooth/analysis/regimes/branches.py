"""Branches of a drifting motion: which periods the points of a map follow, window by window.

Points of period n are n interleaved sequences, the branches. While a parameter drifts slowly each
of them is a smooth curve, so a straight line fits what a window holds of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["LEAST_VISITS", "local_periods"]

LEAST_VISITS = 4  # of each branch in a window; a line through two or three fits too easily
_MERGING = 0.5  # of their distance by which branches may come closer, or part, within a window
_APART = 2.0  # times what lines leave of branches, and these are branches at all

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


class _Lines(NamedTuple):
    """Lines through every n-th point from each point on; over (variable, first point)."""

    visits: int
    misfit: Floats  # root mean square of what a line leaves
    mean: Floats
    slope: Floats  # per visit


def local_periods(points: Floats, window: int, most_period: int, tolerance: float) -> npt.NDArray:
    """Least period that the points about each one follow, 0 where there is none.

    A window follows period n when lines fit all its n branches to the tolerance, and branches that
    a part of n would join lie apart by more than what the lines leave, and neither merge nor part
    quickly: those of a motion that settles with a multiplier near -1 do. A point has the least
    period of all windows that hold it, so labels reach to the very change of a regime.

    points: (K, d) in units in which the tolerance is meant; K at least ``window``
    """
    columns = np.ascontiguousarray(points.T)
    count = len(points)
    periods = np.zeros(count, np.int64)
    for n in range(1, most_period + 1):
        lines = _lines(columns, n, window // n)
        follows = _all_of(np.all(lines.misfit <= tolerance, axis=0), n)
        for part in (n // p for p in range(2, n + 1) if n % p == 0 and _is_prime(p)):
            follows &= _stay_apart(lines, n, part, tolerance)[: follows.size]
        covered = _covered(follows, n * lines.visits, count)
        periods[(periods == 0) & covered] = n
    return periods


def _lines(columns: Floats, n: int, visits: int) -> _Lines:
    """Straight lines by least squares, one through every first point and its followers."""
    size = columns.shape[1] - n * (visits - 1)
    base = columns[:, :size]
    middle = 0.5 * (visits - 1)
    total, moment, squares = (np.zeros_like(base) for _ in range(3))
    for i in range(1, visits):
        # less the first point: squares of what is large would drown what is left of it
        away = columns[:, n * i : n * i + size] - base
        total += away
        moment += (i - middle) * away
        squares += away * away
    spread = visits * (visits * visits - 1) / 12.0
    left = squares - total * total / visits - moment * moment / spread
    return _Lines(
        visits, np.sqrt(np.maximum(left, 0.0) / visits), base + total / visits, moment / spread
    )


def _all_of(flags: Flags, n: int) -> Flags:
    """Whether n flags in a row hold, from each place on."""
    return _sums(flags, n) == n


def _stay_apart(lines: _Lines, n: int, part: int, tolerance: float) -> Flags:
    """Whether branches that a shorter period would join are apart, and keep their distance."""
    along = lines.slope[:, :-part] * (part / n)  # what the drift alone would do
    distance = lines.mean[:, part:] - lines.mean[:, :-part] - along
    change = (lines.slope[:, part:] - lines.slope[:, :-part]) * lines.visits
    parting, apart, left = (
        _sums((values * values).sum(axis=0), n - part)
        for values in (change, distance, lines.misfit[:, :-part])
    )
    least = np.maximum(_APART**2 * left, tolerance * tolerance)
    return np.asarray((parting <= _MERGING**2 * apart) & (apart >= least))


def _covered(windows: Flags, length: int, count: int) -> Flags:
    """Points that lie in a window that holds."""
    edges = np.zeros(count + 1, np.int64)
    starts = np.flatnonzero(windows)
    np.add.at(edges, starts, 1)
    np.add.at(edges, starts + length, -1)
    return np.asarray(np.cumsum(edges[:-1]) > 0)


def _sums(values: npt.NDArray, n: int) -> npt.NDArray:
    """Sums of n values in a row, from each place on; added up afresh, so that none is lost."""
    size = values.size - n + 1
    found = np.zeros(max(size, 0), np.int64 if values.dtype == bool else np.float64)
    for i in range(n):
        found += values[i : i + size]
    return found


def _is_prime(p: int) -> bool:
    return all(p % k for k in range(2, int(p**0.5) + 1))
