"""`event_markers`: where on a curve the events of a run are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.plot.trace import DENSE, check_log, check_range, check_variables

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["EVENT_MARK", "EVENT_SHAPES", "event_markers"]

EVENT_SHAPES = "osv^D<>p"
EVENT_MARK: dict[str, Any] = {
    "linestyle": "none",
    "markersize": 3.5,
    "markerfacecolor": "white",
    "markeredgecolor": "black",
    "markeredgewidth": 0.7,
    "zorder": 3,
    "gid": "event",
}


@checked
def event_markers(
    run: xr.Dataset, variable: str, ax: Axes, *, time_range: tuple[float, float] | None = None
) -> Axes:
    """Mark the events of a run on the curve of one variable over time.

    Each name of an event has its own shape, the same in every picture of one system's run
    that has the same events. The start is not marked; tangencies are, as ``(graze)``.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.
    variable : str
        State or output that the axes show. States are marked at their value just before the
        event, outputs on the line between their samples.
    ax : matplotlib.axes.Axes
        Where to draw.
    time_range : tuple of float, optional
        First and last time to mark; the whole run by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one set of markers per name of an event, labelled by it.

    Raises
    ------
    OptionError
        For an unknown variable, a range that does not meet the run, or a run without its
        event log.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=3)
    >>> ax = ns.plot.time_history(run, "p")
    >>> ax = ns.plot.event_markers(run, "p", ax)
    >>> ax.get_legend_handles_labels()[1]
    ['p', 'contact', 'impact', 'progression', 'release']
    """
    (name,) = check_variables(run, variable)
    check_log(run)
    low, high = check_range(run, time_range) or (-np.inf, np.inf)
    times = run["event_time"].values
    values = _values_at_events(run, name)
    kinds = run["event_kind"].values.astype(str)
    labels = run["event_name"].values.astype(str)
    labels = np.where(kinds == "graze", np.char.add(labels, " (graze)"), labels)
    crossing = kinds != "start"
    # a mode or a variable may have the same name
    known = {line.get_label() for line in ax.lines if line.get_gid() == EVENT_MARK["gid"]}
    # all names of the run, so that a range does not change the shapes
    for i, label in enumerate(np.unique(labels[crossing])):
        here = crossing & (labels == label) & (times >= low) & (times <= high)
        if not np.any(here):
            continue
        ax.plot(
            times[here],
            values[here],
            marker=EVENT_SHAPES[i % len(EVENT_SHAPES)],
            **EVENT_MARK,
            rasterized=bool(np.count_nonzero(here) > DENSE),
            # one entry in the legend, also when several curves of the axes are marked
            label="_" + label if label in known else label,
        )
    return ax


def _values_at_events(run: xr.Dataset, name: str) -> np.ndarray:
    states = [str(state) for state in run["state"].values]
    if name in states:
        return run["state_before"].values[:, states.index(name)]
    return np.interp(run["event_time"].values, run["time"].values, run[name].values)
