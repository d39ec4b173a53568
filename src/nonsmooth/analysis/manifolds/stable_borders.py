"""Borders on a stable manifold: places between points with different itineraries."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.curve import FADES, SMOOTH, turn_between
from nonsmooth.analysis.manifolds.known_curve import KnownCurve, left_of
from nonsmooth.analysis.manifolds.local_map import LocalMap

__all__ = ["BorderPair", "find_borders"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROUNDS = 60  # of halvings
_SHARP = 0.5  # difference of directions from which a corner is a wedge
_REACH = 4.0  # of a step: how far the tip of a wedge may lie
_WIDER = (1.0, 4.0, 16.0)  # that lines across the curve are made, where they do not meet it
_CLOSED = 1e-9  # of a step: the two points of a border that is located
_BESIDE = 1e-4  # of a step: where directions beside a border are taken
_FARTHER = 100.0  # times as far, where the curve turns as much if the turn is that of a corner
_FAR = 1e6  # roundings that a step has at least which tells a direction


class BorderPair(NamedTuple):
    """Two points of a curve, in its order, with a border between them."""

    low: Floats
    high: Floats
    kind: str
    turn: float
    gap: float


def find_borders(
    here: LocalMap, known: KnownCurve, first: int, report: Callable[[], None]
) -> dict[int, BorderPair]:
    """Borders by the number of the piece in which they lie, from a piece on."""
    pieces = np.arange(first, len(known.sizes))
    depths = known.depths
    counts = np.maximum(np.maximum(depths[pieces], depths[pieces + 1]), 1)
    low_keys, high_keys = np.zeros((2, counts.size), np.int64)
    for count in np.unique(counts):
        some = np.flatnonzero(counts == count)
        ends = np.concatenate([known.points[pieces[some]], known.points[pieces[some] + 1]])
        low_keys[some], high_keys[some] = np.split(here.itineraries(ends, int(count)).keys, 2)
    # a start at the edge that is reset at once has that reset in its itinerary, and no border
    begins = np.append(False, known.cut[:-1])
    at = np.flatnonzero((low_keys != high_keys) & ~(known.cut | begins)[pieces])
    if not at.size:
        return {}
    search = _BorderSearch(here, known, pieces[at], counts[at], report)
    pairs = search.run(low_keys[at])
    return dict(zip(pieces[at].tolist(), pairs, strict=True))


class _BorderSearch:
    """Halves pieces of a curve between points with different itineraries.

    At a sharp corner both ends of a piece lie on the sides of a wedge, and the line on which a
    point between them is looked for leads out of the wedge along its axis, which it leaves once.
    """

    def __init__(
        self,
        here: LocalMap,
        known: KnownCurve,
        at: Integers,
        counts: Integers,
        report: Callable[[], None],
    ) -> None:
        self.here, self.known, self.report = here, known, report
        self.at, self.counts = at, counts
        self.before = known.along[np.maximum(at - 1, 0)]
        self.after = known.along[np.minimum(at + 1, len(known.along) - 1)]

    def turn_toward(self, some: Integers, directions: Floats, steps: Floats) -> None:
        """Take the directions of the last steps: a curve may bend as a root beside a border."""
        sizes = np.linalg.norm(steps, axis=1)
        moved = sizes > _FAR * self.rounding(self.known.points[self.at[some]])
        directions[some[moved]] = steps[moved] / sizes[moved, None]

    def middle(self, low: Floats, high: Floats, reach: float) -> Floats:
        """Points of the manifold between pairs of its points; nan where none is found."""
        step = high - low
        size = np.asarray(np.linalg.norm(step, axis=1), float)
        half, found = low + 0.5 * step, np.full_like(low, np.nan)
        axis = self.before - self.after
        bend = np.linalg.norm(axis, axis=1)
        is_sharp = bend > _SHARP
        axis /= np.where(bend > 0.0, bend, 1.0)[:, None]
        across = np.where(is_sharp[:, None], axis, left_of(step))
        for wider in _WIDER:
            left: Integers = np.flatnonzero(np.isnan(found).any(axis=1))
            if not left.size:
                break
            sharp = is_sharp[left]
            own = self.known.sizes[self.at[left]]
            width = np.where(sharp, wider * reach * own, wider * 0.6 * size[left]).astype(float)
            begin = half[left] + np.where(sharp, width, 0.0)[:, None] * across[left]
            found[left] = self.onto(left, begin, across[left], width)
        return found

    def onto(self, some: Integers, points: Floats, normals: Floats, widths: Floats) -> Floats:
        """Points of the manifold on lines through points beside some of the borders."""
        return self.known.onto(
            self.here,
            points,
            normals,
            widths,
            self.at[some].astype(np.float64) + 0.5,
            self.counts[some],
            self.report,
        )

    def keys(self, points: Floats) -> Integers:
        """Itineraries, each as far as its pair."""
        found = np.full(len(points), -1)
        for count in np.unique(self.counts):
            some = np.flatnonzero(self.counts == count)
            found[some] = self.here.itineraries(points[some], int(count)).keys
        return found

    def run(self, low_keys: Integers) -> list[BorderPair]:
        """Pairs of points that rounding alone separates."""
        known, at = self.known, self.at
        low, high = known.points[at].copy(), known.points[at + 1].copy()
        reach: float = _REACH
        for _ in range(_ROUNDS):
            middle = self.middle(low, high, reach)
            there = np.asarray(np.isfinite(middle).all(axis=1))
            keys = self.keys(np.where(there[:, None], middle, low))
            below = np.flatnonzero(there & (keys == low_keys))
            above = np.flatnonzero(there & (keys != low_keys))
            self.turn_toward(below, self.before, middle[below] - low[below])
            self.turn_toward(above, self.after, high[above] - middle[above])
            low[below], high[above] = middle[below], middle[above]
            size = np.linalg.norm(high - low, axis=1)
            reach *= np.sqrt(0.5)  # two halvings bring both sides of a wedge half as near
            if np.all(size <= 2.0 * self.rounding(high)) or not there.any():
                break
        gaps = np.linalg.norm(high - low, axis=1)
        closed = gaps <= _CLOSED * known.sizes[at] + 64.0 * self.rounding(high)
        turns = self.turns(low, high, _BESIDE)
        fades = turns < FADES * self.turns(low, high, _FARTHER * _BESIDE)
        kinds = np.where((turns > SMOOTH) & ~fades, "corner", "smooth")
        kinds = np.where(closed, kinds, "unresolved")
        rows = zip(low, high, kinds.tolist(), turns.tolist(), gaps.tolist(), strict=True)
        return [BorderPair(*row) for row in rows]

    def rounding(self, points: Floats) -> Floats:
        """Distances that rounding makes."""
        eps = np.finfo(float).eps
        return self.here.coordinates.rounding + eps * np.abs(points).max(axis=1)

    def turns(self, low: Floats, high: Floats, beside: float) -> Floats:
        """Angles by which the curve turns, from points close beside both ends."""
        every = np.arange(self.at.size)
        step = beside * self.known.sizes[self.at]
        sides = [(low, -step, self.before), (high, step, self.after)]
        one, other = (
            self.onto(every, end + way[:, None] * along, left_of(along), 0.5 * step)
            for end, way, along in sides
        )
        one, other = low - one, other - high
        one = np.where(np.isfinite(one), one, self.before)
        other = np.where(np.isfinite(other), other, self.after)
        return turn_between(one, other)
