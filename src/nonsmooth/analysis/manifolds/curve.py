"""Curves of points: lengths, angles, and what a side of a manifold is made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = [
    "FADES",
    "SMOOTH",
    "Border",
    "Curve",
    "Spacing",
    "finished_curve",
    "lengths_of",
    "turn_between",
    "turns_of",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

SMOOTH = 1e-3  # angle (rad) at a border that is no corner
# Of the turn at a border as seen from farther away: less is left where no corner is but a curve
# that bends, perhaps without bound, as the root of the distance where a soft wall is just touched.
FADES = 0.5
_APART = ("jump", "end")  # borders over which a curve does not go on


@dataclass(frozen=True)
class Spacing:
    """How long a curve is to be, and how densely its points lie, in scaled states."""

    length: float
    largest: float  # between neighbours
    smallest: float  # below which angles do not count
    angle: float  # that neighbours turn by at most
    points: int  # of one curve, at most
    images: int  # of the first segment, at most


class Border(NamedTuple):
    """Two neighbours that rounding alone separates, with another itinerary each."""

    place: int  # number of the first of them on its curve
    kind: str
    turn: float  # angle by which the curve turns
    gap: float  # distance of the two


@dataclass
class Curve:
    """One side of a manifold at one point of the orbit, from there on."""

    points: Floats  # (P, d)
    images: Integers  # (P,) applications of the map between a point and the first segment
    words: npt.NDArray[np.str_]  # (P,)
    arclength: Floats  # (P,)
    ended: str  # why it ends: length, attractor, points, images, no_image or interrupted
    borders: list[Border] = field(default_factory=list)
    # (P,) of an unstable manifold: how far from the orbit the starts of its points lie
    places: Floats | None = None


def finished_curve(
    points: Floats,
    images: Integers,
    words: npt.NDArray[np.str_],
    ended: str,
    borders: list[Border],
    length: float,
    places: Floats | None = None,
) -> Curve:
    """A curve cut at a length, to which gaps at jumps do not count."""
    steps = lengths_of(points)
    steps[[b.place for b in borders if b.kind in _APART and b.place < steps.size]] = 0.0
    along = np.concatenate([[0.0], np.cumsum(steps)])
    end = int(np.searchsorted(along, length, side="right"))
    inside = [border for border in borders if border.place < end]
    if places is not None:
        places = places[:end]
    return Curve(points[:end], images[:end], words[:end], along[:end], ended, inside, places)


def lengths_of(points: Floats) -> Floats:
    """Distances of neighbours."""
    found: Floats = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return found


def turns_of(points: Floats) -> Floats:
    """Angle by which a curve turns at each inner point; (P,), zero at both ends."""
    steps = np.diff(points, axis=0)
    found = np.zeros(len(points))
    found[1:-1] = turn_between(steps[:-1], steps[1:])
    return found


def turn_between(one: Floats, other: Floats) -> Floats:
    """Angle between vectors, row by row; nan where one is not finite, 0 where it is zero."""
    with np.errstate(invalid="ignore", divide="ignore"):
        sizes = np.linalg.norm(one, axis=1), np.linalg.norm(other, axis=1)
        a, b = one / sizes[0][:, None], other / sizes[1][:, None]
        # more accurate than the arc of a cosine near 0 and pi
        angle = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return np.where((sizes[0] == 0.0) | (sizes[1] == 0.0), 0.0, angle)
