"""Sizes of marks that would lie on each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["depths", "spaced", "uncrowded"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_SHARE = 0.1  # of the marks, which may lie closer to another one than their size
_SAME = 1.0  # points within which marks are in one place
_MOST = 500  # marks that are looked at


def uncrowded(ax: Axes, x: Floats, y: Floats, size: float, least: float) -> float:
    """Size, in points, at which nine of ten marks do not reach the next one; not below the least.

    Marks in one place count as one: there no size helps.
    """
    across, up = _places(ax, x, y)
    if across.size < 2:
        return size
    apart = np.hypot(across[:, None] - across, up[:, None] - up)
    nearest = np.where(apart < _SAME, np.inf, apart).min(axis=1)
    return float(np.clip(np.quantile(nearest, _SHARE, method="lower"), least, size))


def depths(ax: Axes, x: Floats, y: Floats, kinds: list[str]) -> npt.NDArray[np.int64]:
    """How many other kinds have earlier marks in the place of each one.

    Of one kind many may lie there, and they hide nothing but each other.
    """
    across, up = _places(ax, x, y, most=x.size)
    apart = np.hypot(across[:, None] - across, up[:, None] - up)
    kind = np.array(kinds, dtype=str)
    there = np.tril((apart < _SAME) & (kind[:, None] != kind), -1)
    found = np.zeros(kind.size, np.int64)
    for one in np.unique(kind):
        found += there[:, kind == one].any(axis=1)
    return found


def spaced(ax: Axes, x: Floats, y: Floats, kinds: list[str], distance: float) -> Mask:
    """Marks to keep so that no two of one kind lie closer than a distance in points.

    Of those that are too close the first one stays. Those in one place hide nothing else.
    """
    across, up = _places(ax, x, y, most=x.size)
    kind, kept = np.array(kinds, dtype=str), np.zeros(len(kinds), bool)
    for k in range(len(kinds)):
        alike = kept & (kind == kind[k])
        apart = np.hypot(across[alike] - across[k], up[alike] - up[k])
        kept[k] = bool(np.all((apart >= distance) | (apart < _SAME)))
    return kept


def _places(ax: Axes, x: Floats, y: Floats, most: int = _MOST) -> tuple[Floats, Floats]:
    """Where marks are on the picture, in points."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    every = max(1, -(-len(x) // most)) if most else 1
    points = ax.transData.transform(np.column_stack([x, y])[::every]) * 72.0 / figure.dpi
    return points[:, 0], points[:, 1]
