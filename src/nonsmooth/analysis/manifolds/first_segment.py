"""The first piece of a manifold: how far it is as straight as its direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.manifolds.saddle import Saddle, SaddlePoint
from nonsmooth.errors import OptionError

__all__ = ["FirstSegment", "first_segment"]

Floats = npt.NDArray[np.float64]

_HALVINGS = 60
_PROBES = np.array([1.0, 0.75, 0.5, 0.25, 0.125])  # of the length, where images are looked at
_QUARTER = 0.4  # of a deviation at most is left at half the length where it grows as a square
_ROUNDING = 64.0  # roundings of an image
_MANY_ROUNDINGS = 1e3  # that a length is at least, to be told from none


class FirstSegment(NamedTuple):
    """A straight piece that begins at the saddle."""

    side: float  # 1 or -1, times the direction
    length: float
    deviation: float  # of the manifold from it, at its far end
    clear: bool  # whether rounding left the deviation to be measured, and it grows as a square


def first_segment(
    saddle: Saddle, point: SaddlePoint, side: float, longest: float, accuracy: float
) -> FirstSegment:
    """The longest segment, halved from ``longest`` on, that deviates by ``accuracy`` at most.

    In coordinates along the direction and across it the manifold is c s**2 to second order, and
    the image of (s, 0) lies a s**2 beside the direction. As the manifold is its own image,
    a = c (mu**2 - nu), with the multipliers mu along and nu across it. So one image tells c; that
    half the length leaves a quarter tells that the second order is what there is. All probes have
    to do the same on their way, for that is how far the map is smooth.
    """
    here, direction, dual, _ = point
    least = _MANY_ROUNDINGS * max(here.coordinates.rounding, 1e-300)
    length = longest
    factor = abs(saddle.multiplier**2 - saddle.others)
    for _ in range(_HALVINGS):
        probes = np.append(side * length * _PROBES, 1e-3 * side * length)
        found = here.itineraries(probes[:, None] * direction)
        if np.all(found.keys == found.keys[-1]) and np.isfinite(found.points).all():
            along = found.points @ dual
            beside = np.linalg.norm(found.points - along[:, None] * direction, axis=1)
            floor = _ROUNDING * (here.coordinates.rounding + np.finfo(float).eps * length)
            deviation = float(beside[0]) / factor
            square = beside[2] <= _QUARTER * beside[0]
            if np.all(beside[:5] <= floor):
                return FirstSegment(side, length, deviation, False)
            if deviation <= accuracy and (square or beside[0] <= _ROUNDING * floor):
                return FirstSegment(side, length, deviation, bool(square))
        length *= 0.5
        if length < least:
            break
    raise OptionError(
        f"accuracy = {accuracy:g}: no part of the manifold beside the orbit is straight to that;"
        " the orbit lies at a border of the map, or rounding is larger: give a larger accuracy="
    )
