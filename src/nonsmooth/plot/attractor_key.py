"""The legend of pictures with attractors: many entries, above the axes, in small letters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.plot.attractor_style import AttractorStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

__all__ = ["attractor_entry", "make_room", "place_key"]

_MOST_ROWS = 12
_FREE_ROWS = 2  # for which a picture need not be taller
_ROW = 1.3  # of the size of the letters
_HANDLE, _SPACE, _GAP, _LETTER = 1.6, 0.8, 1.0, 0.48  # widths, in the size of the letters
_SMALL = 7 / 8  # of the labels of the axes


def attractor_entry(style: AttractorStyle, *, basin: bool) -> Artist:
    """Marker of an attractor, before the colour of its basin where that is shown."""
    from matplotlib.lines import Line2D

    dots = style.marker == "."
    return Line2D(
        [],
        [],
        linestyle="-" if basin else "none",
        linewidth=6.0,
        solid_capstyle="butt",
        color=style.basin,
        marker="o" if dots else style.marker,
        markersize=2.6 if dots else style.size,
        markerfacecolor=style.points,
        markeredgecolor=style.points if dots else "white",
        markeredgewidth=0.0 if dots else 0.5,
        label=style.text,
    )


def make_room(ax: Axes, entries: list[Artist]) -> None:
    """Make a figure of our own so much taller that the key does not squeeze the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    rows = min(_MOST_ROWS, -(-len(entries) // _columns(ax, entries))) - _FREE_ROWS
    figure.set_figheight(figure.get_figheight() + max(0, rows) * _ROW * _size(ax) / 72.0)


def place_key(ax: Axes, entries: list[Artist]) -> None:
    """Put the key above the axes; of more entries than rows hold, the last are counted only."""
    from matplotlib.patches import Patch

    if not entries:
        return
    columns = _columns(ax, entries)
    if len(entries) > columns * _MOST_ROWS:
        kept = columns * _MOST_ROWS - 1
        rest = Patch(alpha=0.0, label=f"and {len(entries) - kept} more")
        entries = [*entries[:kept], rest]
    ax.legend(
        handles=entries,
        fontsize=_size(ax),
        ncols=columns,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.2,
        borderpad=0.2,
        frameon=False,
        labelspacing=0.3,
        handlelength=_HANDLE,
        handletextpad=_SPACE,
        columnspacing=_GAP,
    )


def _size(ax: Axes) -> float:
    return _SMALL * float(ax.xaxis.label.get_fontsize())


def _columns(ax: Axes, entries: list[Artist]) -> int:
    """Columns that fit the width of the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    available = ax.get_window_extent().width / figure.dpi * 72.0  # points
    letters = max((len(str(entry.get_label())) for entry in entries), default=1)
    width = _size(ax) * (_HANDLE + _SPACE + _LETTER * letters + _GAP)
    return max(1, min(len(entries), int((available + _size(ax) * _GAP) / width)))
