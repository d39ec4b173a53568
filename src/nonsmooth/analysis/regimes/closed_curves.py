"""Closed curves on which strobes turn: what a torus leaves of a motion, and chaos does not.

The strobes of quasi-periodic motion lie on one closed curve, or on several that they visit in turn,
and each lies there as far from the one before as on a circle that turns: strobe k has the phase k
times the rotation number (A. Katok and B. Hasselblatt, Introduction to the Modern Theory of
Dynamical Systems, 1995, sections 11.1 and 11.2: any orbit of a homeomorphism of the circle has the
order of a rotation). So the polygon through all strobes in the order of their phases is one
inscribed in a curve. Its angles add up to no more than the total curvature of that curve, however
many strobes there are (J. Milnor, On the total curvature of knots, Annals of Mathematics 52,
248-257, 1950). The polygon turns hardly at all at a single strobe then. Chaos gives no phase, and
one that is tied to a clock, or confined to thin bands, scatters across the curve: the polygon
zigzags, and turns by about a right angle at each strobe. A spiral, to a motion on its way, does so
too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

__all__ = ["BEND", "ClosedCurves", "Rotation", "closed_curves", "told_rotation"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

BEND = 0.1  # mean angle, in radians, by which the polygon turns at a strobe of a curve, at most
_ALIKE = 0.05  # of a circle: neighbours in space are nearer than that on it, most of them
_HARMONICS = 6  # of a turn, the strongest of which is sought
_PIECES = 50  # curves at most, as many as the longest period that the 0-1 test takes off
_LEAST = 60  # strobes of each curve
_TURNS = 3  # of each curve in either half of the strobes, at least
_OPEN = 10.0  # times the mean step between strobes on a curve that a gap may have
_STANDS = 0.5  # of the steps is left in the second half, or more, unless strobes come to a node
_REPEATS = 1e4  # times the strobes that there are would close a curve: they repeat
_SMALLEST = 1e-9  # of a curve: a smaller step says nothing of how many close it
_ROUNDING = 1e-12  # of the largest value of a state, below which its spread is none


class Rotation(NamedTuple):
    """Phases of strobes that turn, or what a series lacks to show that they do."""

    number: float  # part of a turn from strobe to strobe of a curve, below one half
    pieces: int  # curves that are visited in turn
    lag: int  # strobes after which they come next to where they were
    bend: float  # mean angle of the polygon at a strobe
    needed: int  # strobes that close the curves; 0 where they are closed


@dataclass(frozen=True)
class ClosedCurves:
    """Strobes in their order along one closed curve or several; n states that move."""

    rotation: Rotation
    moving: npt.NDArray[np.bool_]  # of all states
    scale: Floats  # (n,): spread of each
    points: Floats  # (K, n), scaled, curve by curve
    places: Integers  # (K,): which strobe each is

    def away(self, later: Floats) -> float:
        """Median distance of later strobes from the curves, in the mean step along them.

        It is nearly zero on the same curves, where steps are short beside the radii of curvature.
        """
        points = self.points
        others = later[:, self.moving] / self.scale
        _, near = KDTree(points).query(others)
        best = np.full(len(others), np.inf)
        for other in self._beside(near):
            best = np.minimum(best, _from_segments(others, points[near], points[other])[1])
        return float(np.median(best) / self._step)

    def meets(self, later: Floats) -> float:
        """Median distance of later strobes from the nearest of these, in the mean step."""
        distances, _ = KDTree(self.points).query(later[:, self.moving] / self.scale)
        return float(np.median(distances) / self._step)

    def nearing(self, earlier: Floats) -> float:
        """What is left of the steps of earlier strobes that nearly repeat: 1, unless at a node."""
        strobes = np.empty_like(self.points)
        strobes[self.places] = self.points
        others = earlier[:, self.moving] / self.scale
        now, before = (
            float(np.median(_steps_apart(each, self.rotation.lag))) for each in (strobes, others)
        )
        return now / before if before > 0.0 else 1.0

    @property
    def _step(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).mean())

    def _beside(self, near: Integers) -> Iterator[Integers]:
        """Neighbours along the curve of some points, on either side."""
        pieces = self.places % self.rotation.pieces
        sizes = np.bincount(pieces)
        first = np.append(0, np.cumsum(sizes))[pieces[near]]
        for way in (-1, 1):
            yield first + (near - first + way) % sizes[pieces[near]]


def closed_curves(strobes: Floats) -> ClosedCurves | Rotation:
    """Closed curves on which strobes (K, n) turn; how near they come to it where they do not."""
    spread = np.ptp(strobes, axis=0)
    moving = spread > _ROUNDING * np.abs(strobes).max(axis=0, initial=0.0)
    best = Rotation(np.nan, 1, 1, np.inf, 0)
    if not np.any(moving):
        return best
    scaled = strobes[:, moving] / spread[moving]
    for pieces in _numbers_of_pieces(scaled):
        for number in _rotations(scaled, pieces):
            found = _ordered(scaled, number, pieces)
            if found is None:
                continue
            rotation, places = found
            if rotation.bend > BEND:
                best = min(best, rotation, key=lambda each: each.bend)
            elif rotation.needed:
                return rotation
            else:
                points = scaled[places]
                return ClosedCurves(rotation, moving, spread[moving], points, places)
    return best


def told_rotation(curves: ClosedCurves) -> float:
    """Rotation number in the sense in which a state rises along the circle, if one does.

    Such a state falls once in a turn, as the potential of a neuron does. Other curves have no sense
    of their own, and the number is at most one half.
    """
    number, pieces = curves.rotation.number, curves.rotation.pieces
    if pieces > 1:
        return number
    for values in curves.points.T:
        steps = np.diff(values, append=values[:1])
        if np.count_nonzero(steps < 0.0) == 1:
            return number
        if np.count_nonzero(steps > 0.0) == 1:
            return 1.0 - number
    return number


def _numbers_of_pieces(scaled: Floats) -> Iterator[int]:
    """How many curves there may be: strobes next to each other belong to one.

    They are a multiple of that number of strobes apart.
    """
    yield 1
    _, near = KDTree(scaled).query(scaled, k=2)
    lags = np.abs(near[:, 1] - np.arange(len(scaled)))
    most = min(_PIECES, len(scaled) // _LEAST)
    yield from (p for p in range(2, most + 1) if np.mean(lags % p == 0) > 1.0 - _ALIKE)


def _rotations(scaled: Floats, pieces: int) -> Iterator[float]:
    """Rotation numbers by which neighbours in space are neighbours on a circle.

    The strongest frequency of a state is some multiple of one, and its alias.
    """
    series = scaled[::pieces]
    count, first = len(series), len(series) // 4
    later = np.arange(first, count)
    _, near = KDTree(series[:first]).query(series[first:])
    lags = later - near
    frequencies = dict.fromkeys(_frequency(values) for values in series.T)
    seen: list[float] = []
    for harmonic in range(1, _HARMONICS + 1):
        for frequency, whole in product(frequencies, range(harmonic)):
            number = (frequency + whole) / harmonic
            if not _fits(number, lags):
                continue
            # a turn that goes round several times for each of another one comes behind it
            if not any(abs(number - other) * count < _ALIKE for other in seen):
                seen.append(number)
                yield _refined(series, number)


def _fits(number: float, lags: Integers) -> bool:
    """Whether neighbours in space are neighbours on the circle."""
    return float(np.median(np.abs((lags * number + 0.5) % 1.0 - 0.5))) < _ALIKE


def _refined(series: Floats, number: float) -> float:
    """Rotation number by places between earlier strobes: ever more of them, and ever nearer.

    Between two neighbours on the curve a later strobe has a phase between theirs, by its place on
    the segment that joins them.
    """
    for part in (16, 8, 4, 2):
        first = np.arange(len(series) // part)
        phases = first * number % 1.0
        order = np.argsort(phases)
        vertices = series[: first.size][order]
        others = series[first.size :]
        _, near = KDTree(vertices).query(others)
        found, best = np.zeros(len(others)), np.full(len(others), np.inf)
        for way in (-1, 1):
            beside = (near + way) % first.size
            part_of, distance = _from_segments(others, vertices[near], vertices[beside])
            step = (phases[order[beside]] - phases[order[near]] + 0.5) % 1.0 - 0.5
            found = np.where(distance < best, phases[order[near]] + part_of * step, found)
            best = np.minimum(best, distance)
        since = np.arange(first.size, len(series))
        ahead, lags = (since * number - found + 0.5) % 1.0 - 0.5, since - order[near]
        late = lags >= np.median(lags)
        number -= float(np.median(ahead[late] / lags[late]))
    return number


def _frequency(values: Floats) -> float:
    """Strongest frequency of a series, per step, by a window without sharp edges."""
    size = 4 * len(values)
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)), size))
    k = int(np.argmax(power))
    if not 0 < k < len(power) - 1:
        return k / size
    left, top, right = np.log(np.maximum(power[k - 1 : k + 2], 1e-300))
    curved = left - 2.0 * top + right
    return (k + (0.5 * (left - right) / curved if curved < 0.0 else 0.0)) / size


def _ordered(scaled: Floats, number: float, pieces: int) -> tuple[Rotation, Integers] | None:
    """Strobes in the order of a rotation; None where they turn too seldom or come to a node."""
    count = len(scaled) // pieces
    number = number % 1.0
    number, mirrored = min(number, 1.0 - number), number > 0.5
    if number * (count // 2) < _TURNS:
        return None
    parts = [np.arange(r, len(scaled), pieces) for r in range(pieces)]
    orders = [part[np.argsort(np.arange(part.size) * number % 1.0)] for part in parts]
    orders = [part[::-1] for part in orders] if mirrored else orders
    bend = float(np.concatenate([_angles(scaled[part]) for part in orders]).mean())
    places, lag = np.concatenate(orders), pieces * _nearest_lag(number, count)
    phases = np.sort(np.arange(count) * number % 1.0)
    is_open = np.diff(phases, append=phases[0] + 1.0).max() > _OPEN / count
    first, second = np.array_split(_steps_apart(scaled, lag), 2)
    needed = _needed(scaled, lag, places)
    needed = needed if is_open or needed > _REPEATS * len(scaled) else 0
    if needed == 0 and np.median(second) < _STANDS * np.median(first):
        return None
    return Rotation(number, pieces, lag, bend, needed), places


def _angles(points: Floats) -> Floats:
    """Angles by which the closed polygon through some points turns, zero where they repeat."""
    steps = np.diff(points, axis=0, append=points[:1])
    sizes = np.linalg.norm(steps, axis=1)
    ways = steps[sizes > 0.0] / sizes[sizes > 0.0, None]
    angles = np.zeros(len(points))
    if len(ways):
        others = np.roll(ways, -1, axis=0)
        apart, along = (np.linalg.norm(each, axis=1) for each in (others - ways, others + ways))
        angles[: len(ways)] = 2.0 * np.arctan2(apart, along)
    return angles


def _needed(scaled: Floats, lag: int, places: Integers) -> int:
    """Strobes that close the curves: as many as there are steps of nearly repeating ones on them.

    Near a fraction with the denominator q, strobes creep along q arcs, each by one step in q.
    """
    step = float(np.median(_steps_apart(scaled, lag)))
    length = float(np.linalg.norm(np.diff(scaled[places], axis=0), axis=1).sum())
    return int(min(np.ceil(length / max(step, _SMALLEST * length)), 1.0 / _SMALLEST))


def _nearest_lag(number: float, count: int) -> int:
    """After how many steps, up to a quarter of all, a turn comes next to where it began."""
    q = np.arange(1, max(count // 4, 2))
    return int(q[np.argmin(np.abs((q * number + 0.5) % 1.0 - 0.5))])


def _steps_apart(points: Floats, lag: int) -> Floats:
    return np.asarray(np.linalg.norm(points[lag:] - points[:-lag], axis=1))


def _from_segments(points: Floats, starts: Floats, ends: Floats) -> tuple[Floats, Floats]:
    """Part of a segment of its own at which each point is nearest to it, and the distance."""
    along = ends - starts
    length = np.square(along).sum(axis=1)
    part = ((points - starts) * along).sum(axis=1) / np.where(length > 0.0, length, 1.0)
    part = np.clip(part, 0.0, 1.0)
    return part, np.linalg.norm(points - starts - part[:, None] * along, axis=1)
