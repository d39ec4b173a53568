"""`fit`: a measured channel beside what was fitted to it, and the difference below."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.arguments import checked
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["fit"]

_HEIGHTS = (5, 2)  # of the record and of the residuals
_BAND = 1.96  # standard deviations that hold 95 % of a normal variable


@checked
def fit(
    data: xr.Dataset,
    channel: str | None = None,
    *,
    ax: Axes | None = None,
    time_range: tuple[float, float] | None = None,
) -> Axes:
    """Measured samples with the fitted motion, and the residuals in a panel below.

    The grey band of the panel holds 95 % of the residuals where the noise is normal. What was
    held back and predicted has a coloured ground.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `fit`.
    channel : str, optional
        Channel of the record; the first one by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw, axes of a grid; new axes of a column's width by default. The panel of the
        residuals takes a part of their place and is the last of the ``axes`` of the figure.
    time_range : tuple of float, optional
        First and last time to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the measured samples.

    Raises
    ------
    OptionError
        For another dataset, or a channel that was not fitted.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 10, 200)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    >>> record = ns.measured.from_arrays({"x": np.exp(-0.5 * t) + noise}, times=t)
    >>> decay = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    >>> ax = ns.plot.fit(ns.fit(decay, record, {"k": (0.1, 2)}))
    >>> [each.get_ylabel() for each in ax.figure.axes]
    ['x', 'residual']
    """
    if not {"measured", "fitted", "residual", "noise"} <= set(data.variables):
        raise OptionError("data: draw a result of fit")
    channels = [str(name) for name in data["channel"].values]
    name = channels[0] if channel is None else channel
    if name not in channels:
        raise OptionError(f"channel: {unknown_name('channel', str(name), channels)}")
    ax = new_axes() if ax is None else ax
    shown = data.sel(channel=name)
    if time_range is not None:
        first, last = time_range
        shown = shown.isel(time=(shown["time"].values >= first) & (shown["time"].values <= last))
        if not shown.sizes["time"]:
            raise OptionError(f"time_range = ({first:g}, {last:g}) has no samples of the record")
    time = shown["time"].values
    ax.plot(
        time, shown["measured"].values, ".", markersize=2.5, markeredgewidth=0.0, color="0.55",
        label="measured",
    )  # fmt: skip
    good = np.isfinite(shown["fitted"].values)
    ax.plot(time[good], shown["fitted"].values[good], **LINES[0], label="fitted")
    panel = _panel_below(ax)
    size = float(ax.xaxis.label.get_fontsize())
    level = _BAND * float(shown["noise"])
    panel.axhspan(-level, level, color="0.88", linewidth=0.0, zorder=0)
    panel.plot(time, shown["residual"].values, ".", markersize=1.5, color="black")
    held = shown["held_back"].values
    if held.any():
        for each in (ax, panel):
            each.axvspan(
                time[held][0], time[-1], color=PALETTE["sky"], alpha=0.25, linewidth=0.0, zorder=0
            )
    ax.tick_params(labelbottom=False)
    ax.set_xlim(time[0], time[-1])
    panel.set_xlabel(axis_label(data["time"]), fontsize=size)
    panel.set_ylabel("residual", fontsize=size)
    finish_axes(ax, " ", name)
    place_legend(ax)
    return ax


def _panel_below(ax: Axes) -> Axes:
    """New axes in the lower part of the place of others, with the same range in x."""
    place, figure = ax.get_subplotspec(), ax.get_figure(root=True)
    if place is None or figure is None:
        raise OptionError(
            "ax: give axes of a grid, as plot.print_figure and plt.subplots make them"
        )
    parts = place.subgridspec(2, 1, height_ratios=_HEIGHTS)
    ax.set_subplotspec(parts[0])
    panel = figure.add_subplot(parts[1], sharex=ax)
    size = float(ax.xaxis.label.get_fontsize()) - 1.0
    panel.tick_params(labelsize=size, width=0.6, length=2.5)
    for side in panel.spines.values():
        side.set_linewidth(0.6)
    return panel
