"""Names beside points, none on another one, on a point or beyond the axes where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["named_points", "write_names"]

Array = npt.NDArray[np.float64]

_ID = "name of a point"
_DISTANCES = (4.0, 8.0, 13.0, 19.0, 26.0, 34.0, 43.0)  # points, from a point to its name
_NEAR = 6.0  # beyond it a line leads to the name
_MARK = 3.0  # half of a point with what is kept free about it
_ROUNDS = 4
_ON_OTHER, _OUTSIDE, _ON_LINE = 50.0, 500.0, 0.3  # costs by the distance


class _Room(NamedTuple):
    """What is in the way, in points from the lower left corner of the axes."""

    size: Array
    marks: Array  # boxes: left, low, right, high
    lines: Array


def named_points(ax: Axes) -> list[tuple[str, tuple[float, float]]]:
    """Names that `write_names` wrote, each with its point."""
    return [(note.get_text(), (note.xy[0], note.xy[1])) for note in _notes(ax)]


def write_names(ax: Axes, named: Sequence[tuple[str, tuple[float, float]]], size: float) -> None:
    """Write names beside their points in place of those that are there.

    Each goes to where it is in the way of least, and all once more while the others stay.
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    for note in _notes(ax):
        note.remove()
    figure.draw_without_rendering()  # the layout moves the axes, and places are in points
    scale = 72.0 / figure.dpi
    frame = ax.get_window_extent()

    def places(data: Any) -> Array:
        pixels = ax.transData.transform(np.asarray(data, dtype=float))
        return np.asarray((pixels - [frame.x0, frame.y0]) * scale)

    dots = places(np.concatenate([np.asarray(c.get_offsets()) for c in ax.collections]))
    lines = [_between(places(line.get_xydata())) for line in ax.lines]
    room = _Room(
        np.array([frame.width, frame.height]) * scale,
        np.concatenate([dots - _MARK, dots + _MARK], axis=1),
        np.concatenate(lines) if lines else np.empty((0, 2)),
    )
    at = places([point for _, point in named])
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.3, "alpha": 0.8}
    for (text, point), (dx, dy, far) in zip(
        named, _placed(at, _extents([text for text, _ in named], size), room), strict=True
    ):
        leader = {"arrowstyle": "-", "linewidth": 0.4, "color": "0.4", "shrinkA": 0.0, "shrinkB": 2}
        ax.annotate(
            text, point, (dx, dy), textcoords="offset points", fontsize=size, ha="center",
            va="center", gid=_ID, arrowprops=leader if far > _NEAR else None, zorder=2, bbox=ground,
        )  # fmt: skip


def _notes(ax: Axes) -> list[Any]:
    return [text for text in ax.texts if text.get_gid() == _ID]


def _extents(texts: list[str], size: float) -> Array:
    """Width and height of each text in points."""
    from matplotlib.textpath import TextPath

    widths = [TextPath((0.0, 0.0), text or " ", size=size).get_extents().width for text in texts]
    return np.array([(width + 2.0, 1.15 * size) for width in widths])


def _between(ends: Array) -> Array:
    steps = np.linspace(0.0, 1.0, 400)[:, None]
    return ends[0] + steps * (ends[-1] - ends[0])


def _placed(at: Array, extents: Array, room: _Room) -> list[tuple[float, float, float]]:
    """Offset of the middle of each name from its point, and its distance."""
    chosen = np.full((len(at), 4), -1e6)  # boxes, at first far away
    found = [(0.0, 0.0, 0.0)] * len(at)
    angles = 2.0 * np.pi * np.arange(24) / 24
    way = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(_ROUNDS):
        for k in range(len(at)):
            offsets = np.concatenate([way * (far + extents[k] / 2.0) for far in _DISTANCES])
            distance = np.repeat(_DISTANCES, angles.size)
            middle = at[k] + offsets
            boxes = np.concatenate([middle - extents[k] / 2.0, middle + extents[k] / 2.0], axis=1)
            others = np.concatenate([np.delete(chosen, k, axis=0), room.marks])
            cost = distance + _ON_OTHER * _overlaps(boxes, others)
            outside = np.maximum(-boxes[:, :2], 0.0) + np.maximum(boxes[:, 2:] - room.size, 0.0)
            cost += _OUTSIDE * np.any(outside > 0.0, axis=1)
            cost += _ON_LINE * _inside(boxes, room.lines)
            for part in (0.3, 0.5, 0.7):  # a line that leads across a name is in its way
                spot = at[k] + part * offsets
                own = np.concatenate([spot, spot], axis=1)
                cost += _ON_OTHER * (distance > _NEAR) * _overlaps(own, np.delete(chosen, k, 0))
            best = int(np.argmin(cost))
            chosen[k] = boxes[best]
            found[k] = (float(offsets[best, 0]), float(offsets[best, 1]), float(distance[best]))
    return found


def _overlaps(boxes: Array, others: Array) -> Array:
    """Of how many others each box covers a part."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    return np.sum(np.all(high >= low, axis=2), axis=1).astype(float)


def _inside(boxes: Array, points: Array) -> Array:
    there = (points >= boxes[:, None, :2]) & (points <= boxes[:, None, 2:])
    return np.sum(np.all(there, axis=2), axis=1).astype(float)
