"""`regime_map`: what motions settle to over two parameters."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import fill, wrap
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.period_colours import OTHER_REGIMES, by_period
from nonsmooth.plot.style import axis_label, colour_bar, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["regime_map"]

_ENDED = "ended early"  # for other reasons than those of the words below
_HATCHES = {
    _ENDED: "//////", "inadmissible": "......", "refused": "xxxxx", "interrupted": "-----"
}  # fmt: skip
_WHITE, _HATCHING = "#FFFFFF", "#666666"
_LINE, _BELOW = 1.25, 4.0  # of the legend: a line, and the labels below the axes; in letters
_SMALLEST = 5.5  # letters in points
_WIDEST = 32  # letters in a line of the legend
_DENSE = 10_000  # cells; more become an image within a PDF


Floats = npt.NDArray[np.float64]

_MOST_WORDS = 4  # of one period; rarer ones share a shade
_PALEST = 0.7  # part of white in the last shade

Mask = npt.NDArray[np.bool_]
_Part = tuple[str, str, Mask]  # name, colour, where


@checked
def regime_map(
    grid: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    words: bool = False,
    quantity: str | None = None,
) -> Axes:
    """Regimes over two parameters, one colour each, and one for each period up to eight.

    A longer period is darker; chaos is black, and blue has not settled.

    Parameters
    ----------
    grid : xarray.Dataset
        Result of `regime_map`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to name the colours beside the axes.
    words : bool, optional
        Whether to tell periodic motions apart by their words too, in shades of one colour.
    quantity : str, optional
        A variable of the map to draw in place of the regimes, such as ``"exponent"`` or
        ``"v_per_period"``; where it is nan nothing is drawn. A map with ``fill="motions"`` has it
        at every point.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one mesh of colours.

    Raises
    ------
    OptionError
        For a dataset that is no regime map, and for a quantity that it does not have.

    Notes
    -----
    Colours are the same in every picture, and only those that occur stand in the legend. Longer
    periods share one. Motions that ended early for other reasons than absorption, and what is
    missing, are white and hatched. Where some periodic motions of a system with drifting states
    stand and others progress, they have shades of their own. A map of more than 10000 points
    becomes an image within a PDF.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> grid = ns.regime_map(
    ...     ns.models.soft_impact(), {"omega": [0.78, 0.905], "zeta": [0.01, 0.05]}, transient=300
    ... )
    >>> ax = ns.plot.regime_map(grid)
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['period 1', 'period 2', 'chaotic']
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    if "regime" in grid and grid["regime"].size == 0:
        raise OptionError("the map has no cells to draw; give more values of both parameters")
    numbers, names, colours = _categories(grid, words)
    if quantity is not None:
        return draw_quantity(grid, quantity, new_axes() if ax is None else ax, legend)
    ax = new_axes() if ax is None else ax
    second, first = grid["regime"].dims
    x, y = grid[first].values, grid[second].values
    here = np.arange(len(names) + 1) - 0.5
    dense = numbers.size > _DENSE
    ax.pcolormesh(
        edges(x),
        edges(y),
        numbers,
        cmap=ListedColormap(colours),
        norm=BoundaryNorm(here, len(names)),
        rasterized=dense,
        linewidth=0.0,
    )
    for number, name in enumerate(names):
        if name in _HATCHES:
            _hatch(ax, edges(x), edges(y), numbers == number, name)
    finish_axes(ax, axis_label(grid[first]), axis_label(grid[second]))
    ax.set_xlim(*edges(x)[[0, -1]])
    ax.set_ylim(*edges(y)[[0, -1]])
    if legend:
        _name_colours(ax, names, colours)
    return ax


def _categories(grid: xr.Dataset, words: bool) -> tuple[np.ndarray, list[str], list[str]]:
    """Number of the category of each point, and names and colours of those that occur."""
    if "regime" not in grid or grid["regime"].ndim != 2:
        raise OptionError(
            "the dataset has no variable 'regime' over two parameters; give it a regime map"
        )
    labels = grid["regime"].attrs.get("flag_meanings", "").split()
    if not labels:
        raise OptionError(
            "the variable 'regime' has lost its attribute 'flag_meanings', the names of the labels;"
            " keep the attributes of the map"
        )
    variable = "period" if "period" in grid.data_vars else "period_of_motion"
    codes, periods = grid["regime"].values, grid[variable].values
    periodic = codes == labels.index("periodic")
    # in the order of the legend: periods, longer ones, the other labels
    order = [
        part for entry in by_period(periods, periodic) for part in shades(grid, *entry, words=words)
    ]
    others = np.select([codes == code for code in range(len(labels))], labels, "")
    ended = ~np.isin(others, ["periodic", *OTHER_REGIMES, *_HATCHES])
    order += [(word, colour, others == word) for word, colour in OTHER_REGIMES.items()]
    order.append((_ENDED, _WHITE, ended))
    order += [(word, _WHITE, others == word) for word in _HATCHES if word != _ENDED]
    present = [entry for entry in order if np.any(entry[2])]
    numbers = np.zeros(codes.shape, int)
    for number, (_, _, where) in enumerate(present):
        numbers[where] = number
    return numbers, [name for name, _, _ in present], [colour for _, colour, _ in present]


def _hatch(ax: Axes, x: np.ndarray, y: np.ndarray, where: np.ndarray, name: str) -> None:
    """Hatch some cells, of which the edges are given."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    i, j = np.nonzero(where)
    corners = [(x[j], y[i]), (x[j + 1], y[i]), (x[j + 1], y[i + 1]), (x[j], y[i + 1])]
    points = np.array([*corners, corners[0]]).transpose(2, 0, 1)  # cell, corner, coordinate
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    # one path for all cells: each by itself would be hatched anew
    ax.add_patch(
        PathPatch(
            Path(points.reshape(-1, 2), codes * len(points)), facecolor="none",
            edgecolor=_HATCHING, linewidth=0.0, hatch=_HATCHES[name],
            rasterized=where.size > _DENSE,
        )
    )  # fmt: skip


def _name_colours(ax: Axes, names: list[str], colours: list[str]) -> None:
    """Legend beside the axes, where it hides nothing; of many entries with smaller letters."""
    from matplotlib.patches import Patch

    figure = ax.get_figure(root=True)
    assert figure is not None
    handles = [
        Patch(
            facecolor=colour, edgecolor=_HATCHING if name in _HATCHES else "black", linewidth=0.4,
            label=fill(name, _WIDEST), hatch=_HATCHES.get(name),
        )
        for name, colour in zip(names, colours, strict=True)
    ]  # fmt: skip
    place = ax.get_subplotspec()
    rows = 1 if place is None else place.get_gridspec().nrows
    height = figure.get_figheight() * 72.0 / rows
    lines = sum(len(wrap(name, _WIDEST)) for name in names)
    fitting = height / (_LINE * lines + _BELOW)
    size = max(_SMALLEST, min(float(ax.xaxis.label.get_fontsize()), fitting))
    ax.legend(
        handles=handles,
        fontsize=size,
        loc="upper left",
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.0,
        frameon=False,
        labelspacing=_LINE - 1.0,
        handlelength=1.2,
        handleheight=0.8,
        handletextpad=0.5,
    )


def draw_quantity(grid: xr.Dataset, quantity: str, ax: Axes, legend: bool) -> Axes:
    """Draw a variable of a regime map; infinite values and nan are left white."""
    known = [
        name
        for name, each in grid.data_vars.items()
        if each.dims == grid["regime"].dims and each.dtype.kind in "fiu"
    ]
    if quantity not in known:
        raise OptionError(f"quantity: {unknown_name('quantity', quantity, map(str, known))}")
    second, first = grid["regime"].dims
    x, y = edges(grid[first].values), edges(grid[second].values)
    values = np.ma.masked_invalid(grid[quantity].values.astype(float))
    if values.count() == 0:
        raise OptionError(f"quantity = {quantity!r} has no finite value in this map")
    mesh = ax.pcolormesh(
        x, y, values, cmap="cividis", rasterized=values.size > _DENSE, linewidth=0.0
    )
    finish_axes(ax, axis_label(grid[first]), axis_label(grid[second]))
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    if legend:
        colour_bar(ax, mesh, axis_label(grid[quantity]))
    return ax


def edges(values: Floats) -> Floats:
    """Borders of the cells around values; of a width of one around a single value."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def shades(grid: xr.Dataset, name: str, colour: str, where: Mask, *, words: bool) -> list[_Part]:
    """Parts of an area of one colour, each with its name and a shade of the colour.

    An area is parted where some of its motions progress and others stand, and with ``words`` by
    the modes that they pass.
    """
    parts = list(_by_progress(grid, name, where))
    if words:
        parts = [part for one in parts for part in _by_word(grid, *one)]
    step = _PALEST / max(1, len(parts) - 1)
    return [(each, _paler(colour, i * step), place) for i, (each, place) in enumerate(parts)]


def _by_progress(grid: xr.Dataset, name: str, where: Mask) -> Iterator[tuple[str, Mask]]:
    variable = "progresses" if "progresses" in grid.data_vars else "progresses_of_motion"
    if variable not in grid.data_vars:
        yield name, where
        return
    periodic = grid["regime"].attrs["flag_meanings"].split().index("periodic")
    progresses = grid[variable].values > 0
    if np.unique(progresses[grid["regime"].values == periodic]).size < 2:
        yield name, where
        return
    yield f"{name}, progresses", where & progresses
    yield f"{name}, stands", where & ~progresses


def _by_word(grid: xr.Dataset, name: str, where: Mask) -> Iterator[tuple[str, Mask]]:
    """The words that most points have, each by itself."""
    variable = "word" if "word" in grid.data_vars else "word_of_motion"
    found = np.array([_turned(word) for word in grid[variable].values.ravel()])
    found = found.reshape(where.shape)
    present, counts = np.unique(found[where], return_counts=True)
    chosen = present[np.argsort(-counts, kind="stable")]
    rest = where & np.isin(found, chosen[_MOST_WORDS:])
    for word in chosen[:_MOST_WORDS]:
        yield f"{name}: {word}", where & (found == word)
    if np.any(rest):
        yield f"{name}: other words", rest


def _turned(word: str) -> str:
    """A word that begins with the first of its turns in alphabetical order.

    A strobe may lie on an event, or be moved across one by a parameter; the motion is the same.
    """
    modes = word.split()
    closes = len(modes) > 1 and modes[0] == modes[-1]
    modes = modes[:-1] if closes else modes
    return " ".join(min((modes[k:] + modes[:k] for k in range(len(modes))), default=modes))


def _paler(colour: str, white: float) -> str:
    """A colour mixed with white."""
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(part + (255 - part) * white):02X}" for part in parts)
