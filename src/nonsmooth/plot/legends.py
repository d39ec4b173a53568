"""The legend above the axes: it hides no curve, is not cut, and leaves the axes their room."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import accumulate, compress, groupby, pairwise
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

from nonsmooth.plot.style import text_width

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["place_legend", "with_former"]

# widths in letters: lines of the legend, from them to the texts, between columns
_HANDLE, _SPACE, _GAP = 2.0, 0.8, 1.2
_ROW = 1.35  # height of an entry, in letters
_TITLE = 1.9  # height of a title with its distance from the axes, over its letters
_LETTER = 0.55  # width of one, over their size
_SHARE, _MOST_SHARE = 0.36, 0.46  # of the height of the axes, for the legend; in small letters
_SMALLEST, _STEP = 5.5, 0.5  # letters in points
_BROAD = 3.0  # points from which a line is there for its colour only
_FREE_ROWS, _MOST_ROWS = 2, 12  # for which a figure is as high as without; that it grows for
_USUAL_ROWS = 6  # that it grows for before letters get smaller
_SEEN = {".": 5.0}  # diameters from which marks are seen in a legend, in points
_SEEN_ELSE = 3.0
_MINUS = re.compile(r"(?<!\S)-(?=[\d.∞])")  # before a number, where a word begins


class _Layout(NamedTuple):
    size: float  # of the letters, in points
    columns: list[int]  # entries in each one
    rows: int

    @property
    def shown(self) -> int:
        """How many entries there is room for; those after them are counted only."""
        return sum(self.columns)


def place_legend(
    ax: Axes | Figure, entries: Sequence[Artist] | None = None, *, may_grow: bool = False
) -> None:
    """Put the legend above the axes; nothing without entries.

    Letters are as large as those of the labels, or so much smaller that the legend takes a third
    of the height of the axes, a little more with the smallest ones. What has no room then is
    counted only. Entries of one sort (lines, broad lines that name colours, marks, areas) share a
    column, or have several of their own.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or matplotlib.figure.Figure
        The axes, with all that the legend explains; or a figure, for one legend above all its
        axes, in which each label stands once.
    entries : sequence of matplotlib.artist.Artist, optional
        What the legend shows with its label, in place of all that the axes have labels for.
    may_grow : bool, optional
        Whether the figure is made taller for a long legend: one of our own with single axes. Up
        to six rows keep the size of the letters.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> figure, (ax,) = ns.plot.print_figure()
    >>> line = ax.plot([0.0, 1.0], label="a line with a name")
    >>> ns.plot.place_legend(ax)
    >>> ax.get_legend().get_texts()[0].get_text()
    'a line with a name'
    """
    from matplotlib.patches import Patch

    own: Any = ax.axes  # those of a figure are a list
    panels: list[Axes] = own if isinstance(own, list) else [own]
    shown = _all_labelled(panels) if entries is None else list(entries)
    handles, labels = list(shown), [_typeset(str(entry.get_label())) for entry in shown]
    if not handles:
        return
    size = float(panels[0].xaxis.label.get_fontsize())  # the caller's may be larger than ours
    layout, labels = _layout(_room(ax), size, labels, _groups(handles), may_grow)
    if layout.shown < len(labels):
        labels = [*labels[: layout.shown - 1], f"and {len(labels) - layout.shown + 1} more"]
        handles = [*handles[: layout.shown - 1], Patch(alpha=0.0)]
    box = ax.legend(
        *_padded(handles, labels, layout), fontsize=layout.size, ncols=len(layout.columns),
        borderaxespad=0.2, borderpad=0.2, frameon=False, labelspacing=0.3, handlelength=_HANDLE,
        handletextpad=_SPACE, columnspacing=_GAP, **_place(ax),
    )  # fmt: skip
    there = [bool(text.get_text()) for text in box.texts]
    box.texts[:] = compress(box.texts, there)
    box.legend_handles[:] = compress(box.legend_handles, there)
    for handle in box.legend_handles:
        _let_see(handle)
    if may_grow:
        _grow(panels[0], layout)
    for panel in panels:  # the power of ten of the axis stands beside it, above its numbers
        panel.yaxis.get_offset_text().set_horizontalalignment("right")


def with_former(ax: Axes) -> list[Any]:
    """Entries for a legend: those that the axes have one for, and what is drawn with a label."""
    former, entries = ax.get_legend(), []
    if former is not None:
        for handle, text in zip(former.legend_handles, former.get_texts(), strict=True):
            if handle is not None:
                handle.set_label(text.get_text())
                entries.append(handle)
    known = {entry.get_label() for entry in entries}
    for handle in ax.get_legend_handles_labels()[0]:
        if handle.get_label() not in known:
            known.add(handle.get_label())
            entries.append(handle)
    return entries


def _typeset(label: str) -> str:
    """Label with the sign of negative numbers as long as along the axes."""
    return label if "$" in label else _MINUS.sub("\N{MINUS SIGN}", label)


def _all_labelled(panels: Sequence[Axes]) -> list[Any]:
    """What axes have labels for; of what several axes have in common, the first."""
    found: list[Any] = []
    for panel in panels:
        known = {entry.get_label() for entry in found}
        found += [h for h in panel.get_legend_handles_labels()[0] if h.get_label() not in known]
    return found


def _room(ax: Axes | Figure) -> tuple[float, float]:
    """Width and height of the axes, or of the figure, in points."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    box = ax.get_window_extent()
    return box.width / figure.dpi * 72.0, box.height / figure.dpi * 72.0


def _place(ax: Axes | Figure) -> dict[str, Any]:
    """Where the legend stands: above the axes and their title, or above all axes."""
    from matplotlib.figure import Figure
    from matplotlib.transforms import ScaledTranslation

    if isinstance(ax, Figure):
        return {"loc": "outside upper center"}
    figure = ax.get_figure(root=True)
    assert figure is not None
    above = ScaledTranslation(0.0, _title_height(ax) / 72.0, figure.dpi_scale_trans)
    return {
        "loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "bbox_transform": ax.transAxes + above,
    }  # fmt: skip


def _groups(handles: Sequence[Any]) -> list[int]:
    """How many entries of one sort follow each other: lines, broad lines, marks or areas."""
    sorts = [_sort(handle) for handle in handles]
    return [len(list(same)) for _, same in groupby(sorts)]


def _sort(handle: Any) -> str:
    from matplotlib.lines import Line2D

    if not isinstance(handle, Line2D):
        return "area"
    if handle.get_linestyle() == "None":
        return "marks"
    return "broad" if handle.get_linewidth() >= _BROAD else "line"


def _layout(
    room: tuple[float, float], size: float, labels: list[str], groups: list[int], may_grow: bool
) -> tuple[_Layout, list[str]]:
    """The largest letters with which all entries have room; texts too long for that wrapped."""
    width, height = room
    widths = [text_width(label) for label in labels]
    while True:
        last = size - _STEP < _SMALLEST
        share = _MOST_SHARE if last else _SHARE
        most = _USUAL_ROWS if may_grow else max(1, int(share * height / (_ROW * size)))
        columns = _columns(groups, widths, width / size)
        if max(columns) > most:  # without regard to what belongs together
            columns = _columns([len(labels)], widths, width / size)
        if max(columns) <= most or last:
            break
        size -= _STEP
    most = max(most, _MOST_ROWS * may_grow)
    if len(columns) == 1:
        letters = max(8, int((width / size - _HANDLE - _SPACE) / _LETTER))
        labels = [label if "$" in label else fill(label, letters) for label in labels]
        most = max(1, most // max(label.count("\n") + 1 for label in labels))
    columns = [min(count, most) for count in columns]
    return _Layout(size, columns, max(columns)), labels


def _columns(groups: list[int], widths: list[float], available: float) -> list[int]:
    """Entries of each column, in the fewest rows that fit. All lengths are in letters."""
    for rows in range(1, len(widths)):
        columns = _filled(groups, rows)
        first = [0, *accumulate(columns)]
        total = len(columns) * (_HANDLE + _SPACE + _GAP) - _GAP
        total += sum(max(widths[begin:end]) for begin, end in pairwise(first))
        if total <= available:
            return columns
    return [len(widths)]


def _filled(groups: list[int], rows: int) -> list[int]:
    """Columns of so many rows at most: a group begins a new one where the last has no room."""
    columns: list[int] = []
    for group in groups:
        if columns and columns[-1] + group <= rows:
            columns[-1] += group
            continue
        count = -(-group // rows)
        even, more = divmod(group, count)
        columns += [even + (k < more) for k in range(count)]
    return columns


def _padded(
    handles: Sequence[Any], labels: list[str], layout: _Layout
) -> tuple[list[Any], list[str]]:
    """Entries with blanks below short columns: matplotlib makes all columns alike."""
    from matplotlib.lines import Line2D

    entries = list(zip(handles, labels, strict=True))
    blank = (Line2D([], [], linestyle="none"), "")
    first = [0, *accumulate(layout.columns)]
    padded = [
        entry
        for begin, end in pairwise(first)
        for entry in (*entries[begin:end], *[blank] * (layout.rows - (end - begin)))
    ]
    return [handle for handle, _ in padded], [label for _, label in padded]


def _title_height(ax: Axes) -> float:
    """Height, in points, of the titles below the legend."""
    places: tuple[Any, ...] = ("left", "center", "right")
    size = float(ax.title.get_fontsize())
    return _TITLE * size * any(ax.get_title(loc=place) for place in places)


def _let_see(handle: Any) -> None:
    """Let the dots of a cloud be seen in the legend."""
    from matplotlib.lines import Line2D

    if isinstance(handle, Line2D) and handle.get_linestyle() == "None":
        least = _SEEN.get(str(handle.get_marker()), _SEEN_ELSE)
        handle.set_markersize(max(least, handle.get_markersize()))


def _grow(ax: Axes, layout: _Layout) -> None:
    """Make the figure so much taller that the legend does not squeeze the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    more = max(0, layout.rows - _FREE_ROWS) * _ROW * layout.size / 72.0
    figure.set_figheight(figure.get_figheight() + more)
