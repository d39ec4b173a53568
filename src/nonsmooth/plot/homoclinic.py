"""Points in which manifolds cross, on top of the curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend, with_former
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes, two_states
from nonsmooth.plot.turns import Turns

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["homoclinic_points"]

_MARK = 4.2  # points
_LOOKS = (("o", PALETTE["blue"]), ("s", PALETTE["sky"]))  # of the two senses


@checked
def homoclinic_points(
    data: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    within_turn: bool = False,
    legend: bool = True,
) -> Axes:
    """Points in which an unstable manifold crosses a stable one.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `homoclinic_points`.
    x, y : str, optional
        States to draw; the first two by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw, such as the axes of `nonsmooth.plot.manifold` with both curves; new axes of a
        column's width by default.
    within_turn : bool, optional
        Whether to draw angles within one turn, as in `nonsmooth.plot.manifold`.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. Circles and squares are crossings in either sense: where a bump comes off, one of
        each vanish together.

    Raises
    ------
    OptionError
        For another dataset, or an unknown state.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> data = xr.Dataset(
    ...     {
    ...         "x": ("crossing", [0.0, 1.0]),
    ...         "v": ("crossing", [1.0, 0.0]),
    ...         "crossing_angle": ("crossing", [0.3, 0.2]),
    ...         "sense": ("crossing", [1.0, -1.0]),
    ...     }
    ... )
    >>> ax = ns.plot.homoclinic_points(data)
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['crossings in one sense', 'in the other']
    """
    if "crossing_angle" not in data or "sense" not in data:
        raise OptionError("the dataset holds no crossings; give a result of homoclinic_points")
    skipped = {
        "crossing_angle", "sense", "orbit_number", "place", "images", "ahead", "position_error",
        "unstable_side", "stable_side", "orbit_point", "to_point",
    }  # fmt: skip
    skipped |= {f"{name}_turns" for name in data.data_vars}
    known = [str(name) for name in data.data_vars if str(name) not in skipped]
    across, up = two_states(known, x, y)
    own = ax is None
    ax = new_axes() if ax is None else ax
    turns = Turns.of(data, (across, up), None if own else ax) if within_turn else Turns.none()
    columns = turns.folded(data[across].values, data[up].values)
    senses = data["sense"].values
    names = ("crossings in one sense", "in the other")
    for sign, name, (marker, colour) in zip((1.0, -1.0), names, _LOOKS, strict=True):
        rows = np.flatnonzero(senses == sign)
        if rows.size:
            ax.plot(
                columns[0][rows], columns[1][rows], linestyle="none", marker=marker,
                markersize=_MARK, markerfacecolor=colour, markeredgecolor="black",
                markeredgewidth=0.6, label=name, zorder=6,
            )  # fmt: skip
    finish_axes(ax, axis_label(data[across]), axis_label(data[up]))
    if own:
        turns.show(ax)
    if legend:
        place_legend(ax, with_former(ax))
    return ax
