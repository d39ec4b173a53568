"""A channel of a record over time, with its flaws shaded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.histories import draw_lines
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes
from nonsmooth.plot.trace import check_range, check_variables

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["quality"]

# told apart in grey as well, by what is drawn: stretches are shaded, samples have marks
_SHADED = {"missing": "yellow", "frozen": "sky", "gap": "purple", "marks": "green"}
_MARKED: dict[str, dict[str, Any]] = {
    "clipped": {"marker": "_", "color": PALETTE["vermilion"], "s": 14.0, "linewidth": 1.5},
    "spike": {
        "marker": "o", "facecolor": "none", "edgecolor": PALETTE["blue"], "s": 36.0,
        "linewidth": 1.2,
    },
}  # fmt: skip
_PALE = 0.55  # opacity of what is shaded
_LEAST = 0.004  # of the width of the picture, so that a short stretch is seen


@checked
def quality(
    record: xr.Dataset,
    found: xr.Dataset,
    channel: str,
    *,
    ax: Axes | None = None,
    time_range: tuple[float, float] | None = None,
    legend: bool = True,
) -> Axes:
    """One channel of a record over time with the flaws that were found in it.

    Stretches that are frozen or missing are shaded, and so are gaps and missing marks; samples
    that are clipped have a bar and spikes a ring. What concerns the whole channel, such as a
    drift, stands in the legend. Of the flaws of single times the legend names those that are in the
    picture.

    Parameters
    ----------
    record : xarray.Dataset
        The record.
    found : xarray.Dataset
        Result of `measured.check` for it.
    channel : str
        What to draw.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    time_range : tuple of float, optional
        First and last time to draw; the whole record by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For an unknown channel, a check of another record, or a range that does not meet it.

    See Also
    --------
    time_history : several variables, without flaws.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4000) / 2000.0
    >>> x = np.round(np.cos(100 * t) + np.random.default_rng(0).normal(0, 0.01, t.size), 3)
    >>> x[1000:1400] = x[1000]
    >>> record = ns.measured.from_arrays({"x": x}, times=t)
    >>> ax = ns.plot.quality(record, ns.measured.check(record), "x")
    >>> ax.get_legend_handles_labels()[1]
    ['frozen']
    """
    check_variables(record, channel)
    if "finding" not in found.dims or f"{channel}_quality" not in found:
        raise OptionError(
            f"found: it says nothing of {channel}; give the result of measured.check for the record"
        )
    time_range = check_range(record, time_range)
    ax = new_axes() if ax is None else ax
    draw_lines(record, [channel], ax, time_range, {})
    (line,) = ax.lines
    line.set(linewidth=0.6, label="_")
    low, high = ax.get_xlim()
    kinds = found["kind"].values
    here = np.isin(found["channel"].values, (channel, "time", "mark"))
    for kind in dict.fromkeys(kinds[here]):
        rows = np.flatnonzero(here & (kinds == kind))
        if kind in _SHADED:
            _shade(ax, found, rows, str(kind), (low, high))
        elif kind in _MARKED:
            _mark(ax, record, found, channel, str(kind), (low, high))
        else:
            ax.plot([], [], " ", label=f"{kind} ({float(found['size'][rows[0]]):.3g})")
    ax.set_xlim(low, high)
    finish_axes(ax, axis_label(record["time"]), axis_label(record[channel]))
    if legend and ax.get_legend_handles_labels()[1]:
        place_legend(ax)
    return ax


def _shade(ax: Axes, found: xr.Dataset, rows: Any, kind: str, shown: tuple[float, float]) -> None:
    """One broad bar for each stretch that is in the picture, behind the curve."""
    low, high = shown
    least = _LEAST * (high - low)
    ends = [(float(found["begin"][k]), float(found["end"][k])) for k in rows]
    bars = [(a, max(b - a, least)) for a, b in ends if a <= high and b >= low]
    if not bars:
        return
    colour = PALETTE[_SHADED[kind]]
    ax.broken_barh(
        bars, (0.0, 1.0), transform=ax.get_xaxis_transform(), color=colour, alpha=_PALE,
        linewidth=0.0, label=kind, zorder=0,
    )  # fmt: skip


def _mark(
    ax: Axes,
    record: xr.Dataset,
    found: xr.Dataset,
    channel: str,
    kind: str,
    shown: tuple[float, float],
) -> None:
    """Marks on the samples in the picture that have the flag of a kind."""
    flags = found[f"{channel}_quality"]
    bits = dict(zip(flags.attrs["flag_meanings"].split(), flags.attrs["flag_masks"], strict=True))
    time = record["time"].values
    chosen = ((flags.values & bits[kind]) > 0) & (time >= shown[0]) & (time <= shown[1])
    if not chosen.any():
        return
    ax.scatter(time[chosen], record[channel].values[chosen], label=kind, zorder=3, **_MARKED[kind])
