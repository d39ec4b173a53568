"""Which event of a motion a picked one is.

Both are instants in order. Where there are as many of one as of the other they belong together in
order, however far apart they still are. Otherwise two belong together if each is the nearest of the
other, which keeps the order.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["matched_to"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def matched_to(picked: Floats, found: Floats, wait: float, *, repeats: bool) -> Integers:
    """Place of the event of the motion that each picked one is, -1 for none within ``wait``.

    Where the motion ``repeats`` itself, each of its events may have been picked many times.

    shapes: picked (E,) and found (F,) in order; returns (E,)
    """
    if not found.size or not picked.size:
        return np.full(picked.size, -1)
    if picked.size == found.size and not repeats:
        return np.arange(picked.size)
    nearest = _nearest(picked, found)
    if not repeats:
        mutual = _nearest(found, picked)[nearest] == np.arange(picked.size)
        nearest = np.where(mutual, nearest, -1)
    near = np.abs(picked - found[nearest]) < wait
    return np.where(near & (nearest >= 0), nearest, -1)


def _nearest(these: Floats, those: Floats) -> Integers:
    """Place of the nearest of those for each of these."""
    behind = np.clip(np.searchsorted(those, these), 0, those.size - 1)
    before = np.maximum(behind - 1, 0)
    is_before = np.abs(these - those[before]) <= np.abs(those[behind] - these)
    nearest: Integers = np.where(is_before, before, behind)
    return nearest
