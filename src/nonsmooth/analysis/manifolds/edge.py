"""Where a stable manifold comes to the edge of the states, and where a reset leads from there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.curve import Spacing
from nonsmooth.analysis.manifolds.known_curve import KnownCurve
from nonsmooth.analysis.manifolds.local_map import LocalMap
from nonsmooth.runs.stroboscopic_map import StroboscopicMap

__all__ = ["EdgePoint", "edge_point"]

Floats = npt.NDArray[np.float64]

_RAYS = np.linspace(-0.5, 0.5, 33)  # angles from the heading
_BEFORE = 20.0  # of the smallest step: where rays begin
_HALVINGS = 60
_ROUNDS = 12  # each of which leaves a 32th of the angle
_SAME = 1e-6  # of the largest step: images before and behind a reset


class EdgePoint(NamedTuple):
    """A point of the manifold at the edge, and the one to which a start there is reset."""

    edge: Floats
    behind: Floats
    image: float  # where the image of both lies along the curve


def edge_point(here: LocalMap, known: KnownCurve, spacing: Spacing) -> EdgePoint | None:
    """The point of the manifold at the edge of the states near the last point of the curve.

    Rays from a point a little before it end at the edge; the one that ends on the manifold is found
    by the side of their ends. None where there is no edge, or no reset at it.
    """
    if not isinstance(here.chosen, StroboscopicMap):
        return None
    away = np.linalg.norm(known.points - known.points[-1], axis=1)
    base = known.points[np.flatnonzero(away >= _BEFORE * spacing.smallest)[-1]]
    heading = known.points[-1] - base
    far = 2.0 * float(np.linalg.norm(heading))
    angles = np.arctan2(heading[1], heading[0]) + _RAYS
    place = np.full(angles.size, len(known.points) - 1.0)
    depth = np.full(angles.size, int(known.depths[-1]) + 1)
    ends = base[None]
    for _ in range(_ROUNDS):
        ways = np.column_stack([np.cos(angles), np.sin(angles)])
        found = _ends(here, base, ways, far)
        if found is None:
            return None
        ends = found
        sides = known.sides(here, ends, place, depth)
        changes = np.flatnonzero(sides[1:] * sides[:-1] < 0.0)
        if not changes.size:
            break
        k = int(changes[0])
        ends = ends[k : k + 2]
        angles = np.linspace(angles[k], angles[k + 1], _RAYS.size)
    if len(ends) != 2:
        return None
    edge = ends[:1]
    behind = here.reset_at_start(edge)
    if not np.isfinite(behind).all():
        return None
    images = here.after(np.vstack([edge, behind]))
    apart = float(np.linalg.norm(images[1] - images[0]))
    if not apart <= _SAME * spacing.largest:
        return None
    image, _, _ = known.look(images[:1], known.images[-1:])
    return EdgePoint(edge[0], behind[0], float(image[0]))


def _ends(here: LocalMap, origin: Floats, ways: Floats, far: float) -> Floats | None:
    """Last points on rays that have an image; None where a ray does not leave the states."""
    low, high = np.zeros(len(ways)), np.full(len(ways), far)
    if np.isfinite(here.after(origin + far * ways)).any():
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        there = np.isfinite(here.after(origin + middle[:, None] * ways)).all(axis=1)
        low, high = np.where(there, middle, low), np.where(there, high, middle)
    return np.asarray(origin + low[:, None] * ways)
