"""`phases`: variables of a run over time, with the modes behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.histories import common_label, draw_lines
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import axis_label, finish_axes, mode_colours, mode_numbers
from nonsmooth.plot.trace import DENSE, check_log, check_range, check_variables

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["mode_label", "phases"]

_PALE = 0.3  # opacity behind curves: told apart in print, and black lines stay black


def phases(
    run: xr.Dataset,
    variables: str | Sequence[str],
    *,
    time_range: tuple[float, float] | None = None,
    ax: Axes | None = None,
    labels: Mapping[str, str] | None = None,
    legend: bool = True,
) -> Axes:
    """Variables of a run over time, with the mode in force as the colour behind them.

    The colours change at the exact times of the events. Each mode has the same colour in
    every picture, see `mode_colours`.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.
    variables : str or sequence of str
        States and outputs.
    time_range : tuple of float, optional
        First and last time to draw, such as those of one period; the whole run by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    labels : mapping of str to str, optional
        Texts of the legend by name of the variable or mode; the name by default.
    legend : bool, optional
        Whether to draw a legend of lines and modes.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line per variable, one collection of rectangles per mode.

    Raises
    ------
    OptionError
        For an unknown variable, a range that does not meet the run, or a run without its
        event log.

    See Also
    --------
    time_history : the curves alone, with the events if wanted.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=20)
    >>> T = run.attrs["period"]
    >>> ax = ns.plot.phases(run, ["x", "z", "v"], time_range=(18 * T, 19 * T))
    >>> [c.get_label() for c in ax.collections]
    ['no contact', 'contact', 'progression']
    """
    names = check_variables(run, variables)
    check_log(run)
    time_range = check_range(run, time_range)
    ax = new_axes() if ax is None else ax
    labels = labels or {}
    draw_lines(run, names, ax, time_range, labels)
    _draw_modes(run, ax, ax.get_xlim(), labels)
    finish_axes(ax, axis_label(run["time"]), common_label(run, names))
    if legend:
        place_legend(ax)
    return ax


class _Spans(NamedTuple):
    """Stretches of time in one mode each."""

    begin: npt.NDArray[np.float64]
    end: npt.NDArray[np.float64]
    mode: npt.NDArray[np.int64]


def _spans(run: xr.Dataset, low: float, high: float) -> _Spans:
    """Stretches between changes of the mode, cut to a range."""
    change = run["event_from"].values != run["event_to"].values
    times = run["event_time"].values[change]
    modes = run["event_to"].values[change].astype(np.int64)
    # the mode before the first change; where there is none, the only one
    before = run["event_from"].values[change][:1] if times.size else run["mode"].values[:1]
    modes = np.concatenate([before.astype(np.int64), modes])
    begin = np.clip(np.concatenate([[-np.inf], times]), low, high)
    end = np.clip(np.concatenate([times, [np.inf]]), low, high)
    lasting = end > begin
    return _Spans(begin[lasting], end[lasting], modes[lasting])


def _draw_modes(
    run: xr.Dataset, ax: Axes, time_range: tuple[float, float], labels: Mapping[str, str]
) -> None:
    from matplotlib.collections import PolyCollection

    spans = _spans(run, *time_range)
    for name, colour in mode_colours(run).items():
        here = np.isin(spans.mode, mode_numbers(run, name))
        if not np.any(here):
            continue
        begin, end = spans.begin[here], spans.end[here]
        corners = np.zeros((begin.size, 4, 2))
        corners[:, :2, 0], corners[:, 2:, 0] = begin[:, None], end[:, None]
        corners[:, 1:3, 1] = 1.0
        rectangles = PolyCollection(
            list(corners),
            transform=ax.get_xaxis_transform(),
            facecolor=colour,
            alpha=_PALE,
            edgecolor="none",
            zorder=0,
            rasterized=begin.size > DENSE,
            label=labels.get(name, mode_label(name)),
        )
        ax.add_collection(rectangles, autolim=False)


def mode_label(name: str) -> str:
    """Name of a mode as it is read."""
    return name.replace("_", " ")
