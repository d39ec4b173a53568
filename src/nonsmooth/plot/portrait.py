"""`phase_portrait`: one variable of a run over another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.mode_spans import mode_label
from nonsmooth.plot.style import LINES, axis_label, finish_axes, mode_colours, mode_numbers
from nonsmooth.plot.surfaces import draw_surfaces
from nonsmooth.plot.trace import (
    DENSE,
    Trace,
    broken,
    check_range,
    check_variables,
    curve,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["phase_portrait"]

_CELLS = 2_000  # per side; 8 cm at 600 dots per inch are 1890 pixels


def phase_portrait(
    run: xr.Dataset,
    x: str,
    y: str,
    *,
    ax: Axes | None = None,
    phases: bool = False,
    surfaces: bool = False,
    time_range: tuple[float, float] | None = None,
    legend: bool = True,
) -> Axes:
    """One variable of a run over another.

    Two states are drawn through their values just before and just after each event. Where
    one of the two is an output, both are drawn at samples only.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, or a measured motion.
    x, y : str
        States or outputs.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    phases : bool, optional
        Whether each part has the colour of its mode; jumps are then thin grey lines.
    surfaces : bool, optional
        Whether to draw, dashed, where guards vanish: stops and switching surfaces. Only
        those that depend on the two states drawn and on parameters have a place here.
    time_range : tuple of float, optional
        First and last time to draw, to leave out a transient; the whole run by default.
    legend : bool, optional
        Whether to draw a legend of the modes with ``phases=True``.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line, or one per mode and one for the jumps.

    Raises
    ------
    OptionError
        For an unknown variable, or a range that does not meet the run.

    Notes
    -----
    Of more than 20000 points those are left out that lie in one pixel with both
    neighbours; if many remain, the curve is an image within a PDF.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=20)
    >>> T = run.attrs["period"]
    >>> ax = ns.plot.phase_portrait(run, "p", "y", phases=True, time_range=(10 * T, 20 * T))
    >>> [line.get_label() for line in ax.lines]
    ['no contact', 'contact', 'progression']
    """
    names = check_variables(run, [x, y])
    time_range = check_range(run, time_range)
    ax = new_axes() if ax is None else ax
    trace = _without_crowds(curve(run, names, time_range))
    dense = trace.time.size > DENSE
    if phases:
        _draw_by_mode(run, trace, ax, dense)
    else:
        ax.plot(*trace.values, color=LINES[0]["color"], linewidth=0.6, rasterized=dense)
    if surfaces:
        draw_surfaces(run, x, y, ax)
    finish_axes(ax, axis_label(run[x]), axis_label(run[y]))
    if phases and legend:
        place_legend(ax)
    return ax


def _draw_by_mode(run: xr.Dataset, trace: Trace, ax: Axes, dense: bool) -> None:
    """A line per mode, broken where the run is in another mode, and one for the jumps."""
    for name, colour in mode_colours(run).items():
        here = np.isin(trace.mode, mode_numbers(run, name))
        points = broken(trace.values, here & ~trace.jumps)
        if points.size:
            label = mode_label(name)
            ax.plot(*points, color=colour, linewidth=1.2, label=label, rasterized=dense)
    # slaved states meet their equation at an event, which moves them by rounding
    visible = np.ptp(trace.values, axis=1, keepdims=True) / _CELLS
    moved = np.append(np.any(np.abs(np.diff(trace.values, axis=1)) > visible, axis=0), False)
    points = broken(trace.values, trace.jumps & moved)
    if points.size:
        ax.plot(*points, color="0.6", linewidth=0.8, label="jump", rasterized=dense, zorder=1)


def _without_crowds(trace: Trace) -> Trace:
    """Leave out points that lie in one pixel with both neighbours, in one mode."""
    if trace.time.size <= DENSE:
        return trace
    low = np.nanmin(trace.values, axis=1, keepdims=True)
    width = np.nanmax(trace.values, axis=1, keepdims=True) - low
    with np.errstate(invalid="ignore"):
        cell = np.floor((trace.values - low) / np.where(width > 0.0, width, 1.0) * _CELLS)
    # a point that is not a number differs from its neighbours, so the gap stays
    same = np.all(cell[:, 1:] == cell[:, :-1], axis=0) & (np.diff(trace.mode) == 0)
    same &= ~(trace.jumps[1:] | trace.jumps[:-1])
    crowded = np.zeros(trace.time.size, bool)
    crowded[1:-1] = same[1:] & same[:-1]
    return trace.take(~crowded)
