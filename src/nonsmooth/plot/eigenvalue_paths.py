"""`root_locus`: eigenvalues in the complex plane while a value of the structure changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import axis_label, colour_bar, finish_axes, growing_colours

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["root_locus"]

Complex = npt.NDArray[np.complex128]
Floats = npt.NDArray[np.float64]

_ROOM = 0.06  # of a range, on each side
_UNSTABLE = "0.93"  # grey


@checked
def root_locus(
    data: xr.Dataset,
    *,
    units: Literal["rad/s", "Hz"] = "rad/s",
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Paths of the eigenvalues, in the colour of the value; where motions grow is grey.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.structures.root_locus`, or of `nonsmooth.structures.campbell`.
    units : {"rad/s", "Hz"}, optional
        Unit of the frequency, which is the imaginary part.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. A circle is where a path begins, a square where it ends. Overdamped motions are
        on the real axis, which paths of both eigenvalues reach at one place.

    Raises
    ------
    OptionError
        For another dataset.

    See Also
    --------
    campbell : frequencies over the speed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> def damped(c):
    ...     return ns.Structure([[1.0]], [[1.0]], damping=[[c]])
    >>> found = ns.structures.root_locus(damped, [0.0, 0.5, 1.0], name="damping")
    >>> ax = ns.plot.root_locus(found)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('growth rate [1/s]', 'frequency [rad/s]')
    """
    over = next((name for name in ("value", "speed") if name in data.dims), None)
    if "eigenvalue" not in data or over is None or "mode" not in data["eigenvalue"].dims:
        raise OptionError("data: give a result of structures.root_locus or structures.campbell")
    from matplotlib.collections import LineCollection

    ax = new_axes() if ax is None else ax
    values = data["eigenvalue"].transpose(over, "mode").values
    up = 1.0 if units == "rad/s" else 0.5 / np.pi
    rates, heights = values.real, values.imag * up
    axis = data[over].values.astype(float)
    colours = growing_colours()
    paths = _joined(values)
    points = np.stack([paths.real, paths.imag * up], axis=-1)  # value, mode, real and imaginary
    segments = np.concatenate([points[:-1, None], points[1:, None]], axis=1)
    # value, (begin, end), mode, xy: a line for each step of each mode
    lines = segments.transpose(0, 2, 1, 3).reshape(-1, 2, 2)
    middle = np.repeat((axis[:-1] + axis[1:]) / 2.0, values.shape[1])
    there = np.isfinite(lines).all(axis=(1, 2))
    drawn = LineCollection(
        list(lines[there]), cmap=colours, array=middle[there], linewidths=1.3, zorder=2
    )
    drawn.set_clim(float(axis.min()), float(axis.max()))
    ax.add_collection(drawn)
    for row, marker, name in ((0, "o", "begin"), (-1, "s", "end")):
        ax.plot(
            rates[row], heights[row], linestyle="none", marker=marker, markersize=3.2, zorder=3,
            markeredgecolor="black", markeredgewidth=0.6, markerfacecolor=colours(row * -1.0),
            label=f"{name}, {axis[row]:g}",
        )  # fmt: skip
    _set_limits(ax, rates, heights)
    colour_bar(ax, drawn, axis_label(data[over]))
    finish_axes(ax, "growth rate [1/s]", f"frequency [{units}]")
    if legend:
        place_legend(ax)
    return ax


def _joined(values: Complex) -> Complex:
    """Paths that begin or end where a pair of eigenvalues and two real ones become each other.

    There each is drawn up to the pair.
    """
    found = values.copy()
    for each, source in ((found, values), (found[::-1], values[::-1])):  # beginnings, then ends
        missing = np.isnan(source)
        for row, mode in np.argwhere(missing[:-1] & ~missing[1:]):
            pairs = (source[row].imag > 0.0) & (source[row + 1].imag == 0.0)
            if pairs.any() and source[row + 1, mode].imag == 0.0:
                apart = np.where(pairs, np.abs(source[row] - source[row + 1, mode]), np.inf)
                each[row, mode] = source[row, np.argmin(apart)]
    return found


def _set_limits(ax: Axes, rates: Floats, heights: Floats) -> None:
    """All paths and the border of stability."""
    low, high = (float(each(rates, initial=0.0)) for each in (np.nanmin, np.nanmax))
    room = _ROOM * (high - low) or 1.0
    top = float(np.nanmax(heights, initial=0.0)) or 1.0
    ax.set(xlim=(low - room, high + room), ylim=(-_ROOM * top, (1.0 + _ROOM) * top))
    ax.axvspan(0.0, high + room, color=_UNSTABLE, linewidth=0.0, zorder=0)
    ax.axvline(0.0, color="0.4", linewidth=0.6, zorder=1)
