"""Return maps of one coordinate: the map itself, and cobwebs on it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes
from nonsmooth.real_numbers import whole_number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["cobweb", "return_map"]

Floats = npt.NDArray[np.float64]

_COLOURS = [colour for name, colour in PALETTE.items() if name != "yellow"]  # faint as a line
_DASHES = ("-", "--", ":", "-.")
_LONGEST = 44  # letters of a label

_FEW = 60  # steps that are told one from the other


def require_map(data: xr.Dataset) -> None:
    """Refuse what is no return map."""
    missing = [name for name in ("image", "piece", "slope") if name not in data]
    if missing or "start" not in data.dims:
        raise OptionError(
            "the dataset has no variable 'image' over 'start'; give it a result of return_map"
        )


def of_motion(data: xr.Dataset) -> bool:
    """Whether the map is known at the points of a motion alone."""
    return "exponent_per_return" in data


def turn_of(data: xr.Dataset) -> float | None:
    """Length after which the coordinate begins anew; None where it does not."""
    return float(data["turn"]) if "turn" in data else None


def curves(data: xr.Dataset) -> Iterator[tuple[int, Floats, Floats]]:
    """Piece, starts and images of each part of the graph that is one curve."""
    start, image = data["start"].values, data["image"].values
    piece, turn = data["piece"].values, turn_of(data) or np.inf
    breaks = np.flatnonzero(
        (piece[1:] != piece[:-1]) | (np.abs(np.diff(image)) > 0.5 * turn)  # around the circle
    )
    for here in np.split(np.arange(start.size), breaks + 1):
        if piece[here[0]] >= 0:
            yield int(piece[here[0]]), start[here], image[here]


def image_at(data: xr.Dataset, value: float) -> float:
    """Image of any value, by the cubic through the two starts around it; nan where there is none.

    Where these lie in different pieces there is none either.
    """
    start, image, slope = (data[n].values for n in ("start", "image", "slope"))
    piece, turn = data["piece"].values, turn_of(data)
    i = int(np.searchsorted(start, value, side="right")) - 1
    i -= int(i == start.size - 1 and value == start[-1])
    if not 0 <= i < start.size - 1 or piece[i] < 0:
        return np.nan
    if value == start[i]:
        return float(image[i])
    if piece[i] != piece[i + 1]:
        return np.nan
    width = start[i + 1] - start[i]
    rise = image[i + 1] - image[i]
    if turn is not None:
        rise -= turn * np.rint(rise / turn)
    t = (value - start[i]) / width
    first, last = slope[i] * width, slope[i + 1] * width
    steep = max(abs(first), abs(last)) > 3.0 * abs(rise) + 1e-300
    if not np.isfinite(first + last) or (first * last > 0.0 and steep):
        first = last = rise  # a root, which no cubic follows
    step = t * (first + t * (3.0 * rise - 2.0 * first - last + t * (first + last - 2.0 * rise)))
    found = image[i] + step
    return float(found if turn is None else np.mod(found, turn))


def draw_diagonal(ax: Axes, low: float, high: float) -> None:
    """The line on which images are the starts."""
    ax.plot([low, high], [low, high], color="0.6", linewidth=0.7, linestyle="-", zorder=1)


def finish_map(ax: Axes, data: xr.Dataset) -> None:
    """Labels of both axes."""
    finish_axes(ax, axis_label(data["start"]), _image_label(data))


def _image_label(data: xr.Dataset) -> str:
    """Label of the images: that of the starts, and which return it is."""
    order = int(data.attrs.get("order", 1))
    which = "next" if order == 1 else f"{order} points on"
    words: dict[str, Any] = dict(data["start"].attrs)
    words["long_name"] = f"{words.get('long_name') or 'start'}, {which}"
    return axis_label(data["start"].assign_attrs(words))


@checked
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


@checked
def cobweb(
    data: xr.Dataset,
    start: float | None = None,
    *,
    steps: int = 50,
    transient: int = 0,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Graph of a return map with its diagonal, a staircase and the fixed points.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `return_map`.
    start : float, optional
        Where the staircase begins; there is none without it. With a map of ``points`` it is the
        number of the point from which the motion is followed.
    steps : int, optional
        Most steps of the staircase; it ends where the map does.
    transient : int, optional
        First steps that are not drawn.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new square axes by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one range in both directions. Full circles are stable fixed points of the
        map, empty ones are unstable. Curves end where the map jumps.

    Raises
    ------
    OptionError
        For another dataset, a start outside the map, or negative steps.

    Notes
    -----
    Between two starts of the dataset the staircase follows the cubic through their images and
    slopes, so that it is as exact as the graph; nothing is simulated.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mole = ns.PoincareMap(ns.models.moling(), "2*xi*y + q = 1", direction=-1)
    >>> found = ns.return_map(
    ...     mole, "phase", (0, 62), completion={"q": 1, "y": 0}, mode="contact", samples=50
    ... )
    >>> ax = ns.plot.cobweb(found, 30.0)
    >>> ax.get_xlabel()
    'time since the period began'
    """
    require_map(data)
    steps = whole_number("steps", steps, least=0)
    transient = whole_number("transient", transient, least=0)
    ax = _square_axes() if ax is None else ax
    low, high = _range(data)
    draw_diagonal(ax, low, high)
    if of_motion(data):
        ax.plot(
            data["start"], data["image"], linestyle="none", marker=".", markersize=2.0,
            markeredgewidth=0.0, color="black", label="points of the motion", zorder=3,
        )  # fmt: skip
    else:
        for k, (_, across, up) in enumerate(curves(data)):
            single = across.size == 1
            ax.plot(
                across, up, color="black", linewidth=1.2, marker="." if single else None,
                markersize=2.0, label=None if k else "map", zorder=3,
            )  # fmt: skip
    if start is not None:
        _draw_staircase(ax, _orbit(data, start, steps), transient)
    _draw_fixed_points(ax, data)
    margin = 0.02 * (high - low)
    ax.set(xlim=(low - margin, high + margin), ylim=(low - margin, high + margin))
    finish_map(ax, data)
    if legend:
        place_legend(ax)
    return ax


def _square_axes() -> Any:
    ax = new_axes()
    ax.figure.set_size_inches(*[max(ax.figure.get_size_inches())] * 2)
    ax.set_aspect("equal")
    return ax


def _range(data: xr.Dataset) -> tuple[float, float]:
    """Range of starts and of images together; all of a turn where there is one."""
    values = np.concatenate([data["start"].values, data["image"].values])
    values = values[np.isfinite(values)]
    low, high = float(values.min()), float(values.max())
    turn = turn_of(data)
    if turn is not None:
        low, high = min(low, 0.0), max(high, turn)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _orbit(data: xr.Dataset, start: float, steps: int) -> npt.NDArray[np.float64]:
    """Values that the map leads through."""
    if of_motion(data):
        first = int(start)
        if first != start or not 0 <= first < data.sizes["start"]:
            raise OptionError(
                f"start = {start:g}: with a map of points give the number of one of them, from 0 to"
                f" {data.sizes['start'] - 1}"
            )
        return data["start"].values[first : first + steps + 1]
    values = [float(start)]
    while len(values) <= steps:
        image = image_at(data, values[-1])
        if not np.isfinite(image):
            break
        values.append(image)
    if len(values) == 1 and steps > 0:
        low, high = float(data["start"].min()), float(data["start"].max())
        raise OptionError(
            f"start = {start:g}: the map has no image there; its starts lie from {low:g} to"
            f" {high:g}, with gaps where status is not 'completed'"
        )
    return np.array(values)


def _draw_staircase(ax: Axes, values: npt.NDArray[np.float64], transient: int) -> None:
    """Up to the map and across to the diagonal, again and again."""
    shown = values[transient:]
    if shown.size < 2:
        return
    across = np.repeat(shown, 2)[:-1]
    up = np.concatenate([[shown[0]], np.repeat(shown[1:], 2)])
    many = shown.size > _FEW
    ax.plot(
        across, up, color=PALETTE["vermilion"], linewidth=0.4 if many else 0.7,
        alpha=0.7 if many else 1.0, label="steps", zorder=2,
    )  # fmt: skip
    if not transient:
        ax.plot(
            shown[:1], shown[:1], linestyle="none", marker="s", markersize=3.5,
            color=PALETTE["vermilion"], label="start", zorder=5,
        )  # fmt: skip


def _draw_fixed_points(ax: Axes, data: xr.Dataset) -> None:
    if "fixed_start" not in data:
        return
    at, stable = data["fixed_start"].values, data["fixed_stable"].values
    for here, face, label in (
        (stable, PALETTE["blue"], "stable fixed point"),
        (~stable, "white", "unstable fixed point"),
    ):
        if here.any():
            ax.plot(
                at[here], at[here], linestyle="none", marker="o", markersize=4.5,
                markerfacecolor=face, markeredgecolor=PALETTE["blue"], markeredgewidth=1.0,
                label=label, zorder=4,
            )  # fmt: skip
