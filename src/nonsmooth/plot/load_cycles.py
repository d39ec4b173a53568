"""`load_cycles`: what rainflow counting found, as a histogram or a matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import PALETTE, axis_label, colour_bar, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["load_cycles"]

_MOST_BINS = 10_000  # finer than any page

_WIDE = 30.0  # factor between bars from which on they are logarithmic


@checked
def load_cycles(
    cycles: xr.Dataset,
    *,
    ax: Axes | None = None,
    kind: str = "histogram",
    bins: int = 32,
    per_second: bool = False,
) -> Axes:
    """Cycles of a load by their range, or by range and mean.

    Parameters
    ----------
    cycles : xarray.Dataset
        Result of `fatigue.count_cycles`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    kind : {"histogram", "matrix"}, optional
        Bars over the range, or colours over mean and range, with a bar of colours.
    bins : int, optional
        Bins along each axis, even from zero to the largest range, and from the smallest mean to
        the largest.
    per_second : bool, optional
        Whether to divide by the duration of the record.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; counts that differ widely are logarithmic, and colours always.

    Raises
    ------
    OptionError
        For another dataset, one without cycles, or an unknown kind.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(2001) / 1000.0
    >>> load = 100 * np.sin(40 * np.pi * t) + 30 * np.sin(170 * np.pi * t)
    >>> _, (ax,) = ns.plot.print_figure()
    >>> ax = ns.plot.load_cycles(ns.fatigue.count_cycles(load, t), ax=ax, bins=10)
    >>> float(sum(bar.get_height() for bar in ax.patches))  # cycles in all, half ones included
    170.5
    """
    if "cycle" not in cycles.dims or "count" not in cycles:
        raise OptionError("the dataset has no cycles; give a result of fatigue.count_cycles")
    if cycles.sizes["cycle"] == 0:
        raise OptionError("no cycle was counted, so there is none to draw")
    if kind not in ("histogram", "matrix"):
        raise OptionError(f"kind = {quote(kind)}: draw 'histogram' or 'matrix'")
    if not 1 <= bins <= _MOST_BINS:
        raise OptionError(f"bins = {bins:g} must be a whole number from 1 to {_MOST_BINS}")
    ax = new_axes() if ax is None else ax
    weights = cycles["count"].values.astype(float)
    what = "cycles"
    if per_second:
        weights, what = weights / float(cycles.attrs["duration"]), "cycles per second"
    draw = _histogram if kind == "histogram" else _matrix
    draw(ax, cycles, weights, int(bins), what)
    return ax


def _histogram(ax: Axes, cycles: xr.Dataset, weights: np.ndarray, bins: int, what: str) -> None:
    size = cycles["range"].values
    edges = np.linspace(0.0, size.max(), bins + 1)
    counts, _ = np.histogram(size, edges, weights=weights)
    ax.bar(
        edges[:-1], counts, np.diff(edges), align="edge", color=PALETTE["blue"],
        edgecolor="white", linewidth=0.3,
    )  # fmt: skip
    least = float(counts[counts > 0.0].min())
    if counts.max() > _WIDE * least:
        ax.set_yscale("log")
        ax.set_ylim(0.5 * least, 2.0 * counts.max())
    ax.set_xlim(0.0, edges[-1])
    finish_axes(ax, axis_label(cycles["range"]), what)


def _matrix(ax: Axes, cycles: xr.Dataset, weights: np.ndarray, bins: int, what: str) -> None:
    from matplotlib.colors import LogNorm

    size, mean = cycles["range"].values, cycles["mean"].values
    low, high = float(mean.min()), float(mean.max())
    pad = 0.5 * float(size.max()) / bins if high == low else 0.0
    edges = np.linspace(low - pad, high + pad, bins + 1), np.linspace(0.0, size.max(), bins + 1)
    counts, _, _ = np.histogram2d(mean, size, edges, weights=weights)
    least = float(counts[counts > 0.0].min())
    most = max(float(counts.max()), least * 1.01)
    mesh = ax.pcolormesh(
        *edges, np.ma.masked_equal(counts.T, 0.0), cmap="viridis_r", norm=LogNorm(least, most),
        rasterized=True,
    )  # fmt: skip
    colour_bar(ax, mesh, what)
    finish_axes(ax, axis_label(cycles["mean"]), axis_label(cycles["range"]))
