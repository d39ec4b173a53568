"""Borders and fixed points of a map of one coordinate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.reduced_map import (
    JUMP,
    MappedStarts,
    ReducedMap,
    extent_of,
    hidden_jumps,
    some_values,
)

__all__ = ["border_kinds", "find_borders", "find_fixed_points", "pieces"]

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

KINDS = ("jump", "corner", "root", "smooth", "end")
_MOST = 200  # borders that are looked for; where impacts accumulate there is no end of them
_WIDTH = 8.0 * float(np.finfo(float).eps)  # of a border, beside the values and the interval
# of the interval: places beside a border. Starts nearer than 1e-12 of their size count as on it
_NEAREST, _NEAR, _FAR = 1e-11, 1e-9, 1e-7
_STEEP = 3.0  # how much steeper a root is from place to place, at least; it is 10 times
_BEND = 1e-5  # of slopes, above which they differ

Integers = npt.NDArray[np.int64]

_STEPS = 80
_RESIDUAL = 1e-9  # beside value and interval; a jump that no two starts told has a larger one
_ROUNDING = 4.0 * float(np.finfo(float).eps)


class Borders(NamedTuple):
    """Pairs of values between which pieces meet."""

    low: Floats
    high: Floats
    complete: bool  # whether all were followed


def same_piece(branch: MappedStarts) -> Flags:
    """Whether neighbouring starts do the same on their way; (L - 1,)."""
    images = branch.images
    same: Flags = images.status[1:] == images.status[:-1]
    return same & (images.exits[1:] == images.exits[:-1]) & (images.words[1:] == images.words[:-1])


def pieces(branch: MappedStarts, borders: Borders) -> npt.NDArray[np.int64]:
    """Numbers of the pieces that starts lie in, -1 where there is no image."""
    fresh = ~same_piece(branch) | np.isin(branch.values[:-1], borders.low)
    number, there = np.concatenate([[0], np.cumsum(fresh)]), branch.images.there
    found = np.full(there.size, -1)
    found[there] = np.unique(number[there], return_inverse=True)[1]
    return found


def find_borders(reduced: ReducedMap, branch: MappedStarts) -> Borders:
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


def border_kinds(reduced: ReducedMap, borders: Borders, branch: MappedStarts) -> list[str]:
    """What happens at each border, by the map on both sides of it.

    A jump stays however near; at a root the slope grows as one over the root of the distance.
    """
    if not borders.low.size:
        return []
    coordinate, span = reduced.coordinate, float(np.ptp(branch.values))
    extent = extent_of(branch.image)
    sides = [(borders.low, -span), (borders.high, span)]
    at = [reduced.at(place) for place, _ in sides]
    # not at the border itself: a formula that ends there may have no derivative
    nearest = [
        reduced.at(place + _NEAREST * (way + np.sign(way) * np.abs(place))) for place, way in sides
    ]
    near = [reduced.at(place + _NEAR * way) for place, way in sides]
    far = [reduced.at(place + _FAR * way) for place, way in sides]
    kinds = []
    for i in range(borders.low.size):
        if not (at[0].images.there[i] and at[1].images.there[i]):
            kinds.append("end")
            continue
        root = any(
            abs(there.slope[i]) > _STEEP * abs(close.slope[i])
            and abs(close.slope[i]) > _STEEP * abs(away.slope[i])
            for there, close, away in zip(nearest, near, far, strict=True)
        )
        change = float(coordinate.change(at[1].image[i : i + 1] - at[0].image[i : i + 1])[0])
        if abs(change) > (JUMP if root else _NEAR) * extent:
            kinds.append("jump")
        elif root:
            kinds.append("root")
        else:
            one, other = nearest[0].slope[i], nearest[1].slope[i]
            bends = abs(one - other) > _BEND * max(abs(one), abs(other), extent / span)
            kinds.append("corner" if bends else "smooth")
    return kinds


def _keys(branch: MappedStarts) -> npt.NDArray[np.str_]:
    """What starts do on their way, as one text each."""
    images = branch.images
    there = np.where(images.there, "+", "-")
    return np.char.add(there, np.char.add(images.words, np.char.add("|", images.exits)))


def _matters(one: npt.NDArray[np.str_], other: npt.NDArray[np.str_]) -> Flags:
    """Whether one of two starts has an image."""
    found: Flags = np.char.startswith(one, "+") | np.char.startswith(other, "+")
    return found


def find_fixed_points(reduced: ReducedMap, branch: MappedStarts, piece: Integers) -> MappedStarts:
    """The map at its fixed points, in order; ``piece`` are the pieces that starts lie in."""
    low, high, below = _brackets(reduced, branch, piece[1:] == piece[:-1])
    roots = _refined(reduced, low, high, below) if low.size else low
    change = reduced.coordinate.change(branch.image - branch.values)
    exact = branch.values[branch.images.there & (change == 0.0)]
    found = reduced.at(np.unique(np.concatenate([roots, exact])))
    size = np.abs(found.values) + float(np.ptp(branch.values))
    return some_values(found, np.abs(_change(reduced, found)) <= _RESIDUAL * size)


def _brackets(
    reduced: ReducedMap, branch: MappedStarts, same: npt.NDArray[np.bool_]
) -> tuple[Floats, Floats, Floats]:
    """Intervals over which the map crosses the diagonal, and the sign at their low ends.

    Between two starts on one side of it, the cubic through values and slopes tells where it
    comes nearest, and the map there whether it comes through.
    """
    x, change = branch.values, _change(reduced, branch)
    inner = same & branch.images.there[1:] & np.isfinite(change[1:] + change[:-1])
    turn = reduced.coordinate.turn
    if turn is not None:  # the other side of the circle is no crossing
        inner &= (np.abs(change[1:]) < 0.25 * turn) & (np.abs(change[:-1]) < 0.25 * turn)
    crosses = inner & (change[1:] * change[:-1] < 0.0)
    here = np.flatnonzero(crosses)
    low, high, below = [x[here]], [x[here + 1]], [np.sign(change[here])]
    near = np.flatnonzero(inner & ~crosses & (change[1:] * change[:-1] > 0.0))
    place = _turning(x, change, branch.slope - 1.0, near)
    near, place = near[np.isfinite(place)], place[np.isfinite(place)]
    if place.size:
        middle = _change(reduced, reduced.at(place, slopes=False))
        through = middle * change[near] < 0.0
        near, place, middle = near[through], place[through], middle[through]
        low += [x[near], place]
        high += [place, x[near + 1]]
        below += [np.sign(change[near]), np.sign(middle)]
    return np.concatenate(low), np.concatenate(high), np.concatenate(below)


def _turning(x: Floats, change: Floats, slope: Floats, near: npt.NDArray[np.int64]) -> Floats:
    """Where the cubic between two starts is nearest to zero, nan where it is so at an end."""
    width = x[near + 1] - x[near]
    rise, first, last = change[near + 1] - change[near], slope[near], slope[near + 1]
    first, last = first * width, last * width
    a, b, c = 3.0 * (first + last - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * first - last), first
    with np.errstate(all="ignore"):
        root = np.sqrt(b * b - 4.0 * a * c)
        q = -0.5 * (b + np.copysign(root, b))
        both = np.stack([q / a, c / q])
        inside = (both > 0.0) & (both < 1.0)
        both = np.where(inside, both, np.nan)
        t = both
        value = np.abs(change[near] + t * (first + t * (0.5 * b + t * a / 3.0)))
    value = np.where(np.isfinite(value), value, np.inf)
    best = np.take_along_axis(both, value.argmin(axis=0)[None], axis=0)[0]
    # it must come toward the diagonal from both ends
    toward = (first * change[near] < 0.0) & (last * change[near] > 0.0)
    found: Floats = np.where(toward, x[near] + best * width, np.nan)
    return found


def _refined(reduced: ReducedMap, low: Floats, high: Floats, below: Floats) -> Floats:
    """Newton's method, kept within the brackets; values that are lost are left out."""
    low, high = low.copy(), high.copy()
    guess, open_ = 0.5 * (low + high), np.ones(low.size, bool)
    for _ in range(_STEPS):
        here = np.flatnonzero(open_)
        if not here.size:
            break
        branch = reduced.at(guess[here])
        change = _change(reduced, branch)
        lost = ~np.isfinite(change)
        guess[here[lost]] = np.nan
        side = np.sign(change) == below[here]
        low[here] = np.where(side, guess[here], low[here])
        high[here] = np.where(side, high[here], guess[here])
        with np.errstate(all="ignore"):
            step = guess[here] - change / (branch.slope - 1.0)
        inside = (step > low[here]) & (step < high[here])
        middle = 0.5 * (low[here] + high[here])
        fresh = np.where(inside, step, middle)
        still = (change != 0.0) & ~lost & (high[here] - low[here] > _ROUNDING * np.abs(middle))
        moved = np.abs(fresh - guess[here]) > _ROUNDING * np.maximum(np.abs(fresh), 1e-300)
        open_[here] = still & moved
        guess[here] = np.where(still & ~lost, fresh, guess[here])
    return guess[np.isfinite(guess)]


def _change(reduced: ReducedMap, branch: MappedStarts) -> Floats:
    """How far images are from their starts, by the shorter way around."""
    return reduced.coordinate.change(branch.image - branch.values)
