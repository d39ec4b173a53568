"""Stretches of equal labels, as rows of a table, with how far their branches drift."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.strobe_points import StrobePoints

__all__ = ["stretch_columns"]

Columns = dict[str, Any]
Floats = npt.NDArray[np.float64]


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
