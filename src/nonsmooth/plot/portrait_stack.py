"""`phase_portrait_3d`: orbits at some values of a parameter, one behind the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import axis_label, growing_colours
from nonsmooth.plot.trace import DENSE, check_range, check_variables, curve
from nonsmooth.runs.options import finite_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["phase_portrait_3d"]

_ELEVATION, _AZIMUTH = 22.0, -52.0  # degrees: orbits seen nearly from the front, their stack too
_APART = 0.14  # of the range, between ticks whose texts do not touch
_DEPTH = 1.5  # of the third axis, in widths of the others
_PLACE = (-0.04, 0.07, 1.0, 1.02)  # of axes within the figure
_ZOOM = 0.98  # as much as leaves room for the labels


@checked
def phase_portrait_3d(
    runs: Mapping[float, xr.Dataset],
    x: str,
    y: str,
    *,
    label: str = "parameter",
    ax: Any = None,
    periods: float | None = 1.0,
    shadows: bool = True,
) -> Any:
    """Phase portraits at some values of a parameter, stacked along a third axis.

    Parameters
    ----------
    runs : mapping of float to xarray.Dataset
        Results of `simulate`, or measured motions, by the value at which each stands on the third
        axis, such as the length of a crack.
    x, y : str
        States or outputs.
    label : str, optional
        Label of the third axis, such as ``"crack length [mm]"``.
    ax : mpl_toolkits.mplot3d.axes3d.Axes3D, optional
        Where to draw; new axes of a column's width by default. Make others with
        ``figure.add_subplot(projection="3d")``.
    periods : float, optional
        How much of the end of each run is drawn, in periods; all of it with None.
    shadows : bool, optional
        Whether each orbit casts a grey one onto the wall behind all, where they can be compared.

    Returns
    -------
    mpl_toolkits.mplot3d.axes3d.Axes3D
        The axes; a line per orbit, the smallest value first, then the shadows.

    Raises
    ------
    OptionError
        For no runs, an unknown variable, axes without a third dimension, or ``periods`` of a run
        that has none.

    See Also
    --------
    phase_portrait : one of them, in the plane.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> runs = {}
    >>> for crack in (6.4, 10.0, 14.0):
    ...     beam = ns.models.breathing_crack(crack=crack)
    ...     runs[crack] = ns.simulate(beam, {"v": 0.1}, periods=200)
    >>> ax = ns.plot.phase_portrait_3d(runs, "u", "v", label="crack length [mm]")
    >>> len(ax.lines), ax.get_ylabel()
    (6, 'crack length [mm]')
    """
    if not isinstance(runs, Mapping) or not runs:
        raise OptionError("runs: give a mapping such as {6.4: run, 10.0: other_run}")
    values = sorted(finite_number("runs", value) for value in runs)
    orbits = {value: _orbit(runs[value], x, y, periods) for value in values}
    if ax is None:
        ax = new_axes(projection="3d")
        # the layout knows nothing of the texts beside slanted axes
        ax.figure.set_layout_engine("none")
        ax.set_position(_PLACE)
    elif getattr(ax, "name", "") != "3d":
        raise OptionError('ax: give axes of three dimensions, add_subplot(projection="3d")')
    span = values[-1] - values[0] or 1.0
    wall = values[-1] + 0.25 * span
    colours = growing_colours()
    for value, (across, up) in orbits.items():
        here = np.full(across.size, value)
        shade = colours((value - values[0]) / span)
        dense = across.size > DENSE
        ax.plot(across, here, up, color=shade, linewidth=1.0, rasterized=dense)
    for across, up in orbits.values() if shadows else ():
        there = np.full(across.size, wall)
        ax.plot(across, there, up, color="0.75", linewidth=0.6, rasterized=across.size > DENSE)
    _finish(ax, [axis_label(runs[values[0]][x]), label, axis_label(runs[values[0]][y])], values)
    ax.set_ylim(values[0] - 0.05 * span, wall)
    return ax


def _orbit(run: Any, x: str, y: str, periods: float | None) -> Any:
    names = check_variables(run, [x, y])
    if periods is None:
        return curve(run, names).values
    if "period" not in run.attrs:
        raise OptionError("periods: the run has no period; give periods=None, all of it is drawn")
    length = finite_number("periods", periods) * float(run.attrs["period"])
    if length <= 0.0:
        raise OptionError(f"periods = {periods} must be positive")
    if run.sizes["time"] == 1:  # a point, which is all there is
        return curve(run, names).values
    last = float(run["time"][-1])
    first = max(last - length, float(run["time"][0]))
    return curve(run, names, check_range(run, (first, last))).values


def _finish(ax: Any, labels: list[str], values: list[float]) -> None:
    """Labels close to their axes, pale panes, ticks at the values of the orbits."""
    from matplotlib.ticker import MaxNLocator

    ax.set_xlabel(labels[0], labelpad=-5.0)
    ax.set_ylabel(labels[1], labelpad=-1.0)
    ax.set_zlabel(labels[2], labelpad=-6.0)
    ax.tick_params(pad=-2.5)
    for axis in (ax.xaxis, ax.zaxis):
        axis.set_major_locator(MaxNLocator(4))
    ax.set_box_aspect((1.0, _DEPTH, 1.0), zoom=_ZOOM)
    ax.view_init(elev=_ELEVATION, azim=_AZIMUTH)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.pane.set_facecolor("white")
        axis.pane.set_edgecolor("0.7")
    ax.grid(visible=False)
    ticks = values[:1]
    for value in values[1:]:
        if value - ticks[-1] >= _APART * (values[-1] - values[0]):
            ticks.append(value)
    ax.set_yticks(ticks)
