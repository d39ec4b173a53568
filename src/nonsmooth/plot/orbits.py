"""`orbit`: the path of a point in its plane, as it is seen along the shaft."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.portrait import phase_portrait
from nonsmooth.plot.style import LINES, axis_label, finish_axes
from nonsmooth.plot.trace import DENSE, check_range, check_variables, curve

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["orbit"]

_FEW = 200  # marks that are drawn large enough to be told apart from the curve


@checked
def orbit(
    run: xr.Dataset,
    x: str = "x",
    y: str = "y",
    *,
    ax: Axes | None = None,
    ring: tuple[str, str] | None = None,
    clearance: float | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
    phases: bool = True,
    marks: bool = True,
    time_range: tuple[float, float] | None = None,
    legend: bool = True,
) -> Axes:
    """Orbit of a rotor with equal axes, once-per-revolution marks and the clearance circle.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, also one in other units.
    x, y : str, optional
        States or outputs: the two coordinates.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    ring : tuple of str, optional
        Coordinates of another body, whose orbit is drawn beside, such as ``("sx", "sy")``.
    clearance : float, optional
        Radius of the circle that the point may move in without contact, in the units of x.
    centre : tuple of float, optional
        Centre of that circle.
    phases : bool, optional
        Whether each part has the colour of its mode, where there are several.
    marks : bool, optional
        Whether to mark where the point is at the beginning of each period, as the mark on a shaft
        does once per revolution. Of a run without a period there are none.
    time_range : tuple of float, optional
        First and last time to draw, to leave out a transient; the whole run by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For an unknown variable, a clearance that is not positive, or a range that does not meet
        the run.

    See Also
    --------
    phase_portrait : any two variables, with axes of their own.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.rotor(eta=3.0), periods=210)
    >>> T = run.attrs["period"]
    >>> ax = ns.plot.orbit(run, ring=("sx", "sy"), clearance=1.0, time_range=(200 * T, 210 * T))
    >>> ax.get_aspect(), ax.lines[-1].get_label()
    (1.0, 'every period')
    """
    check_variables(run, [x, y, *(() if ring is None else ring)])
    time_range = check_range(run, time_range)
    if clearance is not None and not float(clearance) > 0.0:
        raise OptionError(f"clearance = {quote(clearance)} must be positive: it is a radius")
    several = phases and len(run["mode"].attrs.get("flag_meanings", "").split()) > 1
    ax = phase_portrait(run, x, y, ax=ax, phases=several, time_range=time_range, legend=False)
    if ring is not None:
        values = curve(run, ring, time_range).values
        label = ", ".join(ring)
        ax.plot(
            *values, **LINES[2] | {"linewidth": 1.0}, label=label, rasterized=values.size > DENSE
        )
    if clearance is not None:
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        circle = (
            c + clearance * wave(angle) for c, wave in zip(centre, (np.cos, np.sin), strict=True)
        )
        ax.plot(*circle, color="0.4", linestyle="--", linewidth=0.7, label="clearance", zorder=1)
    if marks:
        _mark_revolutions(run, x, y, ax, time_range)
    ax.set_aspect("equal", adjustable="datalim")
    finish_axes(ax, axis_label(run[x]), axis_label(run[y]))
    if legend:
        place_legend(ax)
    return ax


def _mark_revolutions(
    run: xr.Dataset, x: str, y: str, ax: Axes, time_range: tuple[float, float] | None
) -> None:
    """Dots where periods begin, between two samples if none is there."""
    if "phase" not in run.coords:
        return
    time = run["time"].values.astype(float)
    begins = np.unique(time - run["phase"].values)
    low, high = time_range or (time[0], time[-1])
    slack = 1e-9 * (high - low)
    begins = begins[(begins >= max(low, time[0]) - slack) & (begins <= high + slack)]
    # rounding gives one period several beginnings
    begins = begins[np.diff(begins, prepend=-np.inf) > slack]
    points = [np.interp(begins, time, run[name].values) for name in (x, y)]
    ax.plot(
        *points, linestyle="none", marker="o", markersize=3.5 if begins.size <= _FEW else 1.2,
        markerfacecolor="white", markeredgecolor="black",
        markeredgewidth=0.7 if begins.size <= _FEW else 0.3, zorder=4,
        label="every period", rasterized=begins.size > DENSE,
    )  # fmt: skip
