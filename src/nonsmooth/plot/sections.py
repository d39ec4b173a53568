"""Points of a section or of a map: one variable over another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.flagged_samples import are_flagged, mark_flagged
from nonsmooth.plot.histories import mode_label
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import (
    LINES,
    axis_label,
    finish_axes,
    largest_state,
    mode_colours,
    modes_visited,
)
from nonsmooth.plot.trace import DENSE
from nonsmooth.runs.options import positive_number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["checked_diameter", "diameter_of", "section"]

# diameter in points by the number of places with a point: single ones are seen, many leave
# gaps between them
_SIZES = ((200, 3.0), (2_000, 1.6), (DENSE, 0.9), (200_000, 0.5))
_WIDEST = 100.0  # points: half of a column's width
_SMALLEST = 0.3  # a little more than a pixel of a print at 300 dots per inch
_PLACES = 1_000  # per side


@checked
def section(
    points: xr.Dataset,
    x: str,
    y: str,
    *,
    ax: Axes | None = None,
    phases: bool = False,
    size: float | None = None,
    legend: bool = True,
) -> Axes:
    """Points of a section: one variable over another.

    Points of a measured motion that were made of flagged samples (`measured.flagged`) are blue
    crosses.

    Parameters
    ----------
    points : xarray.Dataset
        Result of `poincare_section`, or of anything else with points.
    x, y : str
        States, outputs, or coordinates such as ``phase``; both over the same dimensions.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    phases : bool, optional
        Whether points have the colour of their mode.
    size : float, optional
        Diameter of a point in typographic points; by default smaller where there are
        more of them.
    legend : bool, optional
        Whether to draw a legend of the modes with ``phases=True``, and of flagged points.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one set of points, or one per mode.

    Raises
    ------
    OptionError
        For an unknown variable.

    Notes
    -----
    More than 20000 points are an image within a PDF, so that a million make a small file.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> points = ns.poincare_section(ns.models.duffing(), section="v", record=200)
    >>> ax = ns.plot.section(points, "phase", "x")
    >>> ax.get_xlabel(), len(ax.lines[0].get_xdata())
    ('time since the period began', 200)
    """
    for name in (x, y):
        _check_variable(points, name)
    if points[x].dims != points[y].dims:
        raise OptionError(
            f"{x!r} is over {points[x].dims} and {y!r} over {points[y].dims}; draw two variables"
            " over the same points"
        )
    across, up = points[x].values.ravel(), points[y].values.ravel()
    ax = new_axes() if ax is None else ax
    diameter = diameter_of(across, up) if size is None else checked_diameter(size)
    flagged = are_flagged(points, [x, y]).ravel()
    sets = {"": ~flagged}
    colours = {"": LINES[0]["color"]}
    if phases:
        colours = mode_colours(points)
        sets = modes_visited(points, points["mode"].values.ravel())
    for name, here in sets.items():
        ax.plot(
            across[here],
            up[here],
            linestyle="none",
            marker="o",
            markersize=diameter,
            markeredgewidth=0.0,
            color=colours[name],
            label=mode_label(name) or None,
            rasterized=across.size > DENSE,
        )
    mark_flagged(ax, across, up, flagged)
    finish_axes(ax, axis_label(points[x]), axis_label(points[y]), sizes=largest_state(points, x, y))
    if (phases or flagged.any()) and legend:
        place_legend(ax)
    return ax


def _check_variable(points: xr.Dataset, name: str) -> None:
    known = [str(v) for v in (*points.data_vars, *points.coords) if points[v].dtype.kind in "fiub"]
    if name not in known:
        raise OptionError(unknown_name("variable", name, known))


def checked_diameter(size: float) -> float:
    """Diameter of points that a caller gives."""
    if positive_number("size", size) > _WIDEST:
        raise OptionError(
            f"size = {size:g} is a diameter in typographic points, 0.35 mm; give at most"
            f" {_WIDEST:g}"
        )
    return float(size)


def diameter_of(across: npt.NDArray[np.float64], up: npt.NDArray[np.float64]) -> float:
    """Diameter by the number of places: the many points of a periodic motion lie on a few."""
    places = _place(across) * _PLACES + _place(up)
    count = np.count_nonzero(np.bincount(places, minlength=1))
    return next((size for most, size in _SIZES if count <= most), _SMALLEST)


def _place(values: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    finite = values[np.isfinite(values)]
    if finite.size == 0 or np.ptp(finite) == 0.0:
        return np.zeros(values.size, np.int64)
    share = (np.nan_to_num(values, nan=finite[0]) - finite.min()) / np.ptp(finite)
    return np.clip(share * _PLACES, 0, _PLACES - 1).astype(np.int64)
