"""`stiffness_laws`, `stress_intensity`, `crack_lengths`: a specimen and the growth of its crack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.crack_curve import CrackCurve
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["crack_lengths", "stiffness_laws", "stress_intensity"]

_FINE = 400  # points of a curve


@checked
def stiffness_laws(data: xr.Dataset, *, ax: Axes | None = None, legend: bool = True) -> Axes:
    """Both laws of the open stiffness over the crack length, and the stiffness without a crack.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.fatigue.compare_stiffness_laws`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For another dataset.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> laws = ns.fatigue.compare_stiffness_laws(np.linspace(0.0, 19.0, 191))
    >>> ns.plot.stiffness_laws(laws).get_ylabel()
    'stiffness over that at 5 mm'
    """
    names = ("guinea_relative", "cubic_relative")
    _require(data, names, "compare_stiffness_laws")
    ax = new_axes() if ax is None else ax
    for name, style in zip(names, LINES, strict=False):
        ax.plot(data["crack"], data[name], label=data[name].attrs["long_name"], **style)
    closed = float(data.attrs["closed_relative"])
    ax.axhline(closed, **LINES[3] | {"linewidth": 0.8}, label="crack shut, Eq. (47)")
    at = float(data.attrs["reference"])
    ax.plot([at], [1.0], "ko", markersize=3.0)
    ax.set_ylim(bottom=0.0)
    finish_axes(ax, axis_label(data["crack"]), f"stiffness over that at {at:g} mm")
    if legend:
        place_legend(ax)
    return ax


@checked
def stress_intensity(
    data: xr.Dataset,
    variable: str = "stress_intensity",
    *,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Stress intensity by several formulas over the crack ratio, or their differences.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.fatigue.compare_stress_intensity`.
    variable : {"stress_intensity", "difference"}, optional
        What to draw.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; that of the stress intensity is logarithmic.

    Raises
    ------
    OptionError
        For another dataset or variable.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> found = ns.fatigue.compare_stress_intensity(np.linspace(0.2, 19.0, 95))
    >>> ax = ns.plot.stress_intensity(found)
    >>> ax.get_xlabel(), [line.get_label() for line in ax.lines]
    ('crack ratio a/W', ['irwin', 'guinea', 'tada'])
    """
    _require(data, ("stress_intensity", "difference"), "compare_stress_intensity")
    if variable not in ("stress_intensity", "difference"):
        raise OptionError(f"variable = {quote(variable)}: give 'stress_intensity' or 'difference'")
    ax = new_axes() if ax is None else ax
    for k, name in enumerate(data["formula"].values):
        values = data[variable].sel(formula=name)
        ax.plot(data["ratio"], values, label=str(name), **LINES[k % len(LINES)])
    label = axis_label(data[variable])
    if variable == "stress_intensity":
        ax.set_yscale("log")
        label = f"{label.replace('sqrt(m)', '√m')}, {data.attrs['load']:g} N"
    finish_axes(ax, axis_label(data["ratio"]), label)
    if legend:
        place_legend(ax)
    return ax


@checked
def crack_lengths(
    curve: CrackCurve,
    times: npt.ArrayLike,
    lengths: npt.ArrayLike | None = None,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    units: str = "s",
    legend: bool = True,
) -> Axes:
    """Crack length over time by a curve, with the measured lengths where they are given.

    Several calls on the same axes show several tests.

    Parameters
    ----------
    curve : CrackCurve
        The curve.
    times : array_like
        Times of the measured lengths; of a curve alone its first and last time are enough.
    lengths : array_like, optional
        Measured crack lengths in mm at these times.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    label : str, optional
        Text of the legend.
    units : str, optional
        Units of the time; an empty text for a dimensionless one.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; circles are measured.

    Raises
    ------
    OptionError
        For numbers of lengths and times that differ.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> curve = ns.fatigue.CrackCurve(5.0, 1e-3, 426925.0, 54734.0)
    >>> ns.plot.crack_lengths(curve, [0.0, 950e3], units="").get_xlabel()
    'time'
    """
    t = np.atleast_1d(np.asarray(times, dtype=float))
    if t.ndim != 1 or t.size < 2 or not np.all(np.isfinite(t)):
        raise OptionError("times= takes a list of finite numbers, two at least")
    ax = new_axes() if ax is None else ax
    count = sum(line.get_linestyle() != "None" for line in ax.lines)
    style = LINES[count % len(LINES)]
    if lengths is not None:
        a = np.asarray(lengths, dtype=float)
        if a.shape != t.shape:
            raise OptionError(
                f"lengths have the shape {a.shape} and times {t.shape}; give one length per time"
            )
        ax.plot(
            t, a, "o", color=style["color"], markersize=2.5, markerfacecolor="white",
            markeredgewidth=0.6,
        )  # fmt: skip
    fine = np.linspace(t.min(), t.max(), _FINE)
    ax.plot(fine, curve.length(fine), label=label, **style)
    finish_axes(ax, f"time [{units}]" if units else "time", "crack length [mm]")
    if legend:
        place_legend(ax)
    return ax


def _require(data: xr.Dataset, names: tuple[str, ...], maker: str) -> None:
    if any(name not in data for name in names):
        raise OptionError(f"the dataset has no {names[0]!r}; give it a result of fatigue.{maker}")
