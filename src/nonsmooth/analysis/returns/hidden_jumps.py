"""Jumps between starts that do the same on their way, as where a motion just misses an impact."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.reduced_map import Branch, ReducedMap

__all__ = ["JUMP", "extent_of", "hidden_jumps"]

Floats = npt.NDArray[np.float64]

JUMP = 1e-6  # of the range of images; within rounding of a place only a jump moves them so far
_STRANGE = 8.0  # how much more than most pairs of starts one may differ from its slopes
_LEAST = 1e-6  # of the range, which slopes leave open in any case
_MOST = 64  # pairs that are looked at
_HALVINGS = 60
_CONSTANT = 1e-6  # beside images; a smaller range is not told from none
_WIDTH = 8.0 * float(np.finfo(float).eps)


def extent_of(image: Floats) -> float:
    """Range of images; of those that are all one but for rounding, something above that."""
    finite = image[np.isfinite(image)]
    if not finite.size:
        return 1.0
    size = float(np.abs(finite).max())
    return max(float(np.ptp(finite)), _CONSTANT * size) or 1.0


def hidden_jumps(
    reduced: ReducedMap, branch: Branch, same: npt.NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Pairs of values between which the map jumps; ``same`` are pairs in one piece so far.

    Where images differ from what slopes on both sides tell, the half with more of the change is
    kept, until it is gone or the interval is.
    """
    change = reduced.coordinate.change
    values, image, slope = branch.values, branch.image, branch.slope
    there = branch.images.there
    extent, span = extent_of(image), float(np.ptp(values))
    rise = change(np.diff(image))
    told = 0.5 * np.diff(values) * (slope[1:] + slope[:-1])
    off = np.where(np.isfinite(told), np.abs(rise - told), np.abs(rise))
    inner = same & there[1:] & there[:-1] & np.isfinite(off)
    usual = float(np.median(off[inner])) if inner.any() else 0.0
    pairs = np.flatnonzero(inner & (off > max(_STRANGE * usual, _LEAST * extent)))
    pairs = pairs[np.argsort(-off[pairs], kind="stable")][:_MOST]
    low, high = values[pairs], values[pairs + 1]
    left, right = image[pairs], image[pairs + 1]
    for _ in range(_HALVINGS):
        wide = high - low > _WIDTH * (np.abs(low) + span)
        kept = np.isfinite(left + right) & (np.abs(change(right - left)) > JUMP * extent)
        low, high, left, right = (part[kept] for part in (low, high, left, right))
        wide = wide[kept]
        if not wide.any():
            break
        middle = 0.5 * (low + high)
        found = reduced.at(middle, slopes=False).image
        first = np.abs(change(found - left)) > np.abs(change(right - found))
        high, right = np.where(wide & first, middle, high), np.where(wide & first, found, right)
        low, left = np.where(wide & ~first, middle, low), np.where(wide & ~first, found, left)
    order = np.argsort(low)
    return low[order], high[order]
