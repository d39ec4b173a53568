"""`exponents`: how the estimates of Lyapunov exponents settle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["exponents"]

_ROUNDING = 1e-12  # part of the largest exponent
_ERRORS = 2.0  # standard errors on either side of the final value


def exponents(spectrum: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Lyapunov exponents averaged up to each time, with a band of two standard errors.

    Parameters
    ----------
    spectrum : xarray.Dataset
        Result of `lyapunov_spectrum`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line per exponent that is a number. Those that are minus infinity are
        named in the legend.

    Raises
    ------
    OptionError
        For another dataset, or one without a record.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> spectrum = ns.lyapunov_spectrum(ns.models.moling(), transient=60, record=50)
    >>> [line.get_label().split()[0] for line in ns.plot.exponents(spectrum).lines[:4]]
    ['0', '-0.0388', '-1.31', '-∞']
    """
    if "running_exponent" not in spectrum or spectrum.sizes.get("time", 0) == 0:
        raise OptionError(
            "the dataset has no exponents over time; give a result of lyapunov_spectrum"
        )
    ax = new_axes() if ax is None else ax
    times = spectrum["time"].values
    for i in range(spectrum.sizes["exponent"]):
        value = _without_rounding(spectrum, i)
        error = float(spectrum["standard_error"][i])
        style = LINES[i % len(LINES)]
        if not np.isfinite(value):
            ax.plot([], [], label="-∞", **style)
            continue
        label = f"{value:.3g} ± {error:.2g}" if np.isfinite(error) else f"{value:.3g}"
        ax.plot(times, spectrum["running_exponent"][:, i].values, label=label, **style)
        if np.isfinite(error):
            half = _ERRORS * error
            ax.axhspan(value - half, value + half, color=style["color"], alpha=0.15, linewidth=0)
    ax.axhline(0.0, color="0.6", linewidth=0.5, zorder=0)
    if times.size > 1:
        ax.set_xlim(times[0], times[-1])
    finish_axes(ax, axis_label(spectrum["time"]), axis_label(spectrum["lyapunov_exponent"]))
    place_legend(ax)
    return ax


def _without_rounding(spectrum: xr.Dataset, i: int) -> float:
    """Exponent i, zero where it is no more than the rounding of the others."""
    values = spectrum["lyapunov_exponent"].values
    largest = np.abs(values[np.isfinite(values)]).max(initial=0.0)
    value = float(values[i])
    return 0.0 if abs(value) <= _ROUNDING * largest else value
