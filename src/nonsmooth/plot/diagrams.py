"""`bifurcation`: settled motions over a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.arguments import checked
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["bifurcation"]

_DENSE = 20_000  # points; more become an image within a PDF
_FEW = 3_000  # points that are drawn large enough to be seen one by one
_MARKERS = "osD^v<>"


@checked
def bifurcation(
    diagram: xr.Dataset,
    variable: str,
    *,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Points of a bifurcation diagram over its parameter.

    Parameters
    ----------
    diagram : xarray.Dataset
        Result of `bifurcation_diagram`, or of `measured.diagram`.
    variable : str
        A state or output, or what there is once per column, such as ``"period"``, ``"events"`` or
        ``"v_per_time"``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to tell several initial states apart in a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one set of points for each initial state.

    Raises
    ------
    OptionError
        For an unknown variable, or a dataset that is no diagram.

    Notes
    -----
    More than 20000 points become an image within a PDF, so that the file stays small.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> diagram = ns.bifurcation_diagram(
    ...     ns.models.soft_impact(), "omega", [0.7, 0.8], transient=50, record=10
    ... )
    >>> ax = ns.plot.bifurcation(diagram, "x")
    >>> ax.get_ylabel()
    'displacement of the mass'
    """
    if "parameter" not in diagram.dims or "lane" not in diagram.dims:
        raise OptionError("the dataset has no dimensions 'parameter' and 'lane'; give it a diagram")
    known = [str(name) for name, values in diagram.data_vars.items() if values.dtype.kind in "fi"]
    if variable not in known:
        raise OptionError(unknown_name("variable", variable, known))
    ax = new_axes() if ax is None else ax
    values = diagram[variable].transpose("parameter", "lane", ...).values
    if values.ndim == 2:
        values = values[:, :, None]
    count = int(np.isfinite(values).sum())
    size = 3.0 if count <= _FEW else (1.5 if count <= _DENSE else 0.9)
    colours = list(PALETTE.values())
    for lane in range(values.shape[1]):
        here = np.broadcast_to(diagram["parameter"].values[:, None], values[:, lane].shape)
        single = values.shape[1] == 1
        ax.plot(
            here.ravel(),
            values[:, lane].ravel(),
            linestyle="none",
            marker="." if count > _FEW else _MARKERS[lane % len(_MARKERS)],
            markersize=size * max(0.4, 1.0 - 0.3 * lane),  # those below stay visible
            markeredgewidth=0.0,
            color="black" if single else colours[lane % len(colours)],
            label=None if single else f"initial state {lane + 1}",
            rasterized=count > _DENSE,
        )
    finish_axes(ax, axis_label(diagram["parameter"]), _height_label(diagram, variable))
    if legend:
        place_legend(ax)
    return ax


def _height_label(diagram: xr.Dataset, variable: str) -> str:
    """Label of what is drawn, and on which side of which event; samples at strobes need no word."""
    event = str(diagram.attrs.get("at", "strobe"))
    side = str(diagram.attrs.get("side", ""))
    recorded = {"parameter", "lane"} < set(diagram[variable].dims)
    if not recorded or not side or event == "strobe":
        return axis_label(diagram[variable])
    named = diagram[variable].assign_attrs(
        long_name=f"{diagram[variable].attrs.get('long_name') or variable} {side} {event}"
    )
    return axis_label(named)
