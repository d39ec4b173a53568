"""`campbell`: natural frequencies over the speed of a shaft, with its critical speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
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

Floats = npt.NDArray[np.float64]

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
_WELL_DAMPED = 0.2  # an amplification factor of 2.5, below which peaks are low
_RPM, _HERTZ = 30.0 / math.pi, 0.5 / math.pi
_ROOM = 1.12  # above the highest curve
_PLACES = 29  # along a line at which its name may stand
_BESIDE, _CLEAR = 3.0, 2.0  # points from the line, and from others
_FINE = 800  # points of a curve
_NEVER = 1e6  # of its points: what a place outside of the picture, or on another name, counts


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
        nodes move on lines; circles are critical speeds, pale where the damping ratio is above 0.2
        and the amplification factor below 2.5; thin lines are the speed and its multiples.

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
    highest = _ROOM * float(np.nanmax(curves, initial=0.0))
    top = highest or float(speeds[-1]) * up / across or 1.0  # where no mode oscillates
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
        height = data["critical_harmonic"].values * at * up
        damped = data["critical_damping_ratio"].values > _WELL_DAMPED
        for here, edge, label in (
            (~damped, "black", "critical speed"),
            (damped, "0.6", f"critical, damping ratio above {_WELL_DAMPED:g}"),
        ):
            if here.any():
                ax.plot(
                    at[here] * across, height[here], linestyle="none", marker="o", markersize=4.0,
                    markerfacecolor="white", markeredgecolor=edge, markeredgewidth=0.8,
                    label=label, zorder=4,
                )  # fmt: skip
    ax.set(xlim=(speeds[0], speeds[-1]), ylim=(0.0, top))
    if not highest:
        ax.text(0.95, 0.05, "no mode oscillates", transform=ax.transAxes, ha="right", va="bottom")
    unit = ("rpm", "Hz") if units == "rpm" else ("rad/s", "rad/s")
    finish_axes(ax, f"speed of the shaft [{unit[0]}]", f"frequency [{unit[1]}]")
    if legend:
        place_legend(ax)
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()  # the layout gives the axes their size, and letters have theirs
    _name_lines(ax, speeds, lines, list(curves.T))
    return ax


def _pieces(curve: npt.NDArray[Any], here: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """The curve where a mode whirls in one sense, up to the next point on either side."""
    beside = here.copy()
    beside[:-1] |= here[1:]
    return np.where(beside, curve, np.nan)


def _name_lines(
    ax: Axes, speeds: Floats, lines: Mapping[str, Floats], curves: Sequence[Floats]
) -> None:
    """Name of each multiple of the speed beside its line, near its end, where nothing is drawn."""
    size = float(ax.xaxis.label.get_fontsize()) - 1.0
    dot = ax.figure.dpi / 72.0  # pixels of a point
    drawn = np.concatenate([_pixels(ax, speeds, each) for each in (*curves, *lines.values())])
    inside = ax.transAxes.transform([[0.0, 0.0], [1.0, 1.0]])
    taken: list[Floats] = []
    for name, line in lines.items():
        begin, end = _ends_in_the_picture(ax, speeds, line)
        room = dot * size * np.array([0.75 * len(name), 1.25])  # of its letters
        best: tuple[float, Any, Any, Any] | None = None
        for share, side in product(np.linspace(1.0, 0.3, _PLACES), (-1.0, 1.0)):
            point = begin + share * (end - begin)
            near = point + side * dot * _BESIDE * np.array([1.0, -1.0])
            corner = near + side * room * np.array([1.0, -1.0])
            box = np.sort([near, corner], axis=0)
            hits = float(_within(drawn, box, dot * _CLEAR).sum())
            out = (box[0] < inside[0]).any() or (box[1] > inside[1]).any()
            over = any(((box[0] < other[1]) & (box[1] > other[0])).all() for other in taken)
            cost = hits + _NEVER * (float(out) + float(over))
            if best is None or cost < best[0]:
                best = cost, point, box, side
            if not cost:
                break
        assert best is not None
        _, point, box, side = best
        taken.append(box)
        ax.annotate(
            name, tuple(ax.transData.inverted().transform(point)), textcoords="offset points",
            xytext=(side * _BESIDE, -side * _BESIDE), ha="left" if side > 0.0 else "right",
            va="top" if side > 0.0 else "bottom", color="0.35", fontsize=size,
        )  # fmt: skip


def _pixels(ax: Axes, speeds: Floats, curve: Floats) -> Floats:
    """Points of a curve on the picture, close to each other."""
    at = np.linspace(0.0, len(speeds) - 1.0, _FINE)
    index = np.arange(len(speeds))
    found = ax.transData.transform(
        np.column_stack([np.interp(at, index, speeds), np.interp(at, index, curve)])
    )
    return np.asarray(found[np.isfinite(found).all(axis=1)])


def _within(points: Floats, box: Floats, margin: float) -> npt.NDArray[np.bool_]:
    """Which points lie in a box, or near it."""
    return np.asarray(((points > box[0] - margin) & (points < box[1] + margin)).all(axis=1))


def _ends_in_the_picture(ax: Axes, speeds: Floats, line: Floats) -> tuple[Floats, Floats]:
    """Where a line begins and where it leaves the picture, in pixels."""
    top = ax.get_ylim()[1]
    last = float(min(speeds[-1], np.interp(top, line, speeds)))
    ends = [[speeds[0], line[0]], [last, np.interp(last, speeds, line)]]
    begin, end = ax.transData.transform(ends)
    return begin, end
