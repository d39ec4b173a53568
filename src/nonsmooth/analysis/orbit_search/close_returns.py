"""Where motions come nearly back: guesses of orbits, in the order in which they are tried."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.orbit_search.motions import Motion

__all__ = ["Return", "close_returns", "returns_in_turn", "spread_of"]

Floats = npt.NDArray[np.float64]

_LOOKED_AT = 40  # returns that are put in order for each guess that is wanted
_APART = 0.01  # of the spread: guesses of one word that are closer are taken for one
_OUTER = 0.01  # part of the points on either side that the spread leaves out


class Return(NamedTuple):
    """A motion that comes nearly back to its point ``i`` at its point ``j``."""

    motion: int
    i: int
    j: int
    gap: float  # beside the spread of the points


def spread_of(motions: Sequence[Motion], drifting: npt.NDArray[np.bool_]) -> Floats:
    """What counts as large for each state; infinite for drifts."""
    parts = [each for motion in motions for each in (motion.points, motion.event_states)]
    points = np.concatenate(parts)
    if not len(points):
        return np.where(drifting, np.inf, 1.0)
    low, high = np.quantile(points, [_OUTER, 1.0 - _OUTER], axis=0)
    spread = np.where(drifting, 0.0, high - low)
    # a state that hardly moves, beside one that does
    size = np.abs(np.where(drifting, 0.0, points)).max(initial=1e-12)
    least = np.maximum(1e-6 * spread.max(), 1e-9 * size)
    return np.where(drifting, np.inf, np.maximum(spread, least))


def close_returns(motions: Sequence[Motion], n: int, spread: Floats, most: int) -> list[Return]:
    """Returns after n points of one kind, the closest first; at most so many."""
    numbers, first, last, gaps = [], [], [], []
    for number, motion in enumerate(motions):
        for kind in np.unique(motion.kinds):
            places = np.flatnonzero(motion.kinds == kind)
            if places.size <= n:
                continue
            i, j = places[:-n], places[n:]
            gap = (np.abs(motion.points[j] - motion.points[i]) / spread).max(axis=1)
            numbers.append(np.full(i.size, number))
            first.append(i)
            last.append(j)
            gaps.append(gap)
    if not gaps:
        return []
    gap = np.concatenate(gaps)
    gap = np.where(np.isfinite(gap), gap, np.inf)
    order = np.argsort(gap, kind="stable")[: _LOOKED_AT * most]
    columns = (np.concatenate(numbers)[order], np.concatenate(first)[order],
               np.concatenate(last)[order], gap[order])  # fmt: skip
    return [Return(int(a), int(b), int(c), float(d)) for a, b, c, d in zip(*columns, strict=True)]


def returns_in_turn(
    motions: Sequence[Motion], returns: Sequence[Return], spread: Floats
) -> Iterator[Return]:
    """Each word's closest return, then the next closest ones, and so on.

    Of returns with one word that begin at nearly the same point, the closest one is taken.
    """
    groups: dict[bytes, list[Return]] = {}
    for each in returns:
        key = motions[each.motion].word_key(each.i, each.j)
        groups.setdefault(key, []).append(each)
    tried: dict[bytes, list[Floats]] = {key: [] for key in groups}
    queues = {key: iter(group) for key, group in groups.items()}
    while queues:
        for key in list(queues):
            for each in queues[key]:
                point = motions[each.motion].points[each.i] / spread
                known = tried[key]
                if known and np.abs(np.array(known) - point).max(axis=1).min() < _APART:
                    continue
                known.append(point)
                yield each
                break
            else:
                del queues[key]
