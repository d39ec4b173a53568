"""`attractors`: sets of points in a plane of two states."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.plot.attractor_key import attractor_entry
from nonsmooth.plot.attractor_style import (
    attractor_points,
    attractor_styles,
    check_states,
    draw_attractors,
    state_label,
)
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["attractors"]


def attractors(
    data: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Points of attractors: one state over another.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `attractors` or of `basins_of_attraction`.
    x, y : str, optional
        States to draw; by default the first two that do not drift.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend with the kind of each attractor and the fraction of the starts
        that lead to it.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one set of points per attractor, in the colours of `nonsmooth.plot.basins`.
        Circles are of period one, squares of period two; dots are motion without a period.

    Raises
    ------
    OptionError
        For an unknown state, or a dataset without attractors.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> data = xr.Dataset(
    ...     {
    ...         "points": (("attractor", "point", "state"), [[[0.0, 1.0], [1.0, 0.0]]]),
    ...         "period": ("attractor", [2]),
    ...     },
    ...     {"attractor": [1], "state": ["p", "y"]},
    ... )
    >>> ax = ns.plot.attractors(data)
    >>> ax.get_xlabel(), ax.get_ylabel(), ax.lines[0].get_label()
    ('p', 'y', '1: period 2')
    """
    across, up = check_states(data, x, y)
    numbers = [int(k) for k in data["attractor"].values]
    styles = attractor_styles(data, numbers)
    entries = [attractor_entry(style, basin=False) for style in styles.values()] if legend else []
    own = ax is None
    ax = new_axes() if ax is None else ax
    points = {number: attractor_points(data, number, across, up) for number in numbers}
    draw_attractors(ax, points, styles)
    finish_axes(ax, state_label(data, across), state_label(data, up))
    place_legend(ax, entries, may_grow=own)
    return ax
