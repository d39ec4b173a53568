"""Stretches of equal labels, as rows of a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.strobe_points import StrobePoints

__all__ = ["stretch_columns"]

Columns = dict[str, Any]


def stretch_columns(
    points: StrobePoints, periods: npt.NDArray[np.int64], parameters: Sequence[str]
) -> Columns:
    """Columns over ``stretch``: where each begins and ends, and its period."""
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
    return columns


def period_words() -> dict[str, str]:
    """Attributes of a period in strobes."""
    return {"long_name": "local period, 0 where there is none", "units": "1"}


def _words(points: StrobePoints, name: str) -> dict[str, str]:
    words = points.data[name].attrs
    found = {"long_name": str(words.get("long_name") or name)}
    return found | ({"units": str(words["units"])} if "units" in words else {})
