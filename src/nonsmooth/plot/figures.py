"""Figures in print size with legible texts, and saving them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.files import check_target, replacing
from nonsmooth.plot.style import PALETTE
from nonsmooth.runs.options import whole_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FIGURE_STYLE", "divided", "new_axes", "print_figure", "save_figure", "set_ticks"]

_CENTIMETRES = 1.0 / 2.54  # in inches
_COARSEST, _FINEST = 10, 4800  # dots per inch
_SIDES = 0.5, 500.0  # in cm: of an icon, and of a banner
_MOST_AXES = 100  # in a row, and below each other
_MOST_DOTS = 2**16 - 1  # along a side of an image
_TEXT, _SMALL = 8.0, 7.0  # points; journals ask for at least 6 to 7 after reduction
# of curves that a caller draws: told apart with every kind of colour vision; yellow is faint
_COLOURS = [colour for name, colour in PALETTE.items() if name != "yellow"]
FIGURE_STYLE: Any = {
    "axes.prop_cycle": f"cycler('color', {_COLOURS})",
    "font.size": _TEXT,
    "axes.labelsize": _TEXT,
    "axes.titlesize": _TEXT,
    "axes.linewidth": 0.6,
    "figure.dpi": 200.0,
    "legend.fontsize": _SMALL,
}


@checked
def print_figure(
    rows: int = 1,
    columns: int = 1,
    *,
    width: float = 8.0,
    height: float | None = None,
    share_x: bool = False,
) -> tuple[Figure, list[Axes]]:
    """Figure for print with its axes, 8 cm wide as one column of a journal.

    It is not shown on the screen; save it with `save_figure`.

    Parameters
    ----------
    rows, columns : int
        Grid of axes.
    width : float, optional
        Width in centimetres.
    height : float, optional
        Height in centimetres; four to three for each of the axes by default.
    share_x : bool, optional
        Whether all axes have one range in x.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    axes : list of matplotlib.axes.Axes
        Its axes, row by row.

    Raises
    ------
    OptionError
        For more than 100 rows or columns, or sides that are not from 0.5 to 500 cm.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> figure, axes = ns.plot.print_figure(3, 2, width=16.0)
    >>> len(axes)
    6
    """
    import matplotlib
    from matplotlib.figure import Figure

    rows, columns = (
        _checked_count(name, count) for name, count in (("rows", rows), ("columns", columns))
    )
    _check_side("width", width)
    if height is None:
        height = 0.75 * width * rows / columns
    _check_side("height", height)
    size = (width * _CENTIMETRES, height * _CENTIMETRES)
    with matplotlib.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False, sharex=share_x)
    axes = list(grid.flat)
    for ax in axes:
        set_ticks(ax)
    return figure, axes


def _checked_count(name: str, value: int) -> int:
    count = whole_number(name, value)
    if count > _MOST_AXES:
        raise OptionError(
            f"{name} = {count}: axes would have no room; give at most {_MOST_AXES}, or make"
            " several figures"
        )
    return count


def _check_side(name: str, value: float) -> None:
    least, most = _SIDES
    if not least <= value <= most:
        raise OptionError(f"{name} = {value:g} must be from {least:g} to {most:g}, in cm")


def new_axes(projection: str | None = None, *, width: float = 8.0, height: float = 6.0) -> Any:
    """Axes of a figure that pyplot knows, so that ``plt.show()`` finds it."""
    import matplotlib
    import matplotlib.pyplot as plt

    with matplotlib.rc_context(FIGURE_STYLE):
        size = (width * _CENTIMETRES, height * _CENTIMETRES)
        how = {"projection": projection}
        _, ax = plt.subplots(figsize=size, layout="constrained", subplot_kw=how)
    set_ticks(ax)
    return ax


def divided(
    ax: Axes, rows: int, columns: int = 1, *, heights: Sequence[float] | None = None
) -> list[Axes]:
    """Axes in the place of others, row by row; the first are those others, made smaller."""
    place, figure = ax.get_subplotspec(), ax.get_figure(root=True)
    if place is None or figure is None:
        raise OptionError(
            "ax: give axes of a grid, as plot.print_figure and plt.subplots make them"
        )
    parts = place.subgridspec(rows, columns, height_ratios=heights)
    size = float(ax.xaxis.label.get_fontsize())
    ax.set_subplotspec(parts[0, 0])
    panels = [ax]
    for k in range(1, rows * columns):
        panel = figure.add_subplot(parts[divmod(k, columns)])
        for axis in (panel.xaxis, panel.yaxis):
            axis.label.set_fontsize(size)
        for side in panel.spines.values():
            side.set_linewidth(0.6)
        set_ticks(panel)
        panel.tick_params(labelsize=size - 1.0)
        panels.append(panel)
    return panels


def set_ticks(ax: Axes) -> None:
    """Set the ticks of axes of a figure for print."""
    # matplotlib makes ticks when it draws, long after the style's context was left
    ax.tick_params(labelsize=_SMALL, width=0.6, length=2.5)
    if ax.name == "rectilinear":
        from nonsmooth.plot.ticks import set_numbers

        set_numbers(ax)


@checked
def save_figure(figure: Figure, path: str | Path, *, dpi: float = 300.0) -> Path:
    """Write a figure to a PNG, PDF or SVG file, whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : str or pathlib.Path
        File to write, in a folder that exists; its suffix says the format: ``.png``, ``.pdf`` or
        ``.svg``.
    dpi : float, optional
        Dots per inch of a PNG, and of what the other formats hold as an image.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    OptionError
        For another suffix, a folder that does not exist, or an image of too many dots.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> figure, axes = ns.plot.print_figure()
    >>> ns.plot.save_figure(figure, "figure.gif")
    Traceback (most recent call last):
    nonsmooth.errors.OptionError: 'figure.gif' ends with '.gif'; ...
    """
    import matplotlib

    if not _COARSEST <= dpi <= _FINEST:
        raise OptionError(
            f"dpi = {dpi:g} must be from {_COARSEST}, below which texts cannot be drawn, to"
            f" {_FINEST}, beyond what any press resolves"
        )
    target = check_target(path, (".png", ".pdf", ".svg"))
    kind = target.suffix.lower()[1:]
    longest = max(figure.get_size_inches())
    if kind == "png" and longest * dpi > _MOST_DOTS:
        raise OptionError(
            f"dpi = {dpi:g}: the figure is {longest / _CENTIMETRES:.4g} cm long, which are"
            f" {longest * dpi:.0f} dots; an image has at most {_MOST_DOTS}, so give dpi ="
            f" {int(_MOST_DOTS / longest)} or less, or write a .pdf"
        )
    # without its date the same figure gives the same file
    metadata = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind, {})
    # in pieces of this many points a long line is drawn three times as fast
    pieces: Any = {"agg.path.chunksize": 10_000, "svg.hashsalt": "nonsmooth"}
    with replacing(target) as draft, matplotlib.rc_context(pieces):
        figure.savefig(draft, format=kind, dpi=dpi, metadata=metadata)
    return target
