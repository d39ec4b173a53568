"""`growth_curve`: a crack that grows, with Poincaré sections at some of its lengths."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.sections import section
from nonsmooth.plot.style import LINES, axis_label, finish_axes
from nonsmooth.plot.trace import thinned
from nonsmooth.runs.options import finite_number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["growth_curve"]

Floats = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

_LEFT, _BOTTOM, _RIGHT, _TOP = 0.03, 0.24, 0.80, 0.93  # of the insets, in parts of the axes
_GAP = 0.03  # between them
_ROOM = 0.08  # beside the points, in parts of their range
_TITLE = 0.09  # height of the text above each


@checked
def growth_curve(
    curve: xr.Dataset,
    sections: Mapping[float, xr.Dataset] | None = None,
    x: str = "u",
    y: str = "v",
    *,
    growing: str = "crack",
    ax: Axes | None = None,
    places: Sequence[Box] | None = None,
    size: float | None = None,
    unit: str = "mm",
) -> Axes:
    """A parameter that grows over time, with Poincaré sections at some of its values.

    Each section stands in an inset, tied to its place on the curve by a thin line.

    Parameters
    ----------
    curve : xarray.Dataset
        What grows over ``time``: a run with a slowly varying parameter, or any dataset with a
        variable of that name over one dimension.
    sections : mapping of float to xarray.Dataset, optional
        Points by the value at which they were computed: results of `stroboscopic_map` or
        `poincare_section`.
    x, y : str
        Variables of the sections.
    growing : str, optional
        The variable of ``curve``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    places : sequence of tuple of float, optional
        Left end, bottom, width and height of each inset in parts of the axes, in the order of the
        values; by default rows in the upper left, which a curve that rises late leaves free.
    size : float, optional
        Diameter of the points of the sections, in typographic points; by default smaller where
        there are more of them.
    unit : str, optional
        Unit of the values above the insets.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; the insets are its ``child_axes``, the smallest value first.

    Raises
    ------
    OptionError
        For an unknown variable, a value that the curve does not reach, or a wrong number of
        places.

    Notes
    -----
    Insets have neither ticks nor scales of their own, which would not be legible in a column; they
    share the range of all sections, so that motions may be compared.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> import xarray as xr
    >>> t = np.linspace(0.0, 9.4e5, 500)
    >>> crack = xr.Dataset(
    ...     {"crack": ("time", 5 + 1e-3 * np.exp(t / 54734 - 7.8), {"units": "mm"})},
    ...     {"time": ("time", t, {"units": "1/omega_M"})},
    ... )
    >>> points = {
    ...     a: ns.stroboscopic_map(ns.models.breathing_crack(crack=a), transient=300, record=50)
    ...     for a in (5.01, 12.0)
    ... }
    >>> ax = ns.plot.growth_curve(crack, points)
    >>> [inset.get_title() for inset in ax.child_axes]
    ['5.01 mm', '12 mm']
    """
    times, lengths = _curve(curve, growing)
    given = dict(sections or {})
    values = sorted(finite_number("sections", value) for value in given)
    spots = [_spot(times, lengths, value, growing) for value in values]
    boxes = _boxes(len(values)) if places is None else list(places)
    if len(boxes) != len(values):
        raise OptionError(f"places: {len(boxes)} places for {len(values)} sections")
    ax = new_axes() if ax is None else ax
    ax.plot(*thinned(times, lengths), **LINES[0])
    finish_axes(ax, axis_label(curve["time"]), axis_label(curve[growing]))
    ax.margins(y=0.04)
    insets = [
        _inset(ax, box, given[value], (x, y), f"{value:g} {unit}".strip(), size)
        for value, box in zip(values, boxes, strict=True)
    ]
    _share_limits(insets)
    for box, spot in zip(boxes, spots, strict=True):
        _tie(ax, box, spot)
    return ax


def _curve(curve: xr.Dataset, growing: str) -> tuple[Floats, Floats]:
    known = [str(n) for n, v in curve.variables.items() if v.dims == ("time",)]
    if growing not in known:
        raise OptionError(f"growing: {unknown_name('variable', growing, known)}")
    return curve["time"].values.astype(float), curve[growing].values.astype(float)


def _spot(times: Floats, lengths: Floats, value: float, growing: str) -> tuple[float, float]:
    """Where the curve first reaches a value."""
    reached = np.flatnonzero(np.diff(lengths >= value, prepend=lengths[0] >= value))
    if lengths[0] == value:
        return float(times[0]), value
    if reached.size == 0:
        raise OptionError(
            f"sections: {growing} = {value:g} is not reached; it goes from {lengths.min():g} to"
            f" {lengths.max():g}"
        )
    k = int(reached[0])
    share = (value - lengths[k - 1]) / (lengths[k] - lengths[k - 1])
    return float(times[k - 1] + share * (times[k] - times[k - 1])), value


def _boxes(count: int) -> list[Box]:
    """Places in rows, from the lower left to the upper right."""
    rows = 1 if count <= 2 else 2 if count <= 6 else 3
    columns = math.ceil(count / rows)
    width = (_RIGHT - _LEFT - (columns - 1) * _GAP) / max(columns, 1)
    each = (_TOP - _BOTTOM) / rows
    height = min(each - _TITLE, 1.4 * width)
    # the first ones below: their places on the curve are lower
    return [
        (
            _LEFT + (k % columns) * (width + _GAP),
            _TOP - (rows - 1 - k // columns) * each - height,
            width,
            height,
        )
        for k in range(count)
    ]


def _inset(
    ax: Axes, box: Box, points: xr.Dataset, names: tuple[str, str], title: str, size: float | None
) -> Axes:
    inset = ax.inset_axes(box)
    section(points, *names, ax=inset, size=size)
    inset.set(xlabel="", ylabel="", xticks=[], yticks=[])
    inset.set_title(title, fontsize=float(ax.xaxis.label.get_fontsize()) - 1.0, pad=3.5,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.0})  # fmt: skip
    for spine in inset.spines.values():
        spine.set(linewidth=0.5, edgecolor="0.4")
    return inset


def _share_limits(insets: list[Axes]) -> None:
    """One range for all sections, with some room about them."""
    if not insets:
        return
    limits = []
    for which in (0, 1):
        values = np.concatenate([inset.lines[0].get_data()[which] for inset in insets])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        room = _ROOM * (high - low) or 1.0
        limits.append((low - room, high + room))
    for inset in insets:
        inset.set(xlim=limits[0], ylim=limits[1])


def _tie(ax: Axes, box: Box, spot: tuple[float, float]) -> None:
    """Dot on the curve, and a line to the nearer end of the inset's lower edge or side."""
    ax.plot(*spot, marker="o", markersize=3.0, color=LINES[1]["color"], zorder=4)
    left, bottom, width, _ = box
    to_axes = ax.transData + ax.transAxes.inverted()
    there = to_axes.transform(spot)
    corner = (float(np.clip(there[0], left, left + width)), bottom)
    ax.annotate(
        "", xy=spot, xytext=corner, xycoords="data", textcoords="axes fraction", zorder=1.5,
        arrowprops={"arrowstyle": "-", "color": "0.55", "linewidth": 0.6, "shrinkA": 0.0,
                    "shrinkB": 0.0},
    )  # fmt: skip
