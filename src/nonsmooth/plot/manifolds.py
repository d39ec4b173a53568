"""Stable and unstable manifolds as curves: one state over another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend, with_former
from nonsmooth.plot.style import LINES, axis_label, finish_axes, two_states
from nonsmooth.plot.turns import Turns

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["manifold"]

Floats = npt.NDArray[np.float64]

_LOOKS: dict[str, dict[str, Any]] = {"stable": LINES[0], "unstable": {**LINES[1], "linestyle": "-"}}
_APART = ("jump", "end", "unresolved")  # borders over which no line is drawn
_MARKS = {"corner": "o", "jump": "s", "end": "|", "unresolved": "x"}
_NAMES = {"corner": "corners", "jump": "jumps", "end": "ends", "unresolved": "unresolved borders"}
_MARK = 3.2  # points


@checked
def manifold(
    data: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    borders: bool = True,
    within_turn: bool = False,
    legend: bool = True,
) -> Axes:
    """Curves of a manifold, with the orbit that they come from.

    Stable manifolds are black and unstable ones vermilion, so that both go into one picture, and
    into one with basins.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `manifold`.
    x, y : str, optional
        States to draw; the first two by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default. Those of `nonsmooth.plot.basins`
        keep their limits.
    borders : bool, optional
        Whether to mark corners by circles, and jumps by squares. Curves are interrupted at jumps
        either way.
    within_turn : bool, optional
        Whether to draw angles within one turn. It begins at the left or lower end of ``ax``, as of
        a picture of basins, or half a turn below zero on new axes. Otherwise curves go on beyond a
        turn as they are.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; points of the orbit are diamonds.

    Raises
    ------
    OptionError
        For another dataset, or an unknown state.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> hill = ns.System(states=["x", "v"], equations={"x": "v", "v": "x + cos(t)"}, period="2*pi")
    >>> orbit = ns.find_orbit(hill, {"x": -0.5})
    >>> ax = ns.plot.manifold(ns.manifold(hill, orbit, length=2.0))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['unstable manifold', 'orbit']
    """
    across, up = _states(data, x, y)
    which = str(data.attrs.get("which", "unstable"))
    own = ax is None
    ax = new_axes() if ax is None else ax
    label: str | None = f"{which} manifold"
    turns = Turns.of(data, (across, up), None if own else ax) if within_turn else Turns.none()
    for columns in _curves(data, across, up):
        ax.plot(*turns.cut_curve(*columns), **_LOOKS.get(which, LINES[0]), label=label, zorder=3)
        label = None
    if borders:
        _mark_borders(ax, data, turns.folded(data[across].values, data[up].values))
    orbit = data["saddle"]
    ax.plot(
        *turns.folded(orbit.sel(state=across).values, orbit.sel(state=up).values),
        linestyle="none", marker="D", markersize=_MARK + 0.6, markerfacecolor="white",
        markeredgecolor="black", markeredgewidth=0.9, label="orbit", zorder=4,
    )  # fmt: skip
    finish_axes(ax, axis_label(data[across]), axis_label(data[up]))
    if own:
        turns.show(ax)
    if legend:
        place_legend(ax, with_former(ax), may_grow=own)
    return ax


def _states(data: xr.Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    """The states to draw."""
    if "curve_of_point" not in data.coords or "saddle" not in data:
        raise OptionError("the dataset holds no manifold; give a result of manifold")
    known = [str(name) for name in data["state"].values]
    return two_states(known, x, y)


def _curves(data: xr.Dataset, across: str, up: str) -> list[tuple[Floats, Floats]]:
    """Columns of each curve, with gaps where it is interrupted."""
    numbers = data["curve_of_point"].values
    apart = np.isin(data["border_kind"].values, _APART)
    breaks = data["border_point"].values[apart] + 1
    found = []
    for number in np.unique(numbers):
        here = np.flatnonzero(numbers == number)
        cuts = breaks[(breaks > here[0]) & (breaks <= here[-1])] - here[0]
        found.append(
            (
                np.insert(data[across].values[here], cuts, np.nan),
                np.insert(data[up].values[here], cuts, np.nan),
            )
        )
    return found


def _mark_borders(ax: Axes, data: xr.Dataset, columns: tuple[Floats, Floats]) -> None:
    """Marks at the points of borders that are seen."""
    for kind, marker in _MARKS.items():
        at = data["border_point"].values[data["border_kind"].values == kind]
        points = at if kind == "corner" else np.concatenate([at, at + 1])
        points = points[points < data.sizes["point"]]
        if points.size:
            look = _LOOKS.get(str(data.attrs.get("which")), LINES[0])
            ax.plot(
                columns[0][points], columns[1][points], linestyle="none", marker=marker,
                markersize=_MARK, markerfacecolor="none", markeredgecolor=look["color"],
                markeredgewidth=0.7, label=_NAMES[kind], zorder=4,
            )  # fmt: skip
