"""Estimates of chaos: Lyapunov exponents over time, and the paths of the 0-1 test."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["exponents", "translation"]

_ROUNDING = 1e-12  # part of the largest exponent
_ERRORS = 2.0  # standard errors on either side of the final value


@checked
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


@checked
def translation(test: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Translation p, q of the 0-1 test: bounded for regular motion, wandering for chaotic motion.

    Parameters
    ----------
    test : xarray.Dataset
        Result of `zero_one_test`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with K as their title.

    Raises
    ------
    OptionError
        For another dataset.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.duffing(), periods=400, samples_per_period=1)
    >>> ax = ns.plot.translation(ns.zero_one_test(run, "x", transient=50))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('p', 'q')
    """
    if "p" not in test or "q" not in test or "K" not in test:
        raise OptionError("the dataset has no translation; give a result of zero_one_test")
    ax = new_axes() if ax is None else ax
    style = LINES[0] | {"linewidth": 0.4}
    ax.plot(test["p"].values, test["q"].values, **style)
    ax.set_aspect("equal", adjustable="datalim")
    size = ax.xaxis.label.get_fontsize()
    low, high = float(test["K_low"]), float(test["K_high"])
    ax.set_title(f"K = {float(test['K']):.3f} ({low:.3f} to {high:.3f})", fontsize=size)
    names = (axis_label(test[name].assign_attrs(long_name=name)) for name in ("p", "q"))
    finish_axes(ax, *names)
    return ax
