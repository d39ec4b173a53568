"""The graph of a return map in the colours of what happens on the way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.map_graph import curves, draw_diagonal, finish_map, of_motion, require_map
from nonsmooth.plot.style import PALETTE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["return_map"]

_COLOURS = [colour for name, colour in PALETTE.items() if name != "yellow"]  # faint as a line
_DASHES = ("-", "--", ":", "-.")
_LONGEST = 44  # letters of a label


def return_map(
    data: xr.Dataset,
    *,
    ax: Axes | None = None,
    diagonal: bool = True,
    borders: bool = True,
    legend: bool = True,
) -> Axes:
    """Graph of a return map, its pieces coloured by the exits passed on the way.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `return_map`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    diagonal : bool, optional
        Whether to draw the line on which images are the starts.
    borders : bool, optional
        Whether to mark jumps, corners and roots by dotted lines.
    legend : bool, optional
        Whether to name the exits in a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For another dataset.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> points = ns.poincare_section(ns.models.moling(), section="impact", record=30)
    >>> mole = ns.PoincareMap(ns.models.moling(), "impact")
    >>> ax = ns.plot.return_map(ns.return_map(mole, "phase", points=points))
    >>> len(ax.lines) > 1
    True
    """
    require_map(data)
    ax = new_axes() if ax is None else ax
    image = data["image"].values
    there = np.isfinite(image)
    texts = list(dict.fromkeys(data["exits"].values[there].tolist()))
    colours = {text: _COLOURS[i % len(_COLOURS)] for i, text in enumerate(texts)}
    dashes = {text: _DASHES[i // len(_COLOURS) % len(_DASHES)] for i, text in enumerate(texts)}
    if of_motion(data):
        for text in texts:
            here = there & (data["exits"].values == text)
            ax.plot(
                data["start"].values[here], image[here], linestyle="none", marker=".",
                markersize=2.5, markeredgewidth=0.0, color=colours[text], label=_label(text),
            )  # fmt: skip
    else:
        exits = dict(zip(data["piece"].values.tolist(), data["exits"].values.tolist(), strict=True))
        named: set[str] = set()
        for piece, across, up in curves(data):
            text = exits[piece]
            ax.plot(
                across, up, color=colours[text], linestyle=dashes[text], linewidth=1.3,
                marker="." if across.size == 1 else None, markersize=2.0,
                label=None if text in named else _label(text), zorder=3,
            )  # fmt: skip
            named.add(text)
    if borders and "border_start" in data:
        kinds = data["border_kind"].values
        for at in data["border_start"].values[np.isin(kinds, ("jump", "corner", "root"))]:
            ax.axvline(at, color="0.6", linewidth=0.6, linestyle=":", zorder=0)
    if diagonal and there.any():
        limits = ax.get_xlim(), ax.get_ylim()
        low = max(limits[0][0], limits[1][0])
        high = min(limits[0][1], limits[1][1])
        if low < high:
            draw_diagonal(ax, low, high)
    finish_map(ax, data)
    if legend:
        place_legend(ax)
    return ax


def _label(text: str) -> str:
    """Exits in order, what is repeated written once with its number."""
    names, words, i = text.split(), [], 0
    while i < len(names):
        length, count = max(
            ((n, _repeats(names[i:], n)) for n in range(1, (len(names) - i) // 2 + 1)),
            key=lambda found: (found[0] * found[1] if found[1] > 1 else 0, -found[0]),
            default=(1, 1),
        )
        block = " ".join(names[i : i + length])
        if count == 1:
            words.append(names[i])
            i += 1
        else:
            words.append(f"{count}({block})")
            i += length * count
    label = " ".join(words) or "no exit"
    return label if len(label) <= _LONGEST else label[: _LONGEST - 1] + "…"


def _repeats(names: list[str], length: int) -> int:
    """How often the first so many names come in a row."""
    count = 1
    while names[count * length : (count + 1) * length] == names[:length]:
        count += 1
    return count
