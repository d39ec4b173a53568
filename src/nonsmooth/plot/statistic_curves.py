"""`statistics`: numbers that sum motions up, over a parameter, a speed or time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["statistics"]

_CURVES = (
    ("max", "largest"), ("in_contact", "mean in contact"), ("rms", "rms"), ("mean", "mean")
)  # fmt: skip
_PALE = 0.25  # opacity of bands


@checked
def statistics(
    data: xr.Dataset,
    variable: str,
    *,
    ax: Axes | None = None,
    over: str | None = None,
    label: str | None = None,
    legend: bool = True,
) -> Axes:
    """Statistics over a parameter, or along a run: one curve, or those of one variable together.

    Two calls on the same axes show a run-up and a run-down together.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `contact_statistics` over a parameter, or of `period_statistics`; also one
        harmonic of a `waterfall`, as in ``spectra.sel(harmonic=1)``.
    variable : str
        What is in the dataset, such as ``"contacts"``, ``"force_max"`` or ``"x_amplitude"``, for
        one curve. A variable of which there are statistics, such as ``"force"``, for all of them:
        the largest value, the mean in contact, the root mean square and the mean over all time,
        and the band between the lowest and the highest percentile, or between the smallest and
        the largest value.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    over : str, optional
        What is along the axis: ``"parameter"``; of a run a slow parameter, ``"begin"``, the time,
        or ``"period"``; of a measured motion also ``"speed"``. By default the parameter, the only
        slow parameter, or the time.
    label : str, optional
        Text of the legend; along a slow parameter whether it rises or falls by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For an unknown name, or another dataset.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> found = ns.contact_statistics(
    ...     ns.models.soft_impact(), "omega", np.linspace(0.8, 0.9, 11), of="stop_force", record=20
    ... )
    >>> ax = ns.plot.statistics(found, "stop_force")
    >>> [line.get_label() for line in ax.lines]
    ['largest', 'mean in contact', 'rms', 'mean']
    """
    dim = next((name for name in ("parameter", "period") if name in data.dims), None)
    if dim is None:
        raise OptionError(
            "the dataset has neither 'parameter' nor 'period' as a dimension; give it a result of"
            " contact_statistics over a parameter, or of period_statistics"
        )
    of = [str(name)[:-4] for name in data.data_vars if str(name).endswith("_max")]
    known = [str(name) for name, v in data.data_vars.items() if v.dims == (dim,)]
    if variable not in [*known, *of]:
        raise OptionError(unknown_name("variable", variable, [*known, *of]))
    over = _axis(data, dim, over)
    ax = new_axes() if ax is None else ax
    x = data[over].values
    if label is None and over in data.data_vars and x.size > 1:
        # a symbol stands for what has no unit
        what = data[over].attrs.get("long_name", over) if data[over].attrs.get("units") else over
        label = f"{what} {'rises' if x[-1] > x[0] else 'falls'}"
    if variable in known:
        style = LINES[len(ax.lines) % len(LINES)]
        text = _apart(ax, label, data[variable].attrs.get("long_name", variable))
        _draw(ax, x, data[variable].values, text, style)
        y_label = axis_label(data[variable])
    else:
        y_label = _draw_all(data, variable, ax, x, label)
    finish_axes(ax, axis_label(data[over]), y_label)
    if legend:
        place_legend(ax)
    return ax


def _draw(ax: Axes, x: np.ndarray, values: np.ndarray, label: str | None, style: Any) -> None:
    """One curve, with dots where a value has no neighbours and a line would not be seen."""
    line = ax.plot(x, values, label=label, **style | {"linewidth": 0.9})[0]
    there = np.isfinite(values)
    alone = there & ~np.append(False, there[:-1]) & ~np.append(there[1:], False)
    if alone.any():
        line.set_marker(".")
        line.set_markersize(3.0)
        line.set_markevery(np.flatnonzero(alone).tolist())


def _apart(ax: Axes, text: str | None, name: str) -> str | None:
    """Text of an entry of the legend, with the name of what it shows where it is there already."""
    known = text is not None and text in ax.get_legend_handles_labels()[1]
    return f"{name}, {text}" if known else text


def _axis(data: xr.Dataset, dim: str, over: str | None) -> str:
    """Name of what is along the axis."""
    if dim == "parameter":
        allowed = ["parameter"]
    else:
        slow = str(data.attrs.get("slow", "")).split()
        allowed = [*(slow if len(slow) == 1 else []), "begin", "period"]
        allowed += [name for name in slow if name not in allowed]
        allowed += ["speed"] if "speed" in data and "speed" not in allowed else []
    over = allowed[0] if over is None else over
    if over not in allowed:
        raise OptionError(f"over: {unknown_name('axis', over, allowed)}")
    return over


def _draw_all(data: xr.Dataset, variable: str, ax: Axes, x: np.ndarray, label: str | None) -> str:
    """Curves and the band of one variable; the label of the axis.

    What is drawn after others has its curves in the colour of its band.
    """
    colours = list(PALETTE.values())
    number = len(ax.collections)
    colour = colours[number % len(colours)]
    attrs = data[f"{variable}_max"].attrs
    name = str(attrs.get("long_name", variable)).removeprefix("largest ")
    low, high, what = f"{variable}_min", f"{variable}_max", "smallest to largest"
    band = [data[low].values, data[high].values]
    if f"{variable}_percentile" in data and data.sizes.get("percentile", 0) > 1:
        parts = data["percentile"].values
        first, last = int(np.argmin(parts)), int(np.argmax(parts))
        values = data[f"{variable}_percentile"].transpose(..., "percentile").values
        band = [values[:, first], values[:, last]]
        what = f"{parts[first]:g} to {parts[last]:g} %"
    whose = name if label is None or _apart(ax, label, name) != label else label
    ax.fill_between(
        x, band[0], band[1], color=colour, alpha=_PALE if f"{variable}_mean" in data else 0.5,
        linewidth=0.0, label=_apart(ax, label or what, name),
    )  # fmt: skip
    if f"{variable}_mean" in data:
        for (key, text), style in zip(_CURVES, LINES, strict=True):
            own = style | {"color": colour} if number else style
            told = _apart(ax, text, whose)
            _draw(ax, x, data[f"{variable}_{key}"].values, told, own)
    return axis_label(data[high].assign_attrs(long_name=name))
