"""`smoothing`: what smoothing does, over the width of the smooth switches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["smoothing"]

_QUANTITIES = ("error", "stick_time_error", "creep", "special_shift", "extra_width")
_MARKERS = ("o", "s", "^", "D")


@checked
def smoothing(
    data: xr.Dataset, quantity: str = "error", *, ax: Axes | None = None, legend: bool = True
) -> Axes:
    """Draw a quantity of a report on smoothing over the width, with the power that fits it.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `smoothing_report`.
    quantity : {"error", "stick_time_error", "creep", "special_shift", "extra_width"}, optional
        What to draw; of differences the size.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to write the exponents into a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, logarithmic in both directions, with a line for each state, surface or special
        point.

    Raises
    ------
    OptionError
        For another dataset, or a quantity that the report does not have.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> slope = ns.System(states=["v"], equations={"v": "0.3 - sign(v)"})
    >>> report = ns.smoothing_report(slope, (0.1, 0.03, 0.01), initial={"v": 0.5}, t_end=3)
    >>> ax = ns.plot.smoothing(report, "creep")
    >>> ax.get_xscale(), ax.get_xlabel()
    ('log', 'width of the smooth switches')
    """
    there = [name for name in _QUANTITIES if f"{name}_exponent" in data and "epsilon" in data.dims]
    if not there:
        raise OptionError(
            "the dataset is no report on smoothing; give a result of smoothing_report"
        )
    if quantity not in there:
        raise OptionError(
            f"quantity = {quote(quantity)} is not in the report; it has {', '.join(there)}"
        )
    values = abs(data[quantity])
    over = next((str(name) for name in values.dims if name != "epsilon"), None)
    ax = new_axes() if ax is None else ax
    ax.set(xscale="log", yscale="log")
    drawn = 0
    for k in range(1 if over is None else data.sizes[over]):
        column = values if over is None else values.isel({over: k})
        exponent = float(np.atleast_1d(data[f"{quantity}_exponent"].values)[k])
        drawn += _draw(ax, column, exponent, _name(data, over, k), k)
    finish_axes(ax, axis_label(data["epsilon"]), axis_label(data[quantity]))
    if legend and drawn:
        place_legend(ax)
    return ax


def _name(data: xr.Dataset, over: str | None, k: int) -> str:
    """What a line is of: a state, a surface, a special point by its kind and place."""
    if over is None:
        return ""
    if over != "special":
        return f"{data[over].values[k]}: "
    return f"{data['special_kind'].values[k]} at {float(data['special_value_exact'][k]):.4g}: "


def _draw(ax: Axes, column: xr.DataArray, exponent: float, name: str, k: int) -> bool:
    """Points of one line and the power law through them; whether there were any."""
    widths, heights = column["epsilon"].values, column.values
    used = np.isfinite(heights) & (heights > 0.0)  # zero has no logarithm
    if not used.any():
        return False
    line: dict[str, Any] = dict(LINES[k % len(LINES)])
    # lines may lie on each other, so later points go around the earlier ones
    points: dict[str, Any] = {
        "linestyle": "none",
        "marker": _MARKERS[k % len(_MARKERS)],
        "markersize": 3.5 + 1.5 * (k % len(_MARKERS)),
        "markerfacecolor": line["color"] if k == 0 else "none",
        "color": line["color"],
        "zorder": 3,
    }
    if not np.isfinite(exponent):
        points["label"] = name.removesuffix(": ")
    ax.plot(widths[used], heights[used], **points)
    if not np.isfinite(exponent):
        return True
    x, y = np.log(widths[used]), np.log(heights[used])
    fit = np.exp(y.mean() + exponent * (x - x.mean()))
    ax.plot(widths[used], fit, **line, label=f"{name}exponent {exponent:.2f}", zorder=2)
    return True
