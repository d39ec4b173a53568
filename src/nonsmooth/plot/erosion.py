"""`erosion_profile`: integrity of basins over a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, is_known, unknown_choice
from nonsmooth.plot.attractor_style import attractor_styles
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["erosion_profile"]

Floats = npt.NDArray[np.float64]

# measure, its error, and what it is called with and without a reference
_MEASURES = {
    "local": ("local_integrity", "local_error", "distance from the border"),
    "global": ("global_integrity", "global_error", "share of the region"),
    "factor": ("integrity_factor", "factor_error", "radius of the largest ball"),
}
_RINGED = "ball ended by the region"
_PALE = 0.25  # opacity of bands
_DASHES = ("-", "--", "-.", ":")


@checked
def erosion_profile(
    profile: xr.Dataset,
    measure: str = "local",
    *,
    relative: bool = False,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Integrity of basins over a parameter, with the bounds of its errors as bands.

    Parameters
    ----------
    profile : xarray.Dataset
        Result of `erosion_profile`.
    measure : {"local", "global", "factor"}, optional
        What to draw: the distance of each attractor from the border of its basin, the share of the
        region in its basin, or the radius of the largest ball in it.
    relative : bool, optional
        Whether to divide each curve by its largest value, so that profiles begin near one.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. Attractors have the colours of `nonsmooth.plot.basins`; a circle around a point
        says that the end of the region, and not a border, ends the ball, which may be larger.

    Raises
    ------
    OptionError
        For another dataset, or an unknown measure.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> wells = ns.System(
    ...     states=["x", "y"],
    ...     parameters={"c": 0.0},
    ...     period=1.0,
    ...     definitions={"s": "x + y"},
    ...     equations={"x": "(-s + sign(s - c))/2 - x + y", "y": "(-s + sign(s - c))/2 + x - y"},
    ... )
    >>> cells = np.linspace(-2, 2, 20)
    >>> found = ns.erosion_profile(wells, "c", [0.1, 0.4, 0.8], {"x": cells, "y": cells})
    >>> ax = ns.plot.erosion_profile(found)
    >>> ax.get_xlabel(), ax.get_ylabel(), len(ax.lines)
    ('c', 'distance from the border', 2)
    """
    if not is_known(measure, _MEASURES):
        raise OptionError(unknown_choice("measure", measure, list(_MEASURES)))
    name, error, label = _MEASURES[measure]
    if name not in profile or profile[name].dims != ("parameter", "attractor"):
        raise OptionError(
            "profile: the dataset has no integrity over a parameter; give a result of"
            " erosion_profile"
        )
    ax = new_axes() if ax is None else ax
    numbers = profile["attractor"].values.tolist()
    styles = attractor_styles(profile, numbers)
    values = profile["parameter"].values
    rings = []
    for place, number in enumerate(numbers):
        one = profile.sel(attractor=number)
        height, bound = one[name].values, one[error].values
        size = float(np.nanmax(height)) if np.isfinite(height).any() else 1.0
        scale = size if relative and size > 0.0 else 1.0
        colour = styles[number].points
        ax.plot(
            values, height / scale, color=colour, linestyle=_DASHES[place % len(_DASHES)],
            linewidth=1.0, marker=".", markersize=3.0, label=f"attractor {number}",
        )  # fmt: skip
        low = np.maximum(height - bound, 0.0) / scale
        ax.fill_between(
            values, low, (height + bound) / scale, color=colour, alpha=_PALE, linewidth=0.0
        )
        ended = _ended_by_region(one, measure)
        if ended.any():
            rings.append((values[ended], height[ended] / scale, colour))
    for place, (across, up, colour) in enumerate(rings):  # last, as is their entry of the legend
        ax.plot(
            across, up, linestyle="none", marker="o", markersize=4.0, markerfacecolor="none",
            markeredgecolor=colour, markeredgewidth=0.8, label="" if place else _RINGED,
        )  # fmt: skip
    if relative:
        label += ", beside its largest"
    finish_axes(ax, axis_label(profile["parameter"]), label)
    ax.set_ylim(bottom=0.0)
    if legend:
        place_legend(ax)
    return ax


def _ended_by_region(one: xr.Dataset, measure: str) -> npt.NDArray[np.bool_]:
    """Where a ball ends at the end of the region, and may be larger."""
    limit = f"{measure}_limit"
    if limit not in one:
        return np.zeros(one.sizes["parameter"], bool)
    return np.asarray(one[limit].values == "region")
