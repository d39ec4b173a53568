"""`transient_section`: points of a slowly changing motion, and which way new ones come."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.sections import checked_diameter, diameter_of
from nonsmooth.plot.style import axis_label, colour_bar, finish_axes, growing_colours
from nonsmooth.plot.trace import DENSE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["transient_section"]

Floats = npt.NDArray[np.float64]
_MOST_ARROWS = 24  # of one picture
_SMALLEST, _LARGEST = 1.2, 3.0  # diameter of points; their colour is to be seen

_LENGTH = 18.0  # points; a way that is shorter gets no arrow
_LEAST = 3.0  # points, of a way that has a direction
_BESIDE = 5.0  # points from the path
_CLEAR = 3.0  # points from other arrows


class _PeriodicPart(NamedTuple):
    """Points from ``first`` to ``last``, the last included, of one period."""

    first: int
    last: int
    period: int


@checked
def transient_section(
    points: xr.Dataset,
    x: str,
    y: str,
    *,
    labels: xr.Dataset | None = None,
    colour: str = "time",
    ax: Axes | None = None,
    arrows: bool = True,
    size: float | None = None,
    bar: bool = True,
) -> Axes:
    """Section of a motion that changes slowly: points in the colour of their time.

    With the labels of `local_regimes` arrows beside the points tell the way in which new ones
    come, one for each branch of each periodic stretch.

    Parameters
    ----------
    points : xarray.Dataset
        Result of `simulate` with one sample per period, or a section; a part of it by
        ``isel(time=slice(...))``.
    x, y : str
        States, outputs or coordinates.
    labels : xarray.Dataset, optional
        Result of `local_regimes` for these points, or for a longer run that they are part of.
    colour : str, optional
        Variable that gives the colour, such as ``crack``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    arrows : bool, optional
        Whether to draw arrows, with ``labels``.
    size : float, optional
        Diameter of a point in typographic points; by default smaller where there are
        more of them.
    bar : bool, optional
        Whether to draw the bar of colours.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one set of points, and an annotation per arrow.

    Raises
    ------
    OptionError
        For an unknown variable, variables over different points, or labels of another run.

    Notes
    -----
    A branch that is shorter than an arrow gets none, nor does one whose arrow would meet that of a
    longer branch, and of more than 24 those of the branches that move least are left out. Set
    limits of the axes before drawing, as arrows keep their distance from the points on paper.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> beam = ns.models.breathing_crack(growth="9 + 1e-3*t")
    >>> run = ns.simulate(beam, {"u": 0.0, "v": 0.1}, periods=400, samples_per_period=1)
    >>> labels = ns.local_regimes(run.isel(time=slice(100, None)), window=60)
    >>> ax = ns.plot.transient_section(run.isel(time=slice(100, None)), "u", "v", labels=labels)
    >>> int(labels["period"].max()), len(ax.texts)
    (1, 1)
    """
    if size is not None:
        checked_diameter(size)
    across, up, values = _columns(points, (x, y, colour))
    stretches = [] if labels is None else _stretches(points, labels)
    ax = new_axes() if ax is None else ax
    diameter = (
        float(np.clip(diameter_of(across, up), _SMALLEST, _LARGEST)) if size is None else size
    )
    drawn = ax.scatter(
        across,
        up,
        c=values,
        s=diameter**2,
        linewidths=0.0,
        cmap=growing_colours(),
        rasterized=across.size > DENSE,
    )
    finish_axes(ax, axis_label(points[x]), axis_label(points[y]))
    if bar:
        colour_bar(ax, drawn, axis_label(points[colour]))
    if arrows:
        _draw_arrows(ax, across, up, stretches)
    return ax


def _columns(points: xr.Dataset, names: tuple[str, ...]) -> list[Floats]:
    known = [str(v) for v in (*points.data_vars, *points.coords) if points[v].dtype.kind in "fiub"]
    for name in names:
        if name not in known:
            raise OptionError(unknown_name("variable", name, known))
    dims = {points[name].dims for name in names}
    if len(dims) > 1 or len(next(iter(dims))) != 1:
        raise OptionError(
            f"{', '.join(names)} are over {sorted(dims)}; draw variables over the same points, in"
            " one dimension"
        )
    if points[names[0]].size == 0:
        raise OptionError("there are no points to draw")
    return [points[name].values.astype(float) for name in names]


def _stretches(points: xr.Dataset, labels: xr.Dataset) -> list[_PeriodicPart]:
    """Periodic stretches by the numbers of the points drawn."""
    if "period" not in labels or labels["period"].ndim != 1:
        raise OptionError("labels: give a result of local_regimes")
    periods = labels["period"]
    if "time" in points.coords and "time" in labels.coords:
        times, known = points["time"].values, labels["time"].values
        place = np.clip(np.searchsorted(known, times), 0, known.size - 1)
        if times.size and not np.array_equal(known[place], times):
            raise OptionError(
                "labels: they have no label at some times of the points; give those of this run"
            )
        found = periods.values[place]
    elif periods.size == points.sizes[periods.dims[0]]:
        found = periods.values
    else:
        raise OptionError(
            f"labels: {periods.size} labels for {points.sizes[periods.dims[0]]} points; give those"
            " of these points"
        )
    first = np.flatnonzero(np.diff(found, prepend=-1))
    last = np.append(first[1:], found.size) - 1
    return [
        _PeriodicPart(int(a), int(b), int(found[a]))
        for a, b in zip(first, last, strict=True)
        if found[a] > 0
    ]


def _draw_arrows(ax: Axes, across: Floats, up: Floats, stretches: list[_PeriodicPart]) -> None:
    """An arrow per branch, for those that move most."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()  # gives the axes their final size and limits
    paths = []
    for one in stretches:
        for branch in range(one.period):
            chosen = slice(one.first + branch, one.last + 1, one.period)
            paths.append(np.column_stack([across[chosen], up[chosen]]))
    width, height = np.ptp(across) or 1.0, np.ptp(up) or 1.0
    way = [np.hypot(*((path[-1] - path[0]) / (width, height))) for path in paths]
    drawn: list[Floats] = []
    for k in np.argsort(way)[::-1][:_MOST_ARROWS]:
        draw_arrow(ax, paths[k], drawn)


def draw_arrow(ax: Axes, path: Floats, others: list[Floats]) -> None:
    """Arrow beside the middle of a path; none where the path is shorter, or another one is there.

    It lies outside of the bow of the path, and joins the others.

    shapes: path (K, 2), in units of the data; others (n, 2), points along arrows on paper
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    unit = 72.0 / figure.dpi
    seen = ax.transData.transform(path) * unit
    away = np.hypot(*(seen - seen[-1]).T)
    if len(path) < 2 or away.max() < _LENGTH:
        return
    # half way to the end; the beginning may wind where the motion settles
    k = int(np.flatnonzero(away >= 0.5 * away.max())[-1])
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(seen, axis=0).T))])
    first, middle, last = (
        np.array([np.interp(ways[k] + shift, ways, column) for column in seen.T])
        for shift in (-0.5 * _LENGTH, 0.0, 0.5 * _LENGTH)
    )
    along = last - first
    if np.hypot(*along) < _LEAST:  # it turns there
        along = seen[-1] - seen[0]
    along = along / np.hypot(*along)
    across = np.array([-along[1], along[0]])
    if across @ (middle - 0.5 * (seen[0] + seen[-1])) < 0.0:
        across = -across
    tail = middle + _BESIDE * across - 0.5 * _LENGTH * along
    tip = tail + _LENGTH * along
    arrow = np.linspace(tail, tip, int(_LENGTH))
    if any(np.hypot(*(arrow[:, None] - one).T).min() < _CLEAR for one in others):
        return
    others.append(arrow)
    back = ax.transData.inverted()
    start, end = (back.transform(place / unit) for place in (tail, tip))
    ax.annotate(
        "",
        xy=(float(end[0]), float(end[1])),
        xytext=(float(start[0]), float(start[1])),
        arrowprops={
            "arrowstyle": "-|>,head_length=0.35,head_width=0.16",
            "color": "black",
            "linewidth": 0.8,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
        annotation_clip=False,
        zorder=5,
    )
