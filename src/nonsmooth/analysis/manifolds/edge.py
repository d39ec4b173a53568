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
_TURN = 1e-3  # of a ray, between whose ends the edge is as good as straight
_REACH = 20.0  # times the extent of the curve: how far along the edge a start is looked for
_ALONG = 128  # places along the edge on each side
_DEPTH = 0.05  # of the distance along the edge, by which it may bend away from its tangent
_SAME = 1e-6  # of the largest step: images before and behind a reset


class EdgePoint(NamedTuple):
    """A point of the manifold at the edge, and the one behind the reset there.

    A start at the edge that moves outward is reset to the one behind; if it moves inward, a start
    at the one behind is reset to it.
    """

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
        sides = angles[0] + np.array([-_TURN, _TURN])
        near = _ends(here, base, np.column_stack([np.cos(sides), np.sin(sides)]), far)
        found = None if near is None else _reset_to(here, edge[0], base, near, known, spacing)
        if found is None:
            return None
        behind = found[None]
    images = here.after(np.vstack([edge, behind]))
    apart = float(np.linalg.norm(images[1] - images[0]))
    if not apart <= _SAME * spacing.largest:
        return None
    image, _, _ = known.look(images[:1], known.images[-1:])
    return EdgePoint(edge[0], behind[0], float(image[0]))


def _reset_to(
    here: LocalMap,
    edge: Floats,
    inside: Floats,
    near: Floats,
    known: KnownCurve,
    spacing: Spacing,
) -> Floats | None:
    """The start at the edge that is reset to one of its points; None where there is none.

    It is looked for along the tangent of the edge, through two points ``near``, and put onto the
    edge by rays from the inside; resets that keep the edge move a start along it.
    """
    tangent = (near[1] - near[0]) / np.linalg.norm(near[1] - near[0])
    inward = np.array([-tangent[1], tangent[0]])
    inward *= np.sign(inward @ (inside - edge))
    frame = here.coordinates
    extent = np.abs(known.points).max()
    extent += np.abs(frame.origin[frame.active] / frame.scales).max()
    sizes = np.geomspace(_BEFORE * spacing.smallest, _REACH * extent, _ALONG)
    at = np.concatenate([-sizes[::-1], sizes])
    begun: Floats | None = None
    for _ in range(_ROUNDS):
        depth = np.maximum(_DEPTH * np.abs(at), _BEFORE * spacing.smallest)
        begin = edge + at[:, None] * tangent + depth[:, None] * inward
        ends = _ends(here, begin, np.broadcast_to(-inward, begin.shape), 2.0 * depth)
        if ends is None:
            return None
        misses = (here.reset_at_start(ends) - edge) @ tangent
        with np.errstate(invalid="ignore"):
            changes = np.flatnonzero(misses[1:] * misses[:-1] <= 0.0)
        if not changes.size:
            return None
        k = int(changes[np.argmin(np.abs(at[changes]))])
        begun = ends[k : k + 1]
        if abs(misses[k]) <= _SAME * _SAME * spacing.largest:
            break
        at = np.linspace(at[k], at[k + 1], _RAYS.size)
    if begun is None:
        return None
    close = np.linalg.norm(here.reset_at_start(begun)[0] - edge) <= _SAME * spacing.largest
    return np.asarray(begun[0]) if close else None


def _ends(here: LocalMap, origin: Floats, ways: Floats, far: float | Floats) -> Floats | None:
    """Last points on rays that have an image; None where a ray does not leave the states."""
    low, high = np.zeros(len(ways)), np.broadcast_to(far, len(ways)).astype(float)
    if np.isfinite(here.after(origin + high[:, None] * ways)).any():
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        there = np.isfinite(here.after(origin + middle[:, None] * ways)).all(axis=1)
        low, high = np.where(there, middle, low), np.where(there, high, middle)
    return np.asarray(origin + low[:, None] * ways)
