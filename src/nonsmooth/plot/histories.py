"""`time_history`: variables of a run over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.markers import event_markers
from nonsmooth.plot.style import LINES, axis_label, finish_axes
from nonsmooth.plot.trace import check_range, check_variables, curve, thinned

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["common_label", "draw_lines", "time_history"]


def time_history(
    run: xr.Dataset,
    variables: str | Sequence[str],
    *,
    ax: Axes | None = None,
    events: bool = False,
    time_range: tuple[float, float] | None = None,
    labels: Mapping[str, str] | None = None,
    legend: bool = True,
) -> Axes:
    """Variables of a run over time.

    States are drawn through their values just before and just after each event, so kinks
    and jumps stand where they are, however coarse the samples. Outputs are known at samples
    only. The first variable is solid, the next dashed, dotted and dash-dotted.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, or a measured motion.
    variables : str or sequence of str
        States and outputs.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    events : bool, optional
        Whether to mark the events on every curve.
    time_range : tuple of float, optional
        First and last time to draw; the whole run by default.
    labels : mapping of str to str, optional
        Texts of the legend by name of the variable; the name by default.
    legend : bool, optional
        Whether to draw a legend where there is more than one entry.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line per variable, labelled by its name.

    Raises
    ------
    OptionError
        For an unknown variable, or a range that does not meet the run.

    See Also
    --------
    phases : the same with the modes behind the curves.

    Notes
    -----
    A curve of more than 20000 points is thinned to the first, last, lowest and highest
    point in each of 2000 columns, which looks the same in print. To look closer, draw again
    with ``time_range``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=3)
    >>> ax = ns.plot.time_history(run, ["x", "v"], time_range=(0, 120))
    >>> ax.get_xlabel(), [line.get_label() for line in ax.lines]
    ('time', ['x', 'v'])
    """
    names = check_variables(run, variables)
    time_range = check_range(run, time_range)
    ax = new_axes() if ax is None else ax
    draw_lines(run, names, ax, time_range, labels or {})
    if events:
        for name in names:
            event_markers(run, name, ax, time_range=time_range)
    finish_axes(ax, axis_label(run["time"]), common_label(run, names))
    if legend and len(ax.get_legend_handles_labels()[1]) > 1:
        place_legend(ax)
    return ax


def draw_lines(
    run: xr.Dataset,
    names: Sequence[str],
    ax: Axes,
    time_range: tuple[float, float] | None,
    labels: Mapping[str, str],
) -> None:
    """One line per variable, and the time axis without margins."""
    for i, name in enumerate(names):
        trace = curve(run, [name], time_range)
        time, values = thinned(trace.time, trace.values[0])
        ax.plot(time, values, label=labels.get(name, name), **LINES[i % len(LINES)])
    low, high = time_range or (float(run["time"][0]), float(run["time"][-1]))
    if low < high:
        ax.set_xlim(low, high)


def common_label(run: xr.Dataset, names: Sequence[str]) -> str:
    """Label of the axis that some variables share: one long name, or all short ones."""
    if len(names) == 1:
        return axis_label(run[names[0]])
    units = [str(run[name].attrs.get("units", "")) for name in names]
    if len(set(units)) == 1:
        return ", ".join(names) + (f" [{units[0]}]" if units[0] not in ("", "1") else "")
    return ", ".join(
        f"{name} [{unit}]" if unit not in ("", "1") else name
        for name, unit in zip(names, units, strict=True)
    )
