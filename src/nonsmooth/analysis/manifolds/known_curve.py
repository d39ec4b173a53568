"""A curve that maps to itself: where a point lies along it, and on which side of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.local_map import LocalMap

__all__ = ["KnownCurve", "bent", "left_of"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_NEAR = 6  # pieces to both sides of the one expected in which a point is looked for
_PARTS, _FEW = 16, 40  # into which a line is divided at once, where there are few lines
_TINY = 1e-300
_CLEAR = 0.5  # of a piece, beside which a side is certain though the curve is bent in between


def left_of(along: Floats) -> Floats:
    """Unit vectors to the left of some directions."""
    sizes = np.linalg.norm(along, axis=1, keepdims=True)
    return np.column_stack([-along[:, 1], along[:, 0]]) / np.where(sizes > 0.0, sizes, 1.0)


def bent(points: Floats, breaks: Iterable[int], parts: int) -> Floats:
    """Broken line through points with some parts between neighbours, bent as the curve is.

    ``breaks``: numbers of points at which the curve has a corner, or ends. Chords are off by the
    square of their length, which is more than small steps beside a graze allow.
    """
    from scipy.interpolate import Akima1DInterpolator

    last = len(points) - 1
    found = [points[:1]]
    ends = sorted({0, last, *(at for at in breaks if 0 < at < last)})
    for low, high in pairwise(ends):
        some = points[low : high + 1]
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(some, axis=0), axis=1)))
        places = np.interp(np.arange(1, parts * (high - low) + 1) / parts, range(len(some)), along)
        if high - low < 2 or np.any(np.diff(along) <= 0.0):
            shares = np.arange(1, parts * (high - low) + 1) / parts
            found.append(np.column_stack([np.interp(shares, range(len(some)), c) for c in some.T]))
            continue
        found.append(Akima1DInterpolator(along, some)(places))
    return np.concatenate(found)


class KnownCurve:
    """Broken line of points on a stable manifold, from the saddle on.

    The first piece is straight. ``images``: where the image of each point lies along the line, in
    pieces from the saddle. ``cuts``: pieces that are none, as a reset leads from one of their ends
    to the other.
    """

    def __init__(self, points: Floats, images: Floats, cuts: Sequence[int] = ()) -> None:
        self.points, self.images = points, images
        self.cut = np.zeros(len(points) - 1, bool)
        self.cut[list(cuts)] = True
        steps = np.diff(points, axis=0)
        self.sizes: Floats = np.linalg.norm(steps, axis=1)
        self.along: Floats = steps / np.maximum(self.sizes, _TINY)[:, None]

    @property
    def depths(self) -> Integers:
        """Applications of the map after which each point is on the first piece."""
        depths = np.zeros(len(self.points), np.int64)
        for i in range(2, depths.size):
            depths[i] = 1 + depths[min(i - 1, int(np.ceil(self.images[i] - 1e-9)))]
        return depths

    @property
    def normals(self) -> Floats:
        """Unit vectors to the left of the curve at its points."""
        ahead, behind = (
            np.vstack([self.along, self.along[-1:]]),
            np.vstack([self.along[:1], self.along]),
        )
        cut = np.append(self.cut, False)[:, None], np.append(False, self.cut)[:, None]
        return left_of(np.where(cut[0], 0.0, ahead) + np.where(cut[1], 0.0, behind))

    def image_of(self, places: Floats) -> Floats:
        """Where images of places along the line lie along it."""
        return np.interp(places, np.arange(len(self.points)), self.images)

    def look(self, points: Floats, expected: Floats) -> tuple[Floats, Floats, Integers]:
        """Place of the nearest point of the line beside the expected place, distance, and piece.

        Distances are positive on the left.
        """
        last = len(self.points) - 2
        middle = np.clip(expected.astype(np.int64), 0, last)
        pieces = np.clip(middle[:, None] + np.arange(-_NEAR, _NEAR + 1), 0, last)
        away = points[:, None] - self.points[pieces]
        along, sizes = self.along[pieces], self.sizes[pieces]
        part = np.clip((away * along).sum(axis=2) / np.maximum(sizes, _TINY), 0.0, 1.0)
        off = away - part[..., None] * sizes[..., None] * along
        squares = np.where(self.cut[pieces], np.inf, (off**2).sum(axis=2))
        best = np.argmin(np.where(np.isfinite(squares), squares, np.inf), axis=1)[:, None]
        piece = np.take_along_axis(pieces, best, 1)[:, 0]
        t = np.take_along_axis(part, best, 1)[:, 0]
        apart = np.sqrt(np.take_along_axis(squares, best, 1)[:, 0])
        # at a vertex both pieces that meet there say what is left of them
        other = np.clip(piece + np.where(t == 1.0, 1, np.where(t == 0.0, -1, 0)), 0, last)
        ahead = self.along[piece] + self.along[other]
        base = self.points[piece] + (t * self.sizes[piece])[:, None] * self.along[piece]
        rest = points - base
        side = np.sign(ahead[:, 0] * rest[:, 1] - ahead[:, 1] * rest[:, 0])
        return piece + t, side * apart, piece

    def sides(self, here: LocalMap, points: Floats, places: Floats, depths: Integers) -> Floats:
        """On which side of the manifold points lie: 1 left, -1 right, nan where there is no image.

        A side is read where the images of a point, which the unstable direction drives away from
        the manifold, are farther from the line than it is known, or beside the straight piece.
        """
        found = np.full(len(points), np.nan)
        left = np.arange(len(points))
        states = here.coordinates.states(points)
        expected = self.image_of(places)
        for turn in range(1, int(depths.max(initial=0)) + 1):
            if not left.size:
                break
            states = here.states_after(states, 1)
            images = here.coordinates.points(states)
            there = np.isfinite(images).all(axis=1)
            left, states = left[there], states[there]
            place, off, piece = self.look(images[there], expected[there])
            clear = (np.abs(off) > _CLEAR * self.sizes[piece]) | (place <= 1.0)
            clear |= turn >= depths[left]
            found[left[clear]] = np.where(off[clear] == 0.0, 1.0, np.sign(off[clear]))
            left, states, expected = left[~clear], states[~clear], self.image_of(place[~clear])
        return found

    def onto(
        self,
        here: LocalMap,
        points: Floats,
        normals: Floats,
        widths: Floats,
        places: Floats,
        depths: Integers,
        report: Callable[[], None],
    ) -> Floats:
        """Points of the manifold on the lines through some points along their normals.

        Each line is halved from ``widths`` to both sides; nan where its ends lie on one side.
        """
        low, high = -widths, widths.copy()
        at_low = self.sides(here, points + low[:, None] * normals, places, depths)
        at_high = self.sides(here, points + high[:, None] * normals, places, depths)
        good = at_low * at_high < 0.0
        # what no two places on a line can be nearer than, from its middle to its ends
        size = np.finfo(float).eps * np.maximum(np.abs(points).max(axis=1, initial=0.0), widths)
        size = np.maximum(size, here.coordinates.rounding)
        live = np.flatnonzero(good)
        while live.size:
            report()
            parts = _PARTS if live.size <= _FEW else 2  # the cost of few is that of the call
            inner = np.arange(1, parts) / parts
            at = low[live, None] + inner * (high - low)[live, None]
            side = self.sides(
                here,
                (points[live, None] + at[..., None] * normals[live, None]).reshape(-1, 2),
                np.repeat(places[live], parts - 1), np.repeat(depths[live], parts - 1),
            ).reshape(at.shape)  # fmt: skip
            good[live[np.isnan(side).any(axis=1)]] = False
            # the part in which the side changes first
            part = (side == at_low[live, None]).cumprod(axis=1).sum(axis=1)
            edges = np.column_stack([low[live], at, high[live]])
            row = np.arange(live.size)
            low[live], high[live] = edges[row, part], edges[row, part + 1]
            live = live[good[live] & (high[live] - low[live] > size[live])]
        found = points + (0.5 * (low + high))[:, None] * normals
        found[~good] = np.nan
        return found
