"""`erosion_profile`: integrity of basins over a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

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
Mask = npt.NDArray[np.bool_]


class _ErosionCurve(NamedTuple):
    """A measure of one basin over the parameter, nan where it is not known."""

    number: int  # of the attractor that gives it its colour
    text: str
    height: Floats
    bound: Floats
    by_region: Mask  # where a ball ends at the end of the region, and may be larger


# measure, its error, and what it is called with and without a reference
_MEASURES = {
    "local": ("local_integrity", "local_error", "distance from the border"),
    "global": ("global_integrity", "global_error", "share of the region"),
    "factor": ("integrity_factor", "factor_error", "radius of the largest ball"),
}
_UNSEEN = {"local": 1.0, "global": 0.0, "factor": 1.5}  # as the errors where there is no cell
_RINGED = "ball ended by the region"
_TOGETHER = "safe basin"
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
        The axes, over all values. Attractors have the colours of `nonsmooth.plot.basins`; a curve
        is zero where its basin is gone. The safe basin of ``safe="all"`` is one curve; the distance
        is then that of the attractor that lies nearest to its border. A circle around a point says
        that the end of the region, and not a border, ends the ball, which may be larger.

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
    name, _, label = _MEASURES[measure]
    if name not in profile or profile[name].dims != ("parameter", "attractor"):
        raise OptionError(
            "profile: the dataset has no integrity over a parameter; give a result of"
            " erosion_profile"
        )
    ax = new_axes() if ax is None else ax
    curves = _curves(profile, measure)
    styles = attractor_styles(profile, [each.number for each in curves])
    values = profile["parameter"].values
    rings = []
    for place, each in enumerate(curves):
        height = each.height
        size = float(np.nanmax(height)) if np.isfinite(height).any() else 1.0
        scale = size if relative and size > 0.0 else 1.0
        colour = styles[each.number].points
        ax.plot(
            values, height / scale, color=colour, linestyle=_DASHES[place % len(_DASHES)],
            linewidth=1.0, marker=".", markersize=3.0, label=each.text,
        )  # fmt: skip
        low = np.maximum(height - each.bound, 0.0) / scale
        ax.fill_between(
            values, low, (height + each.bound) / scale, color=colour, alpha=_PALE, linewidth=0.0
        )
        if each.by_region.any():
            rings.append((values[each.by_region], height[each.by_region] / scale, colour))
    for place, (across, up, colour) in enumerate(rings):  # last, as is their entry of the legend
        ax.plot(
            across, up, linestyle="none", marker="o", markersize=4.0, markerfacecolor="none",
            markeredgecolor=colour, markeredgewidth=0.8, label="" if place else _RINGED,
        )  # fmt: skip
    if relative:
        label += ", beside its largest"
    # also over values at which there is nothing to draw
    ax.update_datalim(np.column_stack([values, np.zeros(values.size)]))
    ax.autoscale_view()
    finish_axes(ax, axis_label(profile["parameter"]), label)
    ax.set_ylim(bottom=0.0)
    if legend:
        place_legend(ax)
    return ax


def _curves(profile: xr.Dataset, measure: str) -> list[_ErosionCurve]:
    """What there is to draw: a curve for each attractor, or one for the basins of all."""
    name, error, _ = _MEASURES[measure]
    height, bound = profile[name].values.copy(), profile[error].values.copy()
    limit = f"{measure}_limit"
    by_region = (
        profile[limit].values == "region" if limit in profile else np.zeros(height.shape, bool)
    )
    numbers = profile["attractor"].values.tolist()
    there = np.isfinite(profile["global_integrity"].values) if "global_integrity" in profile else (
        np.isfinite(height)
    )  # fmt: skip
    sure = profile["unsettled"].values == 0.0 if "unsettled" in profile else there.any(axis=1)
    unseen = _UNSEEN[measure] * profile.attrs.get("half_diagonal", 0.0)
    if profile.attrs.get("safe") != "all":
        gone = _gone(there, sure)
        height[gone], bound[gone] = 0.0, unseen
        return [
            _ErosionCurve(number, f"attractor {number}", height[:, k], bound[:, k], by_region[:, k])
            for k, number in enumerate(numbers)
        ]
    empty = sure & ~there.any(axis=1)
    whole = [np.where(empty, x, np.nan) for x in (0.0, unseen)] + [np.zeros(len(sure), bool)]
    for row in np.flatnonzero(there.any(axis=1)):
        # the ball around all attractors is that of the one where it is smallest
        unknown = there[row] & ~np.isfinite(height[row])
        least = int(np.argmax(unknown) if unknown.any() else np.nanargmin(height[row]))
        for each, rows in zip(whole, (height, bound, by_region), strict=True):
            each[row] = rows[row, least]
    return [_ErosionCurve(1, _TOGETHER, *whole)]


def _gone(there: Mask, sure: Mask) -> Mask:
    """Where a basin is gone that there was at a value beside.

    An attractor that is not found again may go on under a new number, so that none may begin there.

    shapes: there, result (values, attractors), sure (values,) where all starts are settled
    """
    gone = np.zeros_like(there)
    count = len(there)
    for order in (range(count), range(count - 1, -1, -1)):
        before = None
        for row in order:
            if before is not None and sure[row] and not np.any(there[row] & ~there[before]):
                gone[row] |= ~there[row] & (there[before] | gone[before])
            before = row
    return gone
