"""Which periods the points of a drifting motion follow, and the stretches of equal ones as a table.

Points of period n are n interleaved sequences, the branches. While a parameter drifts slowly each
of them is a smooth curve, so a straight line fits what a window holds of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.strobe_points import StrobePoints

__all__ = [
    "LEAST_VISITS",
    "local_periods",
    "stretch_columns",
]

Columns = dict[str, Any]
Flags = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

LEAST_VISITS = 4  # of each branch in a window; a line through two or three fits too easily
_MERGING = 0.5  # of their distance by which branches may come closer, or part, within a window
_APART = 2.0  # times what lines leave of branches, and these are branches at all


def stretch_columns(
    points: StrobePoints,
    periods: npt.NDArray[np.int64],
    parameters: Sequence[str],
    scaled: Floats,
    window: int,
) -> Columns:
    """Columns over ``stretch``: where each begins and ends, its period, and how far it drifts.

    scaled: (K, d), the points in units of their spread
    """
    first = np.flatnonzero(np.diff(periods, prepend=-1))
    last = np.append(first[1:], periods.size) - 1
    columns: Columns = {
        "first": ("stretch", first, {"long_name": "number of the first point"}),
        "last": ("stretch", last, {"long_name": "number of the last point"}),
    }
    for name in ("time", *parameters):
        if name not in points.data or points.data[name].dims != (points.dim,):
            continue
        values, words = points.data[name].values, _words(points, name)
        for key, place in (("from", first), ("to", last)):
            label = f"{key} {words['long_name']}"
            columns[f"{key}_{name}"] = ("stretch", values[place], words | {"long_name": label})
    columns["stretch_period"] = ("stretch", periods[first], period_words())
    columns["regime"] = (
        "stretch", np.where(periods[first] > 0, "periodic", "aperiodic"), {"long_name": "regime"},
    )  # fmt: skip
    pairs = zip(first, last, periods[first], strict=True)
    ways = np.array([_drift(scaled[a : b + 1], n, window) for a, b, n in pairs])
    for key, values, label in (
        ("drift", ways[:, 0], "way of the branches, in parts of the spread"),
        ("net_drift", ways[:, 1], "distance from begin to end of the branches, likewise"),
    ):
        columns[key] = ("stretch", values, {"long_name": label})
    return columns


def _drift(points: Floats, period: int, window: int) -> tuple[float, float]:
    """Way that branches take, and the distance it leads to, on the average over branches.

    Means over windows are compared, as what lines leave of single points would add up to a way.
    nan where there is no period.
    """
    if period == 0:
        return np.nan, np.nan
    visits = len(points) // period
    block = min(max(window // period, 1), max(visits // 2, 1))
    blocks = visits // block
    if blocks < 2:
        return 0.0, 0.0
    kept = points[: blocks * block * period].reshape(blocks, block, period, -1)
    means = kept.mean(axis=1)  # (block, branch, variable)
    steps = np.linalg.norm(np.diff(means, axis=0), axis=2).sum(axis=0)
    net = np.linalg.norm(means[-1] - means[0], axis=1)
    return float(steps.mean()), float(net.mean())


def period_words() -> dict[str, str]:
    """Attributes of a period in strobes."""
    return {"long_name": "local period, 0 where there is none"}


def _words(points: StrobePoints, name: str) -> dict[str, str]:
    words = points.data[name].attrs
    found = {"long_name": str(words.get("long_name") or name)}
    return found | ({"units": str(words["units"])} if "units" in words else {})


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
