"""Arrows beside a row of points, which tell the way that it goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_arrow"]

_LENGTH = 18.0  # points; a way that is shorter gets no arrow
_LEAST = 3.0  # points, of a way that has a direction
_BESIDE = 5.0  # points from the path
_CLEAR = 3.0  # points from other arrows

Floats = npt.NDArray[np.float64]


def draw_arrow(ax: Axes, path: Floats, others: list[Floats]) -> None:
    """Arrow beside the middle of a path; none where the path is shorter, or another one is there.

    It lies outside of the bow of the path, and joins the others.

    shapes: path (K, 2), in units of the data; others (n, 2), points along arrows on paper
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    unit = 72.0 / figure.dpi
    seen = ax.transData.transform(path) * unit
    away = np.hypot(*(seen - seen[-1]).T)
    if len(path) < 2 or away.max() < _LENGTH:
        return
    # half way to the end; the beginning may wind where the motion settles
    k = int(np.flatnonzero(away >= 0.5 * away.max())[-1])
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(seen, axis=0).T))])
    first, middle, last = (
        np.array([np.interp(ways[k] + shift, ways, column) for column in seen.T])
        for shift in (-0.5 * _LENGTH, 0.0, 0.5 * _LENGTH)
    )
    along = last - first
    if np.hypot(*along) < _LEAST:  # it turns there
        along = seen[-1] - seen[0]
    along = along / np.hypot(*along)
    across = np.array([-along[1], along[0]])
    if across @ (middle - 0.5 * (seen[0] + seen[-1])) < 0.0:
        across = -across
    tail = middle + _BESIDE * across - 0.5 * _LENGTH * along
    tip = tail + _LENGTH * along
    arrow = np.linspace(tail, tip, int(_LENGTH))
    if any(np.hypot(*(arrow[:, None] - one).T).min() < _CLEAR for one in others):
        return
    others.append(arrow)
    back = ax.transData.inverted()
    start, end = (back.transform(place / unit) for place in (tail, tip))
    ax.annotate(
        "",
        xy=(float(end[0]), float(end[1])),
        xytext=(float(start[0]), float(start[1])),
        arrowprops={
            "arrowstyle": "-|>,head_length=0.35,head_width=0.16",
            "color": "black",
            "linewidth": 0.8,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
        annotation_clip=False,
        zorder=5,
    )
