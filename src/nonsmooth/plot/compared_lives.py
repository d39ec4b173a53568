"""`lives`: predicted lives over measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["lives"]

_WIDEST = 1e6  # band of lives
_MARKS = "osD^v<>P"
_ROOM = 2.5  # factor left free around the points

Array = npt.NDArray[np.float64]

_ID = "name of a point"
_DISTANCES = (4.0, 8.0, 13.0, 19.0, 26.0, 34.0, 43.0)  # points, from a point to its name
_NEAR = 6.0  # beyond it a line leads to the name
_MARK = 3.0  # half of a point with what is kept free about it
_ROUNDS = 4
_ON_OTHER, _OUTSIDE, _ON_LINE = 50.0, 500.0, 0.3  # costs by the distance


@checked
def lives(
    compared: xr.Dataset,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    factor: float = 2.0,
    names: bool = True,
    legend: bool = True,
) -> Axes:
    """Predicted lives over measured ones, both logarithmic, with the line on which they agree.

    Two calls on the same axes show two laws together; tests of one name are named once.

    Parameters
    ----------
    compared : xarray.Dataset
        Result of `fatigue.compare_lives`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    label : str, optional
        Text of the legend; it says by itself where a law was fitted to these lives.
    factor : float, optional
        Dashed lines at this factor above and below; none for one.
    names : bool, optional
        Whether to write the names of the tests beside the points.
    legend : bool, optional
        Whether to draw a legend, of the points and of the lines.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; lives that are infinite are left out.

    Raises
    ------
    OptionError
        For another dataset, or a factor below one.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> found = xr.Dataset(
    ...     {"measured": ("test", [100.0, 900.0]), "predicted": ("test", [200.0, 1000.0])},
    ...     attrs={"in_sample": 1},
    ... )
    >>> _, (ax,) = ns.plot.print_figure()
    >>> ax = ns.plot.lives(found, ax=ax, label="Walker")
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['Walker (fitted, in sample)', 'predicted as measured', 'a factor of 2 off']
    """
    if "measured" not in compared or "predicted" not in compared or "test" not in compared.dims:
        raise OptionError("compared: give a result of fatigue.compare_lives")
    if not 1.0 <= factor <= _WIDEST:
        raise OptionError(f"factor = {factor:g} must be from 1 to {_WIDEST:g}")
    ax = new_axes() if ax is None else ax
    x, y = compared["measured"].values, compared["predicted"].values
    there = np.isfinite(x) & np.isfinite(y)
    if not there.any():
        raise OptionError("no life is finite, so there is none to draw")
    number = len(ax.collections)
    text = label or "predicted"
    if compared.attrs.get("in_sample"):
        text += " (fitted, in sample)"
    ax.scatter(
        x[there], y[there], s=14.0, marker=_MARKS[number % len(_MARKS)],
        color=list(PALETTE.values())[number % len(PALETTE)], label=text, zorder=3,
    )  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    _limits(ax, factor)
    finish_axes(ax, _axis(compared, "measured"), _axis(compared, "predicted"))
    if legend:
        place_legend(ax)
    named = named_points(ax)
    if names and "test" in compared.coords:
        known = {name for name, _ in named}
        tests = [str(name) for name in compared["test"].values[there]]
        points = zip(tests, zip(x[there], y[there], strict=True), strict=True)
        named += [(name, (float(a), float(b))) for name, (a, b) in points if name not in known]
    if named:
        write_names(ax, named, float(ax.xaxis.label.get_fontsize()) - 2.0)
    return ax


def _axis(compared: xr.Dataset, name: str) -> str:
    variable = compared[name]
    return axis_label(variable) if "long_name" in variable.attrs else f"{name} life"


def _limits(ax: Axes, factor: float) -> None:
    """Limits of all points drawn so far, and the line of agreement across them."""
    points = np.concatenate([np.asarray(c.get_offsets()) for c in ax.collections])
    low, high = points.min(axis=0) / _ROOM, points.max(axis=0) * _ROOM
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    for line in list(ax.lines):
        line.remove()
    ends = np.array([min(low) / factor, max(high) * factor])
    rows: list[tuple[float, str, str | None]] = [(1.0, "-", "predicted as measured")]
    if factor > 1.0:
        rows += [(factor, "--", f"a factor of {factor:g} off"), (1.0 / factor, "--", None)]
    for times, style, text in rows:
        ax.plot(
            ends, times * ends, color="black", linestyle=style, linewidth=0.6, zorder=1, label=text
        )


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
