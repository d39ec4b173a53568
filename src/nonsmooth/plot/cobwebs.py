"""The cobweb: how a map of one coordinate leads on from a start, step by step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.map_graph import (
    curves,
    draw_diagonal,
    finish_map,
    image_at,
    of_motion,
    require_map,
    turn_of,
)
from nonsmooth.plot.style import PALETTE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["cobweb"]

_FEW = 60  # steps that are told one from the other


def cobweb(
    data: xr.Dataset,
    start: float | None = None,
    *,
    steps: int = 50,
    transient: int = 0,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Graph of a return map with its diagonal, a staircase and the fixed points.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `return_map`.
    start : float, optional
        Where the staircase begins; there is none without it. With a map of ``points`` it is the
        number of the point from which the motion is followed.
    steps : int, optional
        Most steps of the staircase; it ends where the map does.
    transient : int, optional
        First steps that are not drawn.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new square axes by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one range in both directions. Full circles are stable fixed points of the
        map, empty ones are unstable. Curves end where the map jumps.

    Raises
    ------
    OptionError
        For another dataset, or a start outside the map.

    Notes
    -----
    Between two starts of the dataset the staircase follows the cubic through their images and
    slopes, so that it is as exact as the graph; nothing is simulated.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mole = ns.PoincareMap(ns.models.moling(), "2*xi*y + q = 1", direction=-1)
    >>> found = ns.return_map(
    ...     mole, "phase", (0, 62), completion={"q": 1, "y": 0}, mode="contact", samples=50
    ... )
    >>> ax = ns.plot.cobweb(found, 30.0)
    >>> ax.get_xlabel()
    'time since the period began'
    """
    require_map(data)
    ax = _square_axes() if ax is None else ax
    low, high = _range(data)
    draw_diagonal(ax, low, high)
    if of_motion(data):
        ax.plot(
            data["start"], data["image"], linestyle="none", marker=".", markersize=2.0,
            markeredgewidth=0.0, color="black", label="points of the motion", zorder=3,
        )  # fmt: skip
    else:
        for k, (_, across, up) in enumerate(curves(data)):
            single = across.size == 1
            ax.plot(
                across, up, color="black", linewidth=1.2, marker="." if single else None,
                markersize=2.0, label=None if k else "map", zorder=3,
            )  # fmt: skip
    if start is not None:
        _draw_staircase(ax, _orbit(data, start, steps), transient)
    _draw_fixed_points(ax, data)
    margin = 0.02 * (high - low)
    ax.set(xlim=(low - margin, high + margin), ylim=(low - margin, high + margin))
    finish_map(ax, data)
    if legend:
        place_legend(ax)
    return ax


def _square_axes() -> Any:
    ax = new_axes()
    ax.figure.set_size_inches(*[max(ax.figure.get_size_inches())] * 2)
    ax.set_aspect("equal")
    return ax


def _range(data: xr.Dataset) -> tuple[float, float]:
    """Range of starts and of images together; all of a turn where there is one."""
    values = np.concatenate([data["start"].values, data["image"].values])
    values = values[np.isfinite(values)]
    low, high = float(values.min()), float(values.max())
    turn = turn_of(data)
    if turn is not None:
        low, high = min(low, 0.0), max(high, turn)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _orbit(data: xr.Dataset, start: float, steps: int) -> npt.NDArray[np.float64]:
    """Values that the map leads through."""
    if of_motion(data):
        first = int(start)
        if first != start or not 0 <= first < data.sizes["start"]:
            raise OptionError(
                f"start = {start:g}: with a map of points give the number of one of them, from 0 to"
                f" {data.sizes['start'] - 1}"
            )
        return data["start"].values[first : first + steps + 1]
    values = [float(start)]
    while len(values) <= steps:
        image = image_at(data, values[-1])
        if not np.isfinite(image):
            break
        values.append(image)
    if len(values) == 1 and steps > 0:
        low, high = float(data["start"].min()), float(data["start"].max())
        raise OptionError(
            f"start = {start:g}: the map has no image there; its starts lie from {low:g} to"
            f" {high:g}, with gaps where status is not 'completed'"
        )
    return np.array(values)


def _draw_staircase(ax: Axes, values: npt.NDArray[np.float64], transient: int) -> None:
    """Up to the map and across to the diagonal, again and again."""
    shown = values[max(0, transient) :]
    if shown.size < 2:
        return
    across = np.repeat(shown, 2)[:-1]
    up = np.concatenate([[shown[0]], np.repeat(shown[1:], 2)])
    many = shown.size > _FEW
    ax.plot(
        across, up, color=PALETTE["vermilion"], linewidth=0.4 if many else 0.7,
        alpha=0.7 if many else 1.0, label="steps", zorder=2,
    )  # fmt: skip
    if not transient:
        ax.plot(
            shown[:1], shown[:1], linestyle="none", marker="s", markersize=3.5,
            color=PALETTE["vermilion"], label="start", zorder=5,
        )  # fmt: skip


def _draw_fixed_points(ax: Axes, data: xr.Dataset) -> None:
    if "fixed_start" not in data:
        return
    at, stable = data["fixed_start"].values, data["fixed_stable"].values
    for here, face, label in (
        (stable, PALETTE["blue"], "stable fixed point"),
        (~stable, "white", "unstable fixed point"),
    ):
        if here.any():
            ax.plot(
                at[here], at[here], linestyle="none", marker="o", markersize=4.5,
                markerfacecolor=face, markeredgecolor=PALETTE["blue"], markeredgewidth=1.0,
                label=label, zorder=4,
            )  # fmt: skip
