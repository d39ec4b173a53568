"""From the coordinates of a shape to its outline: points of a line or an area in each frame.

Coordinates are arrays over frames or single numbers; outlines have the shape (frames, points). A
gap in a line is a point of nan.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = [
    "arrow",
    "circle",
    "damper",
    "ground",
    "polyline",
    "rectangle",
    "spring",
]

Floats = npt.NDArray[np.float64]
Outline = tuple[Floats, Floats]

_ROUND = 61  # points of a circle
_ENDS = 0.16  # of the length of a spring, straight at either end
_CUP, _PISTON = (0.3, 0.75), 0.5  # of the length of a damper
_HEAD = 0.42  # half the width of the head of an arrow over its length
_GAP = np.nan


def _points(*points: Sequence[Any]) -> Outline:
    """Columns of points, each a pair of numbers or of arrays over frames."""
    x, y = zip(*points, strict=True)
    return (
        np.stack(np.broadcast_arrays(*x), axis=-1).astype(float),
        np.stack(np.broadcast_arrays(*y), axis=-1).astype(float),
    )


def polyline(points: Sequence[Sequence[Any]]) -> Outline:
    """The points as they are."""
    return _points(*points)


def rectangle(x: Sequence[Any], y: Sequence[Any]) -> Outline:
    """Corners between two values in x and two in y."""
    return _points((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))


def circle(centre: Sequence[Any], radius: Any) -> Outline:
    """A circle, drawn as a polygon."""
    angle = np.linspace(0.0, 2.0 * np.pi, _ROUND)
    x, y, size = (np.asarray(value, float)[..., None] for value in (*centre, radius))
    return x + size * np.cos(angle), y + size * np.sin(angle)


def _along(start: Sequence[Any], end: Sequence[Any], along: Any, across: Any) -> Outline:
    """Points given by their share of the way from start to end, and by a length across it.

    ``across`` may differ between frames: its first axis counts them.
    """
    begin = [np.asarray(value, float)[..., None] for value in start]
    way = [np.asarray(b, float)[..., None] - a for a, b in zip(begin, end, strict=True)]
    length = np.hypot(*way)
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = [np.where(length > 0.0, each / length, 0.0) for each in way]
    return (
        begin[0] + along * way[0] - across * unit[1],
        begin[1] + along * way[1] + across * unit[0],
    )


def _wide(width: Any, shares: npt.ArrayLike) -> Floats:
    """Lengths across, of a width that may change from frame to frame."""
    return np.asarray(width, float)[..., None] * np.asarray(shares, float)


def spring(start: Sequence[Any], end: Sequence[Any], width: Any, turns: int) -> Outline:
    """A zigzag with straight ends."""
    along = np.linspace(_ENDS, 1.0 - _ENDS, 4 * turns + 1)[1::2]
    across = np.where(np.arange(along.size) % 2 == 0, 0.5, -0.5)
    along = np.concatenate([[0.0, _ENDS], along, [1.0 - _ENDS, 1.0]])
    across = np.concatenate([[0.0, 0.0], across, [0.0, 0.0]])
    return _along(start, end, along, _wide(width, across))


def damper(start: Sequence[Any], end: Sequence[Any], width: Any) -> Outline:
    """A cup on a rod and a piston on another."""
    bottom, rim = _CUP
    along = [0.0, bottom, _GAP, rim, bottom, bottom, rim, _GAP, 1.0, _PISTON, _GAP]
    across = [0.0, 0.0, _GAP, 0.5, 0.5, -0.5, -0.5, _GAP, 0.0, 0.0, _GAP]
    along += [_PISTON, _PISTON]
    across += [0.36, -0.36]
    return _along(start, end, np.array(along), _wide(width, across))


def ground(start: Sequence[Any], end: Sequence[Any], depth: Any, strokes: int) -> Outline:
    """A line with strokes on its right-hand side, seen from its start: what does not give way."""
    step = 1.0 / strokes
    along, across = [0.0, 1.0, _GAP], [0.0, 0.0, _GAP]
    for k in range(strokes):
        along += [(k + 1.0) * step, k * step, _GAP]
        across += [0.0, -1.0, _GAP]
    return _along(start, end, np.array(along[:-1]), _wide(depth, across[:-1]))


def arrow(start: Sequence[Any], end: Sequence[Any], head: Any) -> Outline:
    """An arrow that has a head of a fixed length, or of its own length where it is shorter."""
    begin = [np.asarray(value, float) for value in start]
    way = [np.asarray(b, float) - a for a, b in zip(begin, end, strict=True)]
    length = np.hypot(*way)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(length > 0.0, np.minimum(1.0, head / length), 0.0)
    back, size = 1.0 - share[..., None], (_HEAD * np.minimum(head, length))[..., None]
    along = np.concatenate([0.0 * back, 1.0 + 0.0 * back, back, 1.0 + 0.0 * back, back], axis=-1)
    return _along(start, end, along, size * np.array([0.0, 0.0, 1.0, 0.0, -1.0]))
