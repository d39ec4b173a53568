"""Growth of an unstable manifold: images of a first segment, refined on the segment itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.curve import (
    FADES,
    SMOOTH,
    Border,
    Curve,
    Spacing,
    finished_curve,
    lengths_of,
    turn_between,
    turns_of,
)
from nonsmooth.analysis.manifolds.first_segment import FirstSegment
from nonsmooth.analysis.manifolds.local_map import LocalMap
from nonsmooth.analysis.manifolds.saddle import Saddle, SaddlePoint

__all__ = ["grow_unstable"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

_FEW = 33  # places that are not thinned out
_FIRST = 9  # places of the first segment to begin with
_WIDTH = 2.0  # roundings that two places of the segment differ by at least
_BESIDE = 1e5  # such widths, from which directions on both sides of a border are taken
_ROUNDS = 60  # of halvings
_FARTHER = 100.0  # times as far, where the curve turns as much if the turn is that of a corner
_SHARE = 0.3  # of the steps beside a border; a gap that is larger is a jump
_STANDS = 1e-6  # of the length; where an image is shorter the manifold has come to its end
_MOST = 400  # borders of one image; there may be no end of them


def grow_unstable(
    saddle: Saddle,
    point: SaddlePoint,
    first: FirstSegment,
    spacing: Spacing,
    report: Callable[[float], None],
) -> Curve:
    """One side of the unstable manifold; ``report`` is told its length and may raise."""
    growth = _Growth(saddle, point, first, spacing, report)
    try:
        ended = growth.run()
    except KeyboardInterrupt:
        ended = "interrupted"
    return growth.curve(ended)


@dataclass
class _Image:
    """One image of the first segment: places there, points here."""

    number: int  # applications of the map
    places: Floats  # (P,) ascending, along the first segment
    points: Floats  # (P, d)
    keys: Integers  # (P,) itineraries since the first segment

    def added(self, places: Floats, points: Floats, keys: Integers) -> _Image:
        """The image with more points."""
        whole = np.concatenate([self.places, places])
        order = np.argsort(whole, kind="stable")
        return _Image(
            self.number, whole[order], np.concatenate([self.points, points])[order],
            np.concatenate([self.keys, keys])[order],
        )  # fmt: skip

    def kept(self, chosen: Flags) -> _Image:
        """Some of its points."""
        return _Image(self.number, self.places[chosen], self.points[chosen], self.keys[chosen])

    @property
    def there(self) -> Flags:
        """Which points exist."""
        return np.asarray(np.isfinite(self.points).all(axis=1))


@dataclass
class _Growth:
    saddle: Saddle
    point: SaddlePoint
    first: FirstSegment
    spacing: Spacing
    report: Callable[[float], None]
    images: list[_Image] = field(default_factory=list)
    length: float = 0.0
    pairs: dict[float, Floats] = field(default_factory=dict)  # at borders, by the lower place

    @property
    def here(self) -> LocalMap:
        return self.point.here

    def start(self, places: Floats) -> Floats:
        """Points of the first segment."""
        return self.first.side * places[:, None] * self.point.direction

    def run(self) -> str:
        """Grow until something ends it, and say what."""
        end = self.first.length
        count = max(2, int(np.ceil(end / self.spacing.largest)) + 1)
        places = np.linspace(0.0, end, count)
        self.images.append(_Image(0, places, self.start(places), np.zeros(count, np.int64)))
        self.length = end
        fundamental = np.geomspace(end / self.saddle.multiplier, end, _FIRST)
        fundamental[-1] = end
        for number in range(1, self.spacing.images + 1):
            image = self.sharpened(self.refined(self.mapped(number, fundamental)))
            full = image.places.size >= self.room()
            if full:  # what there was no room for ends the curve
                coarse = self.to_split(image, self.wide(image))
                image = image.kept(np.append(True, coarse.cumsum() == 0))
            self.images.append(image)
            self.length += float(self.steps(image).sum())
            self.report(self.length)
            if full:
                return "points"
            if self.length >= self.spacing.length:
                return "length"
            if not image.there.any():
                return "no_image"
            if self.at_rest():
                return "attractor"
            fundamental = self.thinned(image).places
        return "images"

    def room(self) -> int:
        """How many more points the curve may have."""
        return self.spacing.points - sum(each.places.size for each in self.images)

    def at_rest(self) -> bool:
        """Whether images have become short, and not only begun so."""
        sums = [float(self.steps(each).sum()) for each in self.images[1:]]
        return sums[-1] <= _STANDS * self.spacing.length and max(sums) > 10.0 * sums[-1]

    def mapped(self, number: int, places: Floats) -> _Image:
        """Image of some places after so many applications."""
        found = self.here.itineraries(self.start(places), number)
        return _Image(number, places, found.points, found.keys)

    def refined(self, image: _Image) -> _Image:
        """The image with borders located and points dense enough."""
        sought = 0
        for _ in range(_ROUNDS):
            wide = self.wide(image)
            gaps = np.flatnonzero(
                wide & (np.diff(image.keys) != 0) & (image.there[1:] | image.there[:-1])
                & self.within(image)
            )  # fmt: skip
            gaps = gaps[: max(0, _MOST - sought)]
            sought += gaps.size
            if gaps.size:
                image = self.with_borders(image, gaps)
                wide = self.wide(image)
            split = np.flatnonzero(self.to_split(image, wide))
            if not split.size or image.places.size >= self.room():
                break
            new = self.mapped(image.number, 0.5 * (image.places[split] + image.places[split + 1]))
            image = image.added(new.places, new.points, new.keys)
            self.report(self.length)
        return image

    def resolution(self, places: Floats) -> Floats:
        """Widths below which two places are the same states."""
        eps = np.finfo(float).eps
        return np.asarray(_WIDTH * np.maximum(self.here.coordinates.rounding, eps * places))

    def wide(self, image: _Image) -> Flags:
        """Between which neighbours there is room for another."""
        widths = np.diff(image.places)
        return np.asarray(widths > self.resolution(image.places[1:]))

    def steps(self, image: _Image) -> Floats:
        """Lengths between neighbours; none where the curve is interrupted."""
        steps = lengths_of(image.points)
        cut = ~np.isfinite(steps) | (~self.wide(image) & (np.diff(image.keys) != 0))
        cut |= ~self.wide(image) & (steps > self.spacing.largest)
        return np.where(cut, 0.0, steps)

    def within(self, image: _Image) -> Flags:
        """Which steps begin within the wanted length."""
        steps = self.steps(image)
        steps = np.where(np.diff(image.keys) != 0, 0.0, steps)  # may be a jump
        before = self.length + np.concatenate([[0.0], np.cumsum(steps)[:-1]])
        return np.asarray(before < self.spacing.length)

    def to_split(self, image: _Image, wide: Flags) -> Flags:
        """Steps that are too long, or at which the curve turns too much."""
        steps = lengths_of(image.points)
        smooth = np.diff(image.keys) == 0
        open_ = wide & self.within(image) & np.isfinite(steps)
        long = steps > self.spacing.largest
        turns = turns_of(image.points)[1:-1]
        bent = (turns > self.spacing.angle) & smooth[1:] & smooth[:-1]
        longer = np.maximum(steps[1:], steps[:-1])
        bent &= longer > self.spacing.smallest
        by_turn = np.zeros(steps.size, bool)
        by_turn[:-1] |= bent & (steps[:-1] >= 0.5 * longer)
        by_turn[1:] |= bent & (steps[1:] >= 0.5 * longer)
        return np.asarray(open_ & (long | by_turn))

    def with_borders(self, image: _Image, gaps: Integers) -> _Image:
        """The image with a pair of points at each border, found by halving all gaps at once."""
        low, high = image.places[gaps], image.places[gaps + 1]
        left, right = image.keys[gaps], image.keys[gaps + 1]
        found: list[Floats] = []
        for _ in range(_ROUNDS):
            middle = 0.5 * (low + high)
            small = high - low <= self.resolution(high)
            found += [low[small], high[small]]
            low, high, middle = low[~small], high[~small], middle[~small]
            left, right = left[~small], right[~small]
            if not low.size:
                break
            self.report(self.length)
            keys = self.mapped(image.number, middle).keys
            lower, upper = keys != left, keys != right
            pairs = [(low, middle, left, keys, lower), (middle, high, keys, right, upper)]
            low, high, left, right = (
                np.concatenate([pair[k][pair[4]] for pair in pairs])[:_MOST] for k in range(4)
            )
        places = np.setdiff1d(np.concatenate(found), image.places)
        new = self.mapped(image.number, places)
        return image.added(new.places, new.points, new.keys)

    def sharpened(self, image: _Image) -> _Image:
        """The image with its borders as sharp as rounding of images allows.

        Places on a short first piece are coarse, beside the size of the orbit, and a graze makes a
        root of what they leave. Where the itineraries of a pair first differ, the pair is halved
        once more on the chord between its points before that, so short that it is the curve.
        """
        at = np.flatnonzero(~self.wide(image) & (np.diff(image.keys) != 0))
        at = at[image.there[at] & image.there[at + 1]]
        lows = image.places[at].tolist()
        fresh = np.array([low not in self.pairs for low in lows], bool)
        if fresh.any():
            some = at[fresh]
            before = self.mapped_points(
                np.concatenate([image.places[some], image.places[some + 1]]), image.number - 1
            )
            pairs = self.halved(before[: some.size], before[some.size :])
            for low, pair in zip(image.places[some].tolist(), pairs, strict=True):
                self.pairs[low] = pair
        for i, low in zip(at, lows, strict=True):
            after = self.here.after(self.pairs[low])
            if np.isfinite(after).all():
                self.pairs[low] = image.points[i : i + 2] = after
        return image

    def mapped_points(self, places: Floats, number: int) -> Floats:
        """Images of places alone."""
        start = self.start(places)
        return self.here.after(start, number) if number else start

    def halved(self, low: Floats, high: Floats) -> Floats:
        """Pairs between two points each that do something else within one application."""
        below, above = np.split(self.here.itineraries(np.concatenate([low, high])).keys, 2)
        for _ in range(_ROUNDS):
            middle = 0.5 * (low + high)
            keys = self.here.itineraries(middle).keys
            lower = (keys == below) & (below != above)
            upper = (keys != below) & (below != above)
            low = np.where(lower[:, None], middle, low)
            high = np.where(upper[:, None], middle, high)
        return np.stack([low, high], axis=1)

    def thinned(self, image: _Image) -> _Image:
        """The image without every other point where there are far more than needed."""
        if image.places.size < _FEW:
            return image
        steps, turns = lengths_of(image.points), turns_of(image.points)
        same = np.diff(image.keys) == 0
        spare = np.zeros(image.places.size, bool)
        both = steps[1:] + steps[:-1]
        spare[1:-1] = (
            same[1:] & same[:-1] & (both < 0.25 * self.spacing.largest)
            & (turns[1:-1] < 0.25 * self.spacing.angle)
        )  # fmt: skip
        spare &= np.arange(spare.size) % 2 == 1
        return image.kept(~spare)

    def curve(self, ended: str) -> Curve:
        """All images one after the other, cut at the wanted length."""
        points, numbers, words, places = [], [], [], []
        borders: list[Border] = []
        count = 0
        for image in self.images:
            kept = image.there
            kept[0] &= image.number == 0  # the others begin where the one before ends
            place = count - 1 + np.cumsum(kept)
            borders += [
                each._replace(place=int(place[each.place]))
                for each in self.borders(image)
                if kept[each.place] or (kept[each.place + 1] and place[each.place] >= 0)
            ]
            count += int(kept.sum())
            points.append(image.points[kept])
            places.append(image.places[kept])
            numbers.append(np.full(int(kept.sum()), image.number))
            words.append(self.words(image, kept))
        return finished_curve(
            np.concatenate(points), np.concatenate(numbers), np.concatenate(words), ended, borders,
            self.spacing.length, np.concatenate(places),
        )  # fmt: skip

    def words(self, image: _Image, kept: Flags) -> npt.NDArray[np.str_]:
        """Modes on the way to each point from its preimage on the manifold."""
        places = image.places[kept]
        if image.number == 0:
            return self.here.itineraries(self.start(places / self.saddle.multiplier)).words
        return self.here.itineraries(self.mapped_points(places, image.number - 1)).words

    def borders(self, image: _Image) -> list[Border]:
        """Borders of one image, in its points."""
        narrow = ~self.wide(image)
        steps = lengths_of(image.points)
        far = ~np.isfinite(steps) | (steps > self.spacing.largest)
        at = np.flatnonzero(
            narrow & ((np.diff(image.keys) != 0) | far) & (image.there[1:] | image.there[:-1])
        )
        if not at.size:
            return []
        turn, beside = self.turns(image, at, _BESIDE)
        farther, _ = self.turns(image, at, _FARTHER * _BESIDE)
        found = []
        for i, place in enumerate(at):
            if not np.isfinite(steps[place]):
                found.append(Border(int(place), "end", np.nan, np.nan))
                continue
            bends = turn[i] > SMOOTH and turn[i] >= FADES * farther[i]
            kind = "corner" if bends else "smooth"
            if steps[place] > _SHARE * beside[i] and steps[place] > self.spacing.smallest:
                kind = "jump"
            found.append(Border(int(place), kind, float(turn[i]), float(steps[place])))
        return found

    def turns(self, image: _Image, at: Integers, beside: float) -> tuple[Floats, Floats]:
        """Angles at borders between points beside them, and the lengths of both steps there."""
        width = beside * self.resolution(image.places[at])
        room = np.diff(image.places)
        before = np.where(at > 0, room[np.maximum(at - 1, 0)], np.inf)
        after = np.where(at + 1 < room.size, room[np.minimum(at + 1, room.size - 1)], np.inf)
        low = image.places[at] - np.minimum(width, 0.5 * before)
        high = image.places[at + 1] + np.minimum(width, 0.5 * after)
        both = self.mapped(image.number, np.concatenate([low, high])).points
        one = image.points[at] - both[: at.size]
        other = both[at.size :] - image.points[at + 1]
        sizes = np.linalg.norm(one, axis=1) + np.linalg.norm(other, axis=1)
        return turn_between(one, other), sizes
