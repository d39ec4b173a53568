"""The graph of a map of one coordinate: curves that do not join where it jumps, or points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.plot.style import axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = [
    "curves",
    "draw_diagonal",
    "finish_map",
    "image_at",
    "of_motion",
    "require_map",
    "turn_of",
]

Floats = npt.NDArray[np.float64]


def require_map(data: xr.Dataset) -> None:
    """Refuse what is no return map."""
    missing = [name for name in ("image", "piece", "slope") if name not in data]
    if missing or "start" not in data.dims:
        raise OptionError(
            "the dataset has no variable 'image' over 'start'; give it a result of return_map"
        )


def of_motion(data: xr.Dataset) -> bool:
    """Whether the map is known at the points of a motion alone."""
    return "exponent_per_return" in data


def turn_of(data: xr.Dataset) -> float | None:
    """Length after which the coordinate begins anew; None where it does not."""
    return float(data["turn"]) if "turn" in data else None


def curves(data: xr.Dataset) -> Iterator[tuple[int, Floats, Floats]]:
    """Piece, starts and images of each part of the graph that is one curve."""
    start, image = data["start"].values, data["image"].values
    piece, turn = data["piece"].values, turn_of(data) or np.inf
    breaks = np.flatnonzero(
        (piece[1:] != piece[:-1]) | (np.abs(np.diff(image)) > 0.5 * turn)  # around the circle
    )
    for here in np.split(np.arange(start.size), breaks + 1):
        if piece[here[0]] >= 0:
            yield int(piece[here[0]]), start[here], image[here]


def image_at(data: xr.Dataset, value: float) -> float:
    """Image of any value, by the cubic through the two starts around it; nan where there is none.

    Where these lie in different pieces there is none either.
    """
    start, image, slope = (data[n].values for n in ("start", "image", "slope"))
    piece, turn = data["piece"].values, turn_of(data)
    i = int(np.searchsorted(start, value, side="right")) - 1
    i -= int(i == start.size - 1 and value == start[-1])
    if not 0 <= i < start.size - 1 or piece[i] < 0:
        return np.nan
    if value == start[i]:
        return float(image[i])
    if piece[i] != piece[i + 1]:
        return np.nan
    width = start[i + 1] - start[i]
    rise = image[i + 1] - image[i]
    if turn is not None:
        rise -= turn * np.rint(rise / turn)
    t = (value - start[i]) / width
    first, last = slope[i] * width, slope[i + 1] * width
    steep = max(abs(first), abs(last)) > 3.0 * abs(rise) + 1e-300
    if not np.isfinite(first + last) or (first * last > 0.0 and steep):
        first = last = rise  # a root, which no cubic follows
    step = t * (first + t * (3.0 * rise - 2.0 * first - last + t * (first + last - 2.0 * rise)))
    found = image[i] + step
    return float(found if turn is None else np.mod(found, turn))


def draw_diagonal(ax: Axes, low: float, high: float) -> None:
    """The line on which images are the starts."""
    ax.plot([low, high], [low, high], color="0.6", linewidth=0.7, linestyle="-", zorder=1)


def finish_map(ax: Axes, data: xr.Dataset) -> None:
    """Labels of both axes."""
    finish_axes(ax, axis_label(data["start"]), _image_label(data))


def _image_label(data: xr.Dataset) -> str:
    """Label of the images: that of the starts, and which return it is."""
    order = int(data.attrs.get("order", 1))
    which = "next" if order == 1 else f"{order} points on"
    words: dict[str, Any] = dict(data["start"].attrs)
    words["long_name"] = f"{words.get('long_name') or 'start'}, {which}"
    return axis_label(data["start"].assign_attrs(words))
