"""Basins of attraction as colours of cells, and attractors as points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.attractor_style import (
    ENDED_EARLY,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    AttractorStyle,
    attractor_entry,
    attractor_points,
    attractor_styles,
    check_states,
    draw_attractors,
    percent,
    state_label,
    styles_by_period,
)
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.period_colours import NOT_SETTLED
from nonsmooth.plot.style import finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["attractors", "basins"]

_OTHERS = {
    0: (UNSETTLED, "unsettled"),
    -1: (ENDED_EARLY, "ended early"),
    -2: (INADMISSIBLE, "inadmissible"),
    -3: (NOT_COMPUTED, "not computed"),
}
Points = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]

_COLOURS = ("attractor", "period")
_EVEN = 1e-6  # of a step, between cells that count as equally wide


_MOST_BORDERS = 0.5  # lines beside cells, up to which they are drawn within a colour


@checked
def basins(
    data: xr.Dataset,
    *,
    ax: Axes | None = None,
    attractors: bool = True,
    colour: str = "attractor",
    legend: bool = True,
) -> Axes:
    """Basins of attraction in pale colours, the attractors in them in dark ones.

    The legend says of which attractors points lie outside the picture.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `basins_of_attraction`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    attractors : bool, optional
        Whether to draw the points of the attractors. Their markers tell periods apart: circles
        are of period one, squares of period two; dots are motion without a period.
    colour : {"attractor", "period"}, optional
        What the colours tell: attractors, each in its own hue, or their periods, in the colours of
        `regime_map`. Attractors of one period have one colour then.
    legend : bool, optional
        Whether to draw a legend with the kind of each attractor and the fraction of the starts
        that lead to it.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one image. Unsettled starts are white, or blue beside colours of periods;
        those that ended early dark grey, inadmissible ones light grey, those that an interruption
        left out grey.

    Raises
    ------
    OptionError
        For a dataset without labels in two dimensions.

    Notes
    -----
    Cells are an image also within a PDF. Seven hues serve as many attractors, and further ones in
    other shades; from the twenty-second on colours repeat.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> label = np.where(np.arange(20) < 8, 1, 2) * np.ones((10, 1), int)
    >>> data = xr.Dataset(
    ...     {"label": (("y", "p"), label)}, {"p": np.arange(20.0), "y": np.arange(10.0)}
    ... )
    >>> ax = ns.plot.basins(data)
    >>> ax.get_xlabel(), [text.get_text() for text in ax.get_legend().get_texts()]
    ('p', ['1: 40.0 %', '2: 60.0 %'])
    """
    if "label" not in data or data["label"].ndim != 2:
        raise OptionError(
            "the dataset has no 'label' over two states; give a result of basins_of_attraction"
        )
    if colour not in _COLOURS:
        raise OptionError(f"colour: {unknown_name('choice', colour, _COLOURS)}")
    if data["label"].size == 0:
        raise OptionError("the dataset has no cells to draw; give more values of both states")
    up, across = (str(name) for name in data["label"].dims)
    labels = data["label"].values.astype(int)
    data = _with_fractions(data, labels)
    numbers = sorted({int(k) for k in np.unique(labels) if k > 0} | _known(data))
    styles = attractor_styles(data, numbers)
    others = dict(_OTHERS)
    if colour == "period":
        styles, others[0] = styles_by_period(data, styles), (NOT_SETTLED, others[0][1])
    points = {number: attractor_points(data, number, across, up) for number in numbers}
    borders = _edges(data, across), _edges(data, up)
    if attractors:
        styles = {k: _telling_outside(style, points[k], borders) for k, style in styles.items()}
    entries = _entries(styles, others, labels) if legend else []
    own = ax is None
    ax = new_axes() if ax is None else ax
    colours = {k: shade for k, (shade, _) in others.items()}
    colours |= {number: style.basin for number, style in styles.items()}
    _draw_cells(ax, labels, colours, *borders)
    if attractors:
        draw_attractors(ax, points, styles)
    finish_axes(ax, state_label(data, across), state_label(data, up))
    place_legend(ax, entries, may_grow=own)
    return ax


def _known(data: xr.Dataset) -> set[int]:
    """Attractors of the dataset, also those to which no start leads."""
    return {int(k) for k in data["attractor"].values} if "attractor" in data.coords else set()


def _with_fractions(data: xr.Dataset, labels: npt.NDArray[np.int_]) -> xr.Dataset:
    """The same with the fraction of the admissible cells, where the dataset has none."""
    if "fraction" in data:
        return data
    numbers = sorted({int(k) for k in np.unique(labels) if k > 0} | _known(data))
    total = max(1, int(np.count_nonzero(labels > -2)))
    share = np.array([np.count_nonzero(labels == k) for k in numbers]) / total
    if _known(data) != set(numbers):  # labels of unknown attractors have no points either
        data = data[["label"]].drop_vars("attractor", errors="ignore")
        data = data.assign_coords(attractor=numbers)
    share = share[[numbers.index(int(k)) for k in data["attractor"].values]]
    return data.assign(fraction=("attractor", share))


def _draw_cells(
    ax: Axes,
    labels: npt.NDArray[np.int_],
    colours: dict[int, str],
    across: npt.NDArray[np.float64],
    up: npt.NDArray[np.float64],
) -> None:
    from matplotlib.colors import ListedColormap

    order = sorted(set(colours) | {int(k) for k in np.unique(labels)})
    places = np.searchsorted(order, labels)
    # labels that mean nothing to us look like unsettled ones
    kinds: Any = {
        "cmap": ListedColormap([colours.get(k, UNSETTLED) for k in order]),
        "vmin": -0.5,
        "vmax": len(order) - 0.5,
        "rasterized": True,
    }
    if _even(across) and _even(up):
        extent = (across[0], across[-1], up[0], up[-1])
        ax.imshow(
            places, origin="lower", extent=extent, aspect="auto", interpolation="nearest", **kinds
        )
    else:
        ax.pcolormesh(across, up, places, **kinds)
    _draw_hidden_borders(ax, labels, [colours.get(k, UNSETTLED) for k in order], places, across, up)
    ax.set_xlim(across[0], across[-1])
    ax.set_ylim(up[0], up[-1])
    ax.autoscale(False)  # attractors outside the region stay outside the picture


def _draw_hidden_borders(
    ax: Axes,
    labels: npt.NDArray[np.int_],
    colour_of: list[str],
    places: npt.NDArray[np.int_],
    across: npt.NDArray[np.float64],
    up: npt.NDArray[np.float64],
) -> None:
    """Lines where two basins of one colour meet, which would look like one basin.

    Not where borders are nearly everywhere, as those of fractal basins: lines would hide the cells.
    """
    from matplotlib.collections import LineCollection

    same = np.unique(colour_of, return_inverse=True)[1][places]
    right = np.argwhere((labels[:, 1:] != labels[:, :-1]) & (same[:, 1:] == same[:, :-1]))
    above = np.argwhere((labels[1:] != labels[:-1]) & (same[1:] == same[:-1]))
    i, j = right.T
    upright = np.stack([across[j + 1], up[i], across[j + 1], up[i + 1]], axis=1)
    i, j = above.T
    level = np.stack([across[j], up[i + 1], across[j + 1], up[i + 1]], axis=1)
    pieces = np.concatenate([upright, level]).reshape(-1, 2, 2)
    if 0 < len(pieces) <= _MOST_BORDERS * labels.size:
        lines = LineCollection(list(pieces), colors="black", linewidths=0.5, capstyle="round")
        lines.set_rasterized(True)
        lines.set_gid("borders within a colour")
        ax.add_collection(lines, autolim=False)


def _edges(data: xr.Dataset, name: str) -> npt.NDArray[np.float64]:
    """Edges of the cells around the grid values."""
    if name in data.coords:
        values = np.asarray(data[name].values, float)
    else:
        values = np.arange(data.sizes[name], dtype=float)
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[1:] + values[:-1]) / 2.0
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _even(edges: npt.NDArray[np.float64]) -> bool:
    steps = np.diff(edges)
    return bool(np.ptp(steps) <= _EVEN * abs(steps.mean()))


def _telling_outside(style: AttractorStyle, points: Points, borders: Points) -> AttractorStyle:
    """Style of an attractor whose text says if points of it are outside the picture."""
    inside = np.ones(len(points[0]), bool)
    for values, edges in zip(points, borders, strict=True):
        inside &= (values >= edges[0]) & (values <= edges[-1])
    if inside.all():
        return style
    return style._replace(text=f"{style.text}, {'partly ' if inside.any() else ''}outside")


def _entries(
    styles: dict[int, AttractorStyle],
    others: dict[int, tuple[str, str]],
    labels: npt.NDArray[np.int_],
) -> list[Any]:
    """Entries of the key: attractors with their basins, then what is no basin."""
    from matplotlib.patches import Patch

    entries: list[Any] = [attractor_entry(style, basin=True) for style in styles.values()]
    for k, (colour, text) in others.items():
        count = int(np.count_nonzero(labels == k))
        if count and k > -2:
            text += f", {percent(count / np.count_nonzero(labels > -2))}"
        if count:
            entries.append(Patch(facecolor=colour, edgecolor="0.4", linewidth=0.5, label=text))
    return entries


@checked
def attractors(
    data: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Points of attractors: one state over another.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `attractors` or of `basins_of_attraction`.
    x, y : str, optional
        States to draw; by default the first two that do not drift.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend with the kind of each attractor and the fraction of the starts
        that lead to it.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one set of points per attractor, in the colours of `nonsmooth.plot.basins`.
        Circles are of period one, squares of period two; dots are motion without a period.

    Raises
    ------
    OptionError
        For an unknown state, or a dataset without attractors.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> data = xr.Dataset(
    ...     {
    ...         "points": (("attractor", "point", "state"), [[[0.0, 1.0], [1.0, 0.0]]]),
    ...         "period": ("attractor", [2]),
    ...     },
    ...     {"attractor": [1], "state": ["p", "y"]},
    ... )
    >>> ax = ns.plot.attractors(data)
    >>> ax.get_xlabel(), ax.get_ylabel(), ax.lines[0].get_label()
    ('p', 'y', '1: period 2')
    """
    across, up = check_states(data, x, y)
    numbers = [int(k) for k in data["attractor"].values]
    styles = attractor_styles(data, numbers)
    entries = [attractor_entry(style, basin=False) for style in styles.values()] if legend else []
    own = ax is None
    ax = new_axes() if ax is None else ax
    points = {number: attractor_points(data, number, across, up) for number in numbers}
    draw_attractors(ax, points, styles)
    finish_axes(ax, state_label(data, across), state_label(data, up))
    place_legend(ax, entries, may_grow=own)
    return ax
