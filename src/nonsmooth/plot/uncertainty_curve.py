"""`uncertainty`: the curve behind an uncertainty exponent or a dimension."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["uncertainty"]

# exponent, its letter in the legend, values, what they are over
_CURVES = (
    ("uncertainty_exponent", r"$\alpha$", "uncertain_fraction", "distance"),
    ("box_dimension", "$D$", "boxes", "boxes_per_side"),
    ("correlation_dimension", "$D_2$", "correlation_sum", "distance"),
)

_ENOUGH = 5  # points of a line; of fewer the legend tells
_PER_DIGIT = 0.035  # of the width of axes, with space on either side of a label
_LARGEST = 2000.0  # number of cells that is written out


@checked
def uncertainty(data: xr.Dataset, *, ax: Axes | None = None, legend: bool = True) -> Axes:
    """Fraction of uncertain starts over the distance, with the fitted power law.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `uncertainty_exponent`; the curves of `box_dimension` and
        `correlation_dimension` are drawn likewise.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to write the exponent with its standard error into a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, logarithmic in both directions. Full circles are those that the line is fitted
        to, empty ones are the others.

    Raises
    ------
    OptionError
        For another dataset.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> halves = np.ones((200, 200), int)
    >>> halves[:, 100:] = 2
    >>> ax = ns.plot.uncertainty(ns.uncertainty_exponent(halves))
    >>> ax.get_xscale(), ax.get_xlabel(), ax.get_ylabel()
    ('log', 'distance in cells', 'fraction of uncertain starts')
    """
    curve = next((names for names in _CURVES if names[0] in data and names[2] in data), None)
    if curve is None:
        raise OptionError(
            "the dataset has no curve over a distance; give a result of uncertainty_exponent,"
            " box_dimension or correlation_dimension"
        )
    name, letter, values, over = curve
    ax = new_axes() if ax is None else ax
    sizes, heights = data[over].values.astype(float), data[values].values.astype(float)
    fitted = data["fitted"].values.astype(bool)
    style: dict[str, Any] = {
        "linestyle": "none",
        "marker": "o",
        "markersize": 3.5,
        "color": "black",
    }
    fitted &= heights > 0.0  # zero has no logarithm
    rest = ~fitted & (heights > 0.0)
    ax.set(xscale="log", yscale="log")
    ax.plot(sizes[fitted], heights[fitted], **style, zorder=3)
    ax.plot(sizes[rest], heights[rest], **style, markerfacecolor="white", zorder=2)
    exponent, error = float(data[name]), float(data["standard_error"])
    if np.isfinite(exponent):
        text = f"{letter} = {exponent:.3f} ± {error:.2g}"
        count = np.count_nonzero(fitted)
        if count < _ENOUGH:
            text += f", {count} points only"
        line = LINES[1] | {"linestyle": "-"}
        ax.plot(sizes[fitted], data["fit"].values[fitted], **line, label=text, zorder=4)
    _whole_ticks(ax, sizes)
    finish_axes(ax, axis_label(data[over]), axis_label(data[values]))
    if legend:
        place_legend(ax)
    return ax


def _whole_ticks(ax: Axes, sizes: npt.NDArray[np.float64]) -> None:
    """Write whole sizes out as they are, as many as have room."""
    if np.any(sizes != np.round(sizes)) or sizes.min() < 1.0 or sizes.max() > _LARGEST:
        return
    width = max(np.log(sizes.max() / sizes.min()), np.log(2.0))
    shown: list[float] = []
    for size in np.sort(sizes):
        room = _PER_DIGIT * (len(f"{size:.0f}") + 1) * width
        if not shown or np.log(size / shown[-1]) >= room:
            shown.append(float(size))
    ax.set_xticks(shown, [f"{size:.0f}" for size in shown])
    ax.set_xticks([], minor=True)
