"""Growth of a stable manifold in the plane without the inverse of the map: the search circle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.curve import Border, Curve, Spacing, finished_curve, lengths_of
from nonsmooth.analysis.manifolds.edge import edge_point
from nonsmooth.analysis.manifolds.first_segment import FirstSegment
from nonsmooth.analysis.manifolds.known_curve import KnownCurve, bent
from nonsmooth.analysis.manifolds.local_map import LocalMap
from nonsmooth.analysis.manifolds.saddle import Saddle, SaddlePoint
from nonsmooth.analysis.manifolds.stable_borders import BorderPair, find_borders

__all__ = ["grow_stable"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_AHEAD = np.linspace(-0.6, 0.6, 13)  # angles in which the next point is looked for
_AROUND = np.linspace(-np.pi, np.pi, 241)  # at a corner; places behind are told by their images

_SHRINKS = (1.0, 0.5, 0.25, 0.125)  # radii that are tried at once
_PIECES = 60  # of the curve, beside the image of the last point, where the next image may lie
_BENT = 8  # parts of a piece of the curve, along which it is bent
_SLACK = 4.0  # times its distance from the known curve that an image may be off along it
_CLOSES = 0.2  # of the distance of two images that remains between closer ones, unless it jumps
_REFINED = (
    8  # times at most that an arc is divided, by 12: a root leaves a third of a gap each time
)
_WIDER = (0.1, 0.4, 1.5)  # of the step, where the line on which the manifold is located ends
_TINY = 1e-300
_START = 4.0  # of the smallest step: the first one behind a reset


class _Found(NamedTuple):
    """The next point, where its image lies along the curve, and the angle to it."""

    point: Floats
    image: float
    angle: float


class _Target(NamedTuple):
    """A part of the curve that is known, bent between its points, with the image of the last one.

    ``slack``: how much farther that image may lie, as it is beside the known curve.
    """

    curve: KnownCurve
    begin: int  # number of the piece of the whole curve with which it begins
    place: float  # of the image, in parts
    slack: float  # likewise

    def crossings(self, angles: Floats, images: Floats) -> Floats:
        """Angle, place and number of the arc of each crossing of images with the curve; (C, 3)."""
        known = self.curve.points
        step, arc = np.diff(known, axis=0), np.diff(images, axis=0)
        apart = known[None, :-1] - images[:-1, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            area = _cross(arc[:, None], step[None])
            on_arc = _cross(apart, step[None]) / area
            on_step = _cross(apart, arc[:, None]) / area
        hit = ~self.curve.cut & (on_arc >= 0.0) & (on_arc < 1.0)
        i, k = np.nonzero(hit & (on_step >= 0.0) & (on_step <= 1.0))
        angle = angles[i] + on_arc[i, k] * np.diff(angles)[i]
        return np.column_stack([angle, k + on_step[i, k], i])

    def is_ahead(self, place: float, angle: float) -> bool:
        """Whether a place lies ahead of the image of the last point.

        At an angle by which the curve may turn back it has to do so by more than the slack.
        """
        return place > self.place + (-self.slack if abs(angle) <= _AHEAD[-1] else self.slack)


def grow_stable(
    saddle: Saddle,
    point: SaddlePoint,
    first: FirstSegment,
    spacing: Spacing,
    report: Callable[[float], None],
) -> Curve:
    """One side of the stable manifold; ``report`` is told its length and may raise."""
    search = _CircleSearch(point.here, point, first, spacing, saddle.multiplier)
    try:
        ended = search.run(report)
    except KeyboardInterrupt:
        ended = "interrupted"
    return search.curve(ended)


class _CircleSearch:
    """Points one after the other, each on a circle around the one before.

    They are settled when images of further points would come to lie between them: put onto the
    manifold, which lines between points only neared, and with corners among them.
    """

    def __init__(
        self,
        here: LocalMap,
        point: SaddlePoint,
        first: FirstSegment,
        spacing: Spacing,
        multiplier: float,
    ) -> None:
        self.here, self.spacing = here, spacing
        begin = first.side * first.length * point.direction
        self.points = [np.zeros(2), begin]
        self.images = [0.0, multiplier]
        self.heading = first.side * point.direction
        self.radius = min(spacing.largest, 0.5 * first.length * (1.0 / multiplier - 1.0))
        self.length = first.length
        self.settled = 2
        self.cuts: list[int] = []  # pieces over which a reset leads
        self.borders: dict[int, BorderPair] = {}  # by the number of the point at which they lie

    def known(self) -> KnownCurve:
        """The curve so far."""
        return KnownCurve(np.array(self.points), np.array(self.images), self.cuts)

    def run(self, report: Callable[[float], None]) -> str:
        """Grow until something ends it, and say what."""

        def still() -> None:
            report(self.length)

        while self.length < self.spacing.length:
            if len(self.points) >= self.spacing.points:
                self.settle(still)
                return "points"
            found = self.next_point()
            if found is None:
                # a corner that settling locates may be all that was in the way
                if not self.settle(still) and not self.over_reset():
                    return "no_preimage"
                continue
            step = found.point - self.points[-1]
            size = float(np.linalg.norm(step))
            self.heading = step / size
            self.points.append(found.point)
            self.images.append(found.image)
            self.length += size
            easy = abs(found.angle) < 0.5 * self.spacing.angle
            self.radius = min(self.spacing.largest, (2.0 if easy else 1.0) * size)
            if found.image > self.settled - 1 and not self.settle(still):
                return "not_located"
            still()
        self.settle(still)
        return "length"

    def settle(self, report: Callable[[], None]) -> bool:
        """Put the points since the last time onto the manifold, and find their borders.

        Points that cannot be put onto it are left out. Whether some were found.
        """
        begin = self.settled
        if begin == len(self.points):
            return False
        known = self.known()
        points, lost = self.located(known, begin, report)
        kept = np.setdiff1d(np.arange(len(self.points)), lost)
        places = np.interp(
            known.images, np.arange(len(points)), np.searchsorted(kept, range(len(points)))
        )
        known = KnownCurve(points[kept], places[kept], self.cuts)
        found = find_borders(self.here, known, begin - 1, report)
        whole, expected = [*known.points[:begin]], [*known.images[:begin]]
        for i in range(begin - 1, len(known.points) - 1):
            if i in found:
                self.borders[len(whole)] = found[i]
                whole.append(found[i].low)
                expected.append(0.5 * float(known.images[i] + known.images[i + 1]))
            whole.append(known.points[i + 1])
            expected.append(float(known.images[i + 1]))
        known = KnownCurve(np.array(whole), np.array(expected), self.cuts)
        images = self.here.after(known.points[begin:])
        place, _, _ = known.look(images, known.images[begin:])
        place = np.where(np.isfinite(images).all(axis=1), place, known.images[begin:])
        self.points, self.images = whole, [*known.images[:begin], *place]
        self.settled = len(whole)
        self.heading = known.along[-1]
        self.length = float(self.steps(known.points).sum())
        return self.settled > begin

    def located(
        self, known: KnownCurve, begin: int, report: Callable[[], None]
    ) -> tuple[Floats, Integers]:
        """Points, those from ``begin`` on put onto the manifold, and which of them were lost."""
        points, depths, normals = known.points.copy(), known.depths, known.normals
        sizes = np.append(known.sizes, known.sizes[-1])
        left = np.arange(begin, len(points))
        for wider in _WIDER:
            if not left.size:
                break
            found = known.onto(
                self.here, points[left], normals[left], wider * sizes[left], left.astype(float),
                depths[left], report,
            )  # fmt: skip
            good = np.isfinite(found).all(axis=1)
            points[left[good]] = found[good]
            left = left[~good]
        return points, left

    def steps(self, points: Floats) -> Floats:
        """Lengths between neighbours, none where a reset leads from one to the other."""
        steps = lengths_of(points)
        steps[self.cuts] = 0.0
        return steps

    def curve(self, ended: str) -> Curve:
        """The curve as far as its points are settled, with both points of each border."""
        points = np.array(self.points[: self.settled])
        known = KnownCurve(points, np.array(self.images[: self.settled]), self.cuts)
        borders = [Border(at, *pair[2:]) for at, pair in self.borders.items()]
        borders += [Border(at, "jump", np.nan, float(known.sizes[at])) for at in self.cuts]
        # points of the straight first piece, and the second ones of borders
        count = int(np.ceil(known.sizes[0] / self.spacing.largest))
        at = np.array(sorted(self.borders), np.int64)
        highs = np.array([self.borders[i].high for i in at.tolist()]).reshape(-1, 2)
        first = np.arange(count)[:, None] / count * points[1]
        points = np.concatenate([first, np.insert(points, at + 1, highs, axis=0)[1:]])
        depths = np.insert(known.depths, at + 1, known.depths[at])[1:]
        return finished_curve(
            points, np.concatenate([np.zeros(count, np.int64), depths]),
            self.here.itineraries(points).words, ended,
            [
                each._replace(place=each.place + count - 1 + int(np.searchsorted(at, each.place)))
                for each in sorted(borders)
            ],
            self.spacing.length,
        )  # fmt: skip

    def next_point(self) -> _Found | None:
        """The next point, on the largest circle on which the curve turns little enough."""
        target = self.target()
        radius, smallest = self.radius, min(self.radius, self.spacing.smallest)
        while radius > smallest:
            radii = np.array([radius * part for part in _SHRINKS])
            radii = radii[radii > smallest]
            found = self.on_circles(target, radii, _AHEAD, self.spacing.angle)
            if found is not None:
                return found
            radius = radii[-1] * _SHRINKS[1]
        return self.around_corner(target, smallest)

    def around_corner(self, target: _Target, smallest: float) -> _Found | None:
        """A point in any direction, on the smallest circle that has one.

        The image of a small circle may not reach the curve that is known, which is off the
        manifold by what chords make, or move on along it by less: beside a graze it moves on as
        the square of the radius.
        """
        radius = smallest
        while radius <= self.spacing.largest:
            found = self.on_circles(target, np.array([radius]), _AROUND, np.pi)
            if found is not None:
                return found
            radius *= 2.0
        return None

    def target(self) -> _Target:
        """The curve from the image of the last point on, where the next image may lie."""
        begin = max(int(self.images[-1]) - 1, 0)
        ends = np.array(self.points[begin : begin + _PIECES])
        breaks = [at - begin for at in (*self.borders, *self.cuts, *(k + 1 for k in self.cuts))]
        cuts = [_BENT * (at - begin) for at in self.cuts if begin <= at < begin + len(ends) - 1]
        line = bent(ends, breaks, _BENT)
        curve = KnownCurve(line, np.zeros(len(line)), [k + i for k in cuts for i in range(_BENT)])
        place, slack = _BENT * (self.images[-1] - begin), 0.0
        image = self.here.after(self.points[-1][None])
        if np.isfinite(image).all():
            places, off, piece = curve.look(image, np.array([place]))
            if np.isfinite(off[0]):
                place = float(places[0])
                slack = _SLACK * abs(float(off[0])) / max(float(curve.sizes[piece[0]]), _TINY)
        return _Target(curve, begin, place, slack)

    def on_circles(
        self, target: _Target, radii: Floats, angles: Floats, most: float
    ) -> _Found | None:
        """A point whose image lies on the curve ahead, on the first circle that has one.

        On each circle it is the one nearest to straight on, by the angle ``most`` at most.
        """
        starts = self.around(radii[:, None], angles)
        images = self.here.after(starts.reshape(-1, 2)).reshape(radii.size, angles.size, 2)
        for radius, some in zip(radii, images, strict=True):
            crossings = target.crossings(angles, some)
            for k in np.argsort(np.abs(crossings[:, 0])):
                if abs(crossings[k, 0]) > most + angles[1] - angles[0]:
                    break
                found = self.refined(target, radius, angles, some, int(crossings[k, 2]))
                if found is not None and abs(found.angle) <= most:
                    return found  # and does not turn too much
        return None

    def around(self, radius: float | Floats, angles: Floats) -> Floats:
        """Points on circles around the last point, at angles from the heading."""
        c, s = np.cos(angles), np.sin(angles)
        h = self.heading
        ways = np.stack([c * h[0] - s * h[1], s * h[0] + c * h[1]], axis=-1)
        return np.asarray(self.points[-1] + np.asarray(radius)[..., None] * ways)

    def refined(
        self, target: _Target, radius: float, angles: Floats, images: Floats, arc: int
    ) -> _Found | None:
        """Crossing on one arc, if it is ahead; None where the map jumps there and has a gap.

        Images beside a graze part as the root of the distance: they come together, but slowly.
        """
        low, high = float(angles[arc]), float(angles[arc + 1])
        apart = np.linalg.norm(images[arc + 1] - images[arc])
        for _ in range(_REFINED):
            finer = np.linspace(low, high, _AHEAD.size)
            inner = self.here.after(self.around(radius, finer))
            again = target.crossings(finer, inner)
            if not again.size:
                return None
            angle, place, small = again[np.argmin(np.abs(again[:, 0]))]
            k = int(small)
            if np.linalg.norm(inner[k + 1] - inner[k]) <= _CLOSES * apart:
                if not target.is_ahead(float(place), float(angle)):
                    return None
                point = self.around(radius, np.array([angle]))[0]
                return _Found(point, target.begin + float(place) / _BENT, float(angle))
            low, high = float(finer[k]), float(finer[k + 1])
        return None

    def over_reset(self) -> bool:
        """Go on behind a reset, where the curve has come to the edge of the states.

        A start at the edge that moves outward is reset at once, so the curve goes on where that
        leads; if the curve comes from the inside of a reset, it goes on at the start of that.
        Whether it has been found.
        """
        if len(self.points) - 2 in self.cuts:  # nothing came of the one before
            return False
        found = edge_point(self.here, self.known(), self.spacing)
        if found is None:
            return False
        self.length += float(np.linalg.norm(found.edge - self.points[-1]))
        self.points += [found.edge, found.behind]
        self.images += [found.image, found.image]
        self.settled = len(self.points)
        self.cuts.append(self.settled - 2)
        self.radius = _START * self.spacing.smallest
        target = self.target()
        # the curve begins here, so that what is beside the image within the slack is ahead of it
        target = target._replace(place=target.place - target.slack, slack=0.0)
        begun = self.around_corner(target, self.radius)
        if begun is None:
            return False
        way = begun.point - self.points[-1]
        self.heading = way / np.linalg.norm(way)
        return True


def _cross(one: Floats, other: Floats) -> Floats:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
