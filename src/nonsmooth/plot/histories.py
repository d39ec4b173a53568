"""States over time, with the modes that a motion is in as spans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.flagged_samples import are_flagged, mark_flagged
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.markers import event_markers
from nonsmooth.plot.style import (
    LINES,
    axis_label,
    finish_axes,
    largest_state,
    mode_colours,
    modes_visited,
)
from nonsmooth.plot.trace import DENSE, check_log, check_range, check_variables, curve, thinned

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["common_label", "groups_alike", "mode_label", "phases", "time_history"]

_PALE = 0.3  # opacity behind curves: told apart in print, and black lines stay black
_APART = 10.0  # times the size of another curve, beside which that is hard to read
_FIRST, _FURTHER = 6.0, 3.2  # heights of a figure with one panel, and of each further one, in cm


@checked
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
    only. The first variable is solid, the next dashed, dotted and dash-dotted. Samples of a
    measured motion that `measured.flagged` has marked have blue crosses. Variables of other units,
    or more than ten times as large, have axes of their own below the first ones.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, or a measured motion.
    variables : str or sequence of str
        States and outputs.
    ax : matplotlib.axes.Axes, optional
        Where to draw all variables; new axes of a column's width by default.
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
        The axes; one line per variable, labelled by its name. Further ones are below them, in
        ``ax.figure.axes``.

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
    panels = _panels(run, names, time_range, ax)
    for panel, group in panels:
        draw_lines(run, group, panel, time_range, labels or {})
        _mark_flagged(run, group, panel, time_range)
        if events:
            for name in group:
                event_markers(run, name, panel, time_range=time_range)
        _finish(run, group, panel, time_range, last=panel is panels[-1][0])
        if legend and len(panel.get_legend_handles_labels()[1]) > 1:
            place_legend(panel)
    return panels[0][0]


def groups_alike(
    run: xr.Dataset, names: Sequence[str], time_range: tuple[float, float] | None = None
) -> list[list[str]]:
    """Names of variables in groups of one unit and of sizes that can be read on one axis."""
    inside = run
    if time_range is not None:
        low, high = time_range
        inside = run.isel(time=((run["time"] >= low) & (run["time"] <= high)).values)
    sizes = {}
    for name in names:
        values = np.abs(inside[name].values.astype(float))
        sizes[name] = float(values[np.isfinite(values)].max(initial=0.0))
    units = {name: str(run[name].attrs.get("units", "") or "1") for name in names}
    groups: list[list[str]] = []
    for name in sorted(sizes, key=lambda each: -sizes[each]):  # the largest of a group is first
        alike = (
            group
            for group in groups
            if units[group[0]] == units[name]
            and (sizes[name] == 0.0 or sizes[group[0]] <= _APART * sizes[name])
        )
        group = next(alike, None)
        if group is None:
            groups.append([name])
        else:
            group.append(name)
    order = list(names)
    groups = [sorted(group, key=order.index) for group in groups]
    return sorted(groups, key=lambda group: order.index(group[0]))


def _panels(
    run: xr.Dataset,
    names: Sequence[str],
    time_range: tuple[float, float] | None,
    ax: Axes | None,
) -> list[tuple[Axes, list[str]]]:
    """Axes with the variables that are drawn on them, the upper ones without numbers of time."""
    if ax is not None:
        return [(ax, list(names))]
    groups = groups_alike(run, names, time_range)
    first = new_axes(height=_FIRST + _FURTHER * (len(groups) - 1))
    axes = [first] if len(groups) == 1 else divided(first, len(groups))
    for upper in axes[:-1]:
        upper.tick_params(labelbottom=False)
    return list(zip(axes, groups, strict=True))


def _finish(
    run: xr.Dataset,
    names: Sequence[str],
    ax: Axes,
    time_range: tuple[float, float] | None,
    *,
    last: bool,
) -> None:
    """Labels, that of time at the lowest axes; rounding beside other states is drawn as zero."""
    sizes = 0.0, max(largest_state(run, *names, time_range=time_range))
    finish_axes(ax, axis_label(run["time"]) if last else "", common_label(run, names), sizes=sizes)


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
        alone: dict[str, Any] = {"marker": "."} if time.size == 1 else {}  # no line leads anywhere
        ax.plot(time, values, label=labels.get(name, name), **LINES[i % len(LINES)], **alone)
    low, high = time_range or (float(run["time"][0]), float(run["time"][-1]))
    if low < high:
        ax.set_xlim(low, high)


def _mark_flagged(
    run: xr.Dataset, names: Sequence[str], ax: Axes, time_range: tuple[float, float] | None
) -> None:
    """Crosses on flagged samples of all variables."""
    time = run["time"].values.astype(float)
    low, high = time_range or (-np.inf, np.inf)
    inside = (time >= low) & (time <= high)
    for name in names:
        mark_flagged(ax, time, run[name].values, are_flagged(run, [name]) & inside)


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


@checked
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
    every picture, see `mode_colours`. Stays that are shorter than a pixel mix with those beside
    them, each by its share of the time.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.
    variables : str or sequence of str
        States and outputs.
    time_range : tuple of float, optional
        First and last time to draw, such as those of one period; the whole run by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw all variables; new axes of a column's width by default.
    labels : mapping of str to str, optional
        Texts of the legend by name of the variable or mode; the name by default.
    legend : bool, optional
        Whether to draw a legend of lines and modes.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line per variable, one collection of rectangles per mode. Further ones are
        below them, in ``ax.figure.axes``, as for `time_history`.

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
    panels = _panels(run, names, time_range, ax)
    labels = labels or {}
    for panel, group in panels:
        draw_lines(run, group, panel, time_range, labels)
        _draw_modes(run, panel, panel.get_xlim(), labels)
        _finish(run, group, panel, time_range, last=panel is panels[-1][0])
    if legend:
        place_legend(panels[0][0])
        for panel, group in panels[1:]:
            if len(group) > 1:  # the modes are explained above
                place_legend(panel, panel.lines)
    return panels[0][0]


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
    colours = mode_colours(run)
    for name, here in modes_visited(run, spans.mode).items():
        begin, end = spans.begin[here], spans.end[here]
        corners = np.zeros((begin.size, 4, 2))
        corners[:, :2, 0], corners[:, 2:, 0] = begin[:, None], end[:, None]
        corners[:, 1:3, 1] = 1.0
        rectangles = PolyCollection(
            list(corners),
            transform=ax.get_xaxis_transform(),
            facecolor=colours[name],
            alpha=_PALE,
            edgecolor="none",
            zorder=0,
            rasterized=begin.size > DENSE,
            snap=False,  # a stay shorter than a pixel tints it by its share, and is not left out
            label=labels.get(name, mode_label(name)),
        )
        ax.add_collection(rectangles, autolim=False)


def mode_label(name: str) -> str:
    """Name of a mode as it is read."""
    return name.replace("_", " ")
