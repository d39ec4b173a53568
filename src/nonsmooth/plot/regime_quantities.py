"""A quantity of a regime map, such as its exponent or the progression, in colours."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.style import axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["draw_quantity", "edges"]

_WIDEST = 34  # letters in a line of the label
_DENSE = 10_000  # cells; more become an image within a PDF

Floats = npt.NDArray[np.float64]


def draw_quantity(grid: xr.Dataset, quantity: str, ax: Axes, legend: bool) -> Axes:
    """Draw a variable of a regime map; infinite values and nan are left white."""
    known = [
        name
        for name, each in grid.data_vars.items()
        if each.dims == grid["regime"].dims and each.dtype.kind in "fiu"
    ]
    if quantity not in known:
        raise OptionError(f"quantity: {unknown_name('quantity', str(quantity), map(str, known))}")
    second, first = grid["regime"].dims
    x, y = edges(grid[first].values), edges(grid[second].values)
    values = np.ma.masked_invalid(grid[quantity].values.astype(float))
    if values.count() == 0:
        raise OptionError(f"quantity = {quantity!r} has no finite value in this map")
    mesh = ax.pcolormesh(
        x, y, values, cmap="cividis", rasterized=values.size > _DENSE, linewidth=0.0
    )
    finish_axes(ax, axis_label(grid[first]), axis_label(grid[second]))
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    if legend:
        figure = ax.get_figure(root=True)
        assert figure is not None
        bar = figure.colorbar(mesh, ax=ax)
        size = float(ax.xaxis.label.get_fontsize())
        bar.set_label(fill(axis_label(grid[quantity]), _WIDEST), fontsize=size)
        bar.ax.tick_params(labelsize=float(ax.get_xticklabels()[0].get_fontsize()))
    return ax


def edges(values: Floats) -> Floats:
    """Borders of the cells around values; of a width of one around a single value."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])
