"""Fixed points of a map of one coordinate, bracketed between starts and refined."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.reduced_map import Branch, ReducedMap, some_values

__all__ = ["find_fixed_points"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_STEPS = 80
_RESIDUAL = 1e-9  # beside value and interval; a jump that no two starts told has a larger one
_ROUNDING = 4.0 * float(np.finfo(float).eps)


def find_fixed_points(reduced: ReducedMap, branch: Branch, piece: Integers) -> Branch:
    """The map at its fixed points, in order; ``piece`` are the pieces that starts lie in."""
    low, high, below = _brackets(reduced, branch, piece[1:] == piece[:-1])
    roots = _refined(reduced, low, high, below) if low.size else low
    change = reduced.coordinate.change(branch.image - branch.values)
    exact = branch.values[branch.images.there & (change == 0.0)]
    found = reduced.at(np.unique(np.concatenate([roots, exact])))
    size = np.abs(found.values) + float(np.ptp(branch.values))
    return some_values(found, np.abs(_change(reduced, found)) <= _RESIDUAL * size)


def _brackets(
    reduced: ReducedMap, branch: Branch, same: npt.NDArray[np.bool_]
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


def _change(reduced: ReducedMap, branch: Branch) -> Floats:
    """How far images are from their starts, by the shorter way around."""
    return reduced.coordinate.change(branch.image - branch.values)
