"""`lives`: predicted lives over measured ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes, place_legend

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["lives"]

_MARKS = "osD^v<>P"
_ROOM = 2.5  # factor left free around the points
_EDGE = 0.25  # part of the axis near whose ends names go inward


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

    Two calls on the same axes show two laws together.

    Parameters
    ----------
    compared : xarray.Dataset
        Result of `fatigue.compare_lives`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    label : str, optional
        Text of the legend; it says by itself where a law was fitted to these lives.
    factor : float, optional
        Dashed lines at this factor above and below.
    names : bool, optional
        Whether to write the names of the tests beside the points.
    legend : bool, optional
        Whether to draw a legend.

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
    ['Walker (fitted, in sample)']
    """
    if "measured" not in compared or "predicted" not in compared or "test" not in compared.dims:
        raise OptionError("give a result of fatigue.compare_lives")
    if not factor >= 1.0:
        raise OptionError(f"factor = {factor!r:.40} is below one")
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
    if names and "test" in compared.coords:
        _write_names(ax, compared["test"].values[there], x[there], y[there])
    finish_axes(ax, _axis(compared, "measured"), _axis(compared, "predicted"))
    if legend:
        place_legend(ax)
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
    for times, style in ((1.0, "-"), (factor, "--"), (1.0 / factor, "--")):
        ax.plot(ends, times * ends, color="black", linestyle=style, linewidth=0.6, zorder=1)


def _write_names(ax: Axes, names: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
    """Names left of points above the line of agreement and right of others, none on another."""
    (left, right), (low, high) = np.log(ax.get_xlim()), np.log(ax.get_ylim())
    across, up = (np.log(x) - left) / (right - left), (np.log(y) - low) / (high - low)
    figure = ax.get_figure(root=True)
    assert figure is not None
    height = ax.get_window_extent().height / figure.dpi * 72.0  # points
    size = float(ax.xaxis.label.get_fontsize()) - 2.0
    to_left = np.where(across < _EDGE, False, (y > x) | (across > 1.0 - _EDGE))
    for side in (True, False):
        below = -np.inf
        for k in sorted(np.flatnonzero(to_left == side), key=lambda k: up[k]):
            place = max(up[k] * height, below + size)
            below = place
            ax.annotate(
                str(names[k]), (x[k], y[k]), (-4.0 if side else 4.0, place - up[k] * height),
                textcoords="offset points", fontsize=size, ha="right" if side else "left",
                va="center",
            )  # fmt: skip
