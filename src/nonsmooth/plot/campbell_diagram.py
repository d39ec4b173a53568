"""`campbell`: natural frequencies over the speed of a shaft, with its critical speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["SENSES", "campbell"]

# colour and dashes of each sense of whirl; either is enough
SENSES: dict[str, dict[str, Any]] = {
    "forward": {"color": PALETTE["blue"], "linestyle": "-", "linewidth": 1.1},
    "backward": {"color": PALETTE["vermilion"], "linestyle": "--", "linewidth": 1.1},
    "straight": {"color": "0.35", "linestyle": "-.", "linewidth": 1.1},
    "none": {"color": "black", "linestyle": "-", "linewidth": 1.0},
}
_LABELS = {
    "forward": "forward whirl",
    "backward": "backward whirl",
    "straight": "straight",
    "none": "mode",
}
_RPM, _HERTZ = 30.0 / math.pi, 0.5 / math.pi
_ROOM = 1.12  # above the highest curve
_PLACES = 15  # along a line at which its name may stand


@checked
def campbell(
    data: xr.Dataset,
    *,
    units: Literal["rad/s", "rpm"] = "rad/s",
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Campbell diagram: frequencies of the modes over the speed.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.structures.campbell`.
    units : {"rad/s", "rpm"}, optional
        Unit of the speed. Frequencies are in rad/s too, or in Hz over revolutions per minute.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. Curves are blue in forward whirl, red and dashed in backward whirl, grey where
        nodes move on lines; circles are critical speeds, thin lines the speed and its multiples.

    Raises
    ------
    OptionError
        For another dataset.

    See Also
    --------
    root_locus : eigenvalues in the complex plane.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> disc = ns.Structure([[2, 0], [0, 2]], [[800, 0], [0, 900]], coordinates=["1x", "1y"])
    >>> ax = ns.plot.campbell(ns.structures.campbell(disc, [0.0, 15.0, 30.0]))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('speed of the shaft [rad/s]', 'frequency [rad/s]')
    """
    if not {"damped_frequency", "critical_speed", "speed"} <= set(data.variables):
        raise OptionError("data: give a result of structures.campbell")
    ax = new_axes() if ax is None else ax
    across, up = (_RPM, _HERTZ) if units == "rpm" else (1.0, 1.0)
    speeds = data["speed"].values * across
    curves = data["damped_frequency"].values * up
    if "direction" in data:
        senses = data["direction"].values
    else:
        senses = np.full(curves.shape, "none", dtype=object)
    top = _ROOM * float(np.nanmax(curves, initial=0.0)) or 1.0
    lines = {
        f"{harmonic:g}X": harmonic * data["speed"].values * up
        for harmonic in np.atleast_1d(data.attrs["harmonics"])
    }
    for line in lines.values():
        ax.plot(speeds, line, color="0.55", linewidth=0.7, zorder=1)
    for sense, style in SENSES.items():
        pieces = [_pieces(curve, senses[:, i] == sense) for i, curve in enumerate(curves.T)]
        # at rest alone, where motions go along lines, there is nothing to draw
        for i, piece in enumerate(each for each in pieces if np.isfinite(each).sum() > 1):
            ax.plot(speeds, piece, **style, label="" if i else _LABELS[sense])
    if data.sizes["critical"]:
        at = data["critical_speed"].values
        ax.plot(
            at * across, data["critical_harmonic"].values * at * up, linestyle="none", marker="o",
            markersize=4.0, markerfacecolor="white", markeredgecolor="black", markeredgewidth=0.8,
            label="critical speed", zorder=4,
        )  # fmt: skip
    ax.set(xlim=(speeds[0], speeds[-1]), ylim=(0.0, top))
    _name_lines(ax, speeds, lines, top)
    unit = ("rpm", "Hz") if units == "rpm" else ("rad/s", "rad/s")
    finish_axes(ax, f"speed of the shaft [{unit[0]}]", f"frequency [{unit[1]}]")
    if legend:
        place_legend(ax)
    return ax


def _pieces(curve: npt.NDArray[Any], here: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """The curve where a mode whirls in one sense, up to the next point on either side."""
    beside = here.copy()
    beside[:-1] |= here[1:]
    return np.where(beside, curve, np.nan)


def _name_lines(ax: Axes, speeds: Any, lines: Mapping[str, Any], top: float) -> None:
    """Name of each multiple of the speed beside the end of its line, or farther down where free."""
    size = float(ax.xaxis.label.get_fontsize()) - 1.0
    taken: list[npt.NDArray[np.float64]] = []
    for name, line in lines.items():
        end, place = _end_in_the_picture(speeds, line, top)
        begin = np.array([speeds[0], line[0]])
        room = np.array([0.8 * len(name), 1.3]) * size * ax.figure.dpi / 72.0  # of its letters
        for share in np.linspace(1.0, 0.3, _PLACES):
            point = begin + share * (end - begin)
            at = ax.transData.transform(point)
            if all((np.abs(at - other) > room).any() for other in taken):
                break
        taken.append(at)
        ax.annotate(
            name, point, textcoords="offset points", color="0.35", fontsize=size, **place
        )  # fmt: skip


def _end_in_the_picture(speeds: Any, line: Any, top: float) -> tuple[Any, dict[str, Any]]:
    """Where a line leaves the picture, and how a text lies beside it there."""
    inside = np.flatnonzero(line <= top)
    last = int(inside[-1]) if inside.size else 0
    if last + 1 == len(speeds):
        place = {"xytext": (-3.0, 3.0), "ha": "right", "va": "bottom"}
        return np.array([speeds[last], line[last]]), place
    share = (top - line[last]) / (line[last + 1] - line[last])
    x = float(speeds[last] + share * (speeds[last + 1] - speeds[last]))
    return np.array([x, top]), {"xytext": (3.0, -3.0), "ha": "left", "va": "top"}
