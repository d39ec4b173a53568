"""Where pieces of a map of one coordinate meet: jumps, corners, roots, ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.hidden_jumps import JUMP, extent_of, hidden_jumps
from nonsmooth.analysis.returns.reduced_map import Branch, ReducedMap

__all__ = ["KINDS", "Borders", "border_kinds", "find_borders", "pieces"]

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

KINDS = ("jump", "corner", "root", "smooth", "end")
_MOST = 200  # borders that are looked for; where impacts accumulate there is no end of them
_WIDTH = 8.0 * float(np.finfo(float).eps)  # of a border, beside the values and the interval
_NEAR, _FAR = 1e-9, 1e-7  # of the interval: places beside a border that tell its kind
_STEEP = 30.0  # how much steeper a root is by the nearer place, or slopes by rounding
_BEND = 1e-5  # of slopes, above which they differ


class Borders(NamedTuple):
    """Pairs of values between which pieces meet."""

    low: Floats
    high: Floats
    complete: bool  # whether all were followed


def same_piece(branch: Branch) -> Flags:
    """Whether neighbouring starts do the same on their way; (L - 1,)."""
    images = branch.images
    same: Flags = images.status[1:] == images.status[:-1]
    return same & (images.exits[1:] == images.exits[:-1]) & (images.words[1:] == images.words[:-1])


def pieces(branch: Branch, borders: Borders) -> npt.NDArray[np.int64]:
    """Numbers of the pieces that starts lie in, -1 where there is no image."""
    fresh = ~same_piece(branch) | np.isin(branch.values[:-1], borders.low)
    number, there = np.concatenate([[0], np.cumsum(fresh)]), branch.images.there
    found = np.full(there.size, -1)
    found[there] = np.unique(number[there], return_inverse=True)[1]
    return found


def find_borders(reduced: ReducedMap, branch: Branch) -> Borders:
    """Borders between neighbouring starts, by halving all intervals at once."""
    values, span = branch.values, float(np.ptp(branch.values))
    there = branch.images.there
    gaps = np.flatnonzero(~same_piece(branch) & (there[1:] | there[:-1]))
    complete = gaps.size <= _MOST
    gaps = gaps[:_MOST]
    low, high = values[gaps], values[gaps + 1]
    keys = _keys(branch)
    left, right = keys[gaps], keys[gaps + 1]
    done: list[tuple[float, float]] = []
    while low.size:
        middle = 0.5 * (low + high)
        small = high - low <= _WIDTH * (np.abs(middle) + span)
        done += list(zip(low[small], high[small], strict=True))
        low, high, middle = low[~small], high[~small], middle[~small]
        left, right = left[~small], right[~small]
        if not low.size:
            break
        found = _keys(reduced.at(middle, slopes=False))
        # each half in which something changes goes on
        first = (found != left) & _matters(found, left)
        second = (found != right) & _matters(found, right)
        pairs = [(low, middle, left, found, first), (middle, high, found, right, second)]
        low, high, left, right = (
            np.concatenate([pair[k][pair[4]] for pair in pairs]) for k in range(4)
        )
        if low.size + len(done) > _MOST:
            complete, kept = False, max(0, _MOST - len(done))
            low, high, left, right = low[:kept], high[:kept], left[:kept], right[:kept]
    done += zip(*hidden_jumps(reduced, branch, same_piece(branch)), strict=True)
    done.sort()
    return Borders(np.array([a for a, _ in done]), np.array([b for _, b in done]), complete)


def border_kinds(reduced: ReducedMap, borders: Borders, branch: Branch) -> list[str]:
    """What happens at each border, by the map on both sides of it.

    A jump stays however near; at a root the slope grows as one over the root of the distance.
    """
    if not borders.low.size:
        return []
    coordinate, span = reduced.coordinate, float(np.ptp(branch.values))
    extent = extent_of(branch.image)
    sides = [(borders.low, -span), (borders.high, span)]
    at = [reduced.at(place) for place, _ in sides]
    near = [reduced.at(place + _NEAR * way) for place, way in sides]
    far = [reduced.at(place + _FAR * way) for place, way in sides]
    kinds = []
    for i in range(borders.low.size):
        if not (at[0].images.there[i] and at[1].images.there[i]):
            kinds.append("end")
            continue
        steep = [abs(n.slope[i]) > 3.0 * abs(f.slope[i]) for n, f in zip(near, far, strict=True)]
        grows = [abs(a.slope[i]) > _STEEP * abs(n.slope[i]) for a, n in zip(at, near, strict=True)]
        root = any(s and g for s, g in zip(steep, grows, strict=True))
        change = float(coordinate.change(at[1].image[i : i + 1] - at[0].image[i : i + 1])[0])
        if abs(change) > (JUMP if root else _NEAR) * extent:
            kinds.append("jump")
        elif root:
            kinds.append("root")
        else:
            one, other = near[0].slope[i], near[1].slope[i]
            bends = abs(one - other) > _BEND * max(abs(one), abs(other), extent / span)
            kinds.append("corner" if bends else "smooth")
    return kinds


def _keys(branch: Branch) -> npt.NDArray[np.str_]:
    """What starts do on their way, as one text each."""
    images = branch.images
    there = np.where(images.there, "+", "-")
    return np.char.add(there, np.char.add(images.words, np.char.add("|", images.exits)))


def _matters(one: npt.NDArray[np.str_], other: npt.NDArray[np.str_]) -> Flags:
    """Whether one of two starts has an image."""
    found: Flags = np.char.startswith(one, "+") | np.char.startswith(other, "+")
    return found
