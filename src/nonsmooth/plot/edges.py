"""The motion on a border of basins: one state over another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend, with_former
from nonsmooth.plot.style import LINES, axis_label, finish_axes, two_states

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["edge_state"]

_SADDLE, _TRACK, _START = 4.6, 3.0, 3.6  # points


@checked
def edge_state(
    data: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    track: bool = True,
    legend: bool = True,
) -> Axes:
    """The track along a border of two basins, and the saddle or the set to which it comes.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `edge_state`.
    x, y : str, optional
        States to draw; the first two by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default. Those of `nonsmooth.plot.basins`
        keep their limits.
    track : bool, optional
        Whether to draw the segment between the two starts, and the track from it on.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. Diamonds are the points of a saddle, dots those of another set, circles the
        track, in the order of the iterates along a thin line.

    Raises
    ------
    OptionError
        For another dataset, or an unknown state.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> wells = ns.System(
    ...     states=["x", "v"], equations={"x": "v", "v": "x - x**3 - 0.5*v"}, period=1.0
    ... )
    >>> edge = ns.edge_state(wells, {"x": -0.7}, {"x": 1.2}, iterates=50)
    >>> ax = ns.plot.edge_state(edge)
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['starts', 'track along the border', 'saddle, period 1']
    """
    across, up = _states(data, x, y)
    own = ax is None
    ax = new_axes() if ax is None else ax
    if track:
        ends, way = data["start"], data["track"]
        ax.plot(
            ends.sel(state=across), ends.sel(state=up), **LINES[2], marker="s",
            markersize=_START, label="starts", zorder=4,
        )  # fmt: skip
        ax.plot(
            way.sel(state=across), way.sel(state=up), color="black", linewidth=0.4, marker="o",
            markersize=_TRACK, markerfacecolor="white", markeredgewidth=0.7,
            label="track along the border", zorder=5,
        )  # fmt: skip
    found = str(data["kind"].item())
    is_saddle = found == "periodic"
    text = f"saddle, period {int(data['period'])}" if is_saddle else f"{found} set on the border"
    ax.plot(
        data[across], data[up], linestyle="none", marker="D" if is_saddle else ".",
        markersize=_SADDLE if is_saddle else _TRACK, markerfacecolor=LINES[1]["color"],
        markeredgecolor="black" if is_saddle else LINES[1]["color"], markeredgewidth=0.7,
        label=text, zorder=6,
    )  # fmt: skip
    finish_axes(ax, axis_label(data[across]), axis_label(data[up]))
    if legend:
        place_legend(ax, with_former(ax), may_grow=own)
    return ax


def _states(data: xr.Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    """The states to draw."""
    if "crossing" not in data or "track" not in data:
        raise OptionError("the dataset holds no edge state; give a result of edge_state")
    known = [str(name) for name in data["state"].values]
    return two_states(known, x, y)
