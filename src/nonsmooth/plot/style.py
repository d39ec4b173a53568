"""How pictures look: colours, line styles, labels with units."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.colors import Colormap

__all__ = [
    "LINES",
    "PALETTE",
    "axis_label",
    "colour_bar",
    "finish_axes",
    "growing_colours",
    "mixed",
    "mode_colours",
    "mode_numbers",
    "modes_visited",
    "plain_numbers",
    "text_width",
    "two_states",
    "wrapped",
]

# M. Okabe and K. Ito, Color universal design, 2008: told apart with every kind of colour
# vision. Ordered so that the first ones also differ in grey; yellow, faint on white, is last.
PALETTE = {
    "blue": "#0072B2",
    "orange": "#E69F00",
    "green": "#009E73",
    "vermilion": "#D55E00",
    "purple": "#CC79A7",
    "sky": "#56B4E9",
    "yellow": "#F0E442",
}

# Colour and dashes of the first, second, ... variable of one picture: either is enough. All
# are dark, so that they stand out before the pale colours of the modes too.
LINES: tuple[dict[str, Any], ...] = (
    {"color": "black", "linestyle": "-", "linewidth": 1.0},
    {"color": "#D55E00", "linestyle": "--", "linewidth": 1.0},
    {"color": "#7A2060", "linestyle": ":", "linewidth": 1.5},  # dots of 1 point look faint
    {"color": "#00664B", "linestyle": "-.", "linewidth": 1.0},
)

_SHADES = ((0, 0), (0, 9), (255, 10), (0, 14))  # black or white, and twentieths of it
_PIECE = 0.78  # of the side of the axes: labels of several lines take room from it
_OVER = 1.03  # of the height of the axes, for a line beside them
_FLAT, _HEIGHT = 1e-10, 0.05  # of the size of values: a span that is rounding, and what it gets
_ROUNDING = 4.0 * float(np.finfo(float).eps)  # of the largest state: what another one has at zero
_MOST_DECADES, _ONE_BY_ONE = 4.0, 0.7  # of a logarithmic axis with plain numbers, with each digit
_NOTHING = "no finite values to draw"
_SYMBOL = re.compile(r"\b([A-Za-z]+)_([A-Za-z0-9]+)\b")  # a unit such as A_b or omega_M
_GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda"),
    *("mu", "nu", "xi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega", "Gamma", "Delta"),
    *("Theta", "Lambda", "Xi", "Sigma", "Phi", "Psi", "Omega"),
)

# from dark blue to ochre in even steps of lightness, alike with every kind of colour vision; the
# pale end would be lost on white
_MAP, _LAST = "cividis", 0.88


def axis_label(variable: xr.DataArray) -> str:
    """Label of an axis: the long name of a variable and its units in brackets.

    Parameters
    ----------
    variable : xarray.DataArray
        A variable of a result.

    Returns
    -------
    str
        Such as ``"displacement [mm]"``, or just ``"time"`` for what has no units.

    Examples
    --------
    >>> import xarray as xr
    >>> from nonsmooth.plot import axis_label
    >>> axis_label(xr.DataArray(0.0, attrs={"long_name": "displacement", "units": "mm"}))
    'displacement [mm]'
    >>> axis_label(xr.DataArray(0.0, name="time"))
    'time'
    """
    units = str(variable.attrs.get("units", ""))
    name = str(variable.attrs.get("long_name") or variable.name or "")
    return name if units in ("", "1", "dimensionless") else f"{name} [{units}]"


def two_states(known: Sequence[str], x: str | None, y: str | None) -> tuple[str, str]:
    """The states to draw across and up: those named, else the first ones."""
    for name in (x, y):
        if name is not None and name not in known:
            raise OptionError(unknown_name("state", name, known))
    if len(known) < 2:
        raise OptionError("the dataset has one state alone, and a picture needs two")
    first = x if x is not None else next(name for name in known if name != y)
    return first, y if y is not None else next(name for name in known if name != first)


def wrapped(label: str, length: float, size: float) -> str:
    """Label in lines of a length at most; both it and the size of the letters are in points."""
    lines: list[str] = []
    for word in _typeset(label).split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer) * size <= length:
            lines[-1] = longer
        else:
            lines += _pieces(word, length / size)
    return "\n".join(lines)


def _pieces(word: str, letters: float) -> list[str]:
    """A word, or parts of it that fit: a name of a program may be longer than an axis."""
    if "$" in word or text_width(word) <= letters:
        return [word]
    count = max(1, int(_PIECE * len(word) * letters / text_width(word)))
    return [word[k : k + count] for k in range(0, len(word), count)]


def _typeset(label: str) -> str:
    """Label whose units have indices and Greek letters: ``[A_b]`` with b below the line."""
    start, bracket, units = label.rpartition("[")
    if "$" in units:
        return label
    return start + bracket + (_SYMBOL.sub(_symbol, units) if bracket else units)


def _symbol(match: re.Match[str]) -> str:
    letter, index = match.groups()
    letter = f"\\{letter}" if letter in _GREEK else letter
    return f"${letter}_{{{index}}}$"


@lru_cache(maxsize=1024)
def text_width(text: str) -> float:
    """Width of a text, in the size of its letters."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    size = 100.0  # large, so that hinting does not count
    letters = FontProperties(size=size)
    width, _, _ = text_to_path.get_text_width_height_descent(text, letters, "$" in text)
    return float(width) / size


def mode_colours(run: xr.Dataset) -> dict[str, str]:
    """Colour of each mode; it depends on the system only, so it is the same in every picture.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.

    Returns
    -------
    dict of str to str
        Mode names to colours that matplotlib understands.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=1)
    >>> ns.plot.mode_colours(run)["contact"]
    '#E69F00'
    """
    if "mode" not in run or "flag_meanings" not in run["mode"].attrs:
        raise OptionError("the dataset has no variable 'mode' with its names; give it a run")
    palette = list(PALETTE.values())
    # systems with many cells: the same hues darker, then paler, then darker still
    colours = [mixed(colour, *shade) for shade in _SHADES for colour in palette]
    names = run["mode"].attrs["flag_meanings"].split()
    distinct = dict.fromkeys(names)  # cells may share a name
    return {name: colours[i % len(colours)] for i, name in enumerate(distinct)}


def mode_numbers(run: xr.Dataset, name: str) -> list[int]:
    """Numbers of the modes that have a name."""
    names = run["mode"].attrs["flag_meanings"].split()
    return [i for i, other in enumerate(names) if other == name]


def modes_visited(
    run: xr.Dataset, modes: npt.NDArray[np.int64]
) -> dict[str, npt.NDArray[np.bool_]]:
    """Where each mode is, by its name and in the order of the colours; without those never used."""
    names = run["mode"].attrs["flag_meanings"].split()
    distinct = list(dict.fromkeys(names))
    number = np.array([distinct.index(name) for name in names])[modes]
    used = np.bincount(number.ravel(), minlength=len(distinct)) > 0
    return {name: number == i for i, name in enumerate(distinct) if used[i]}


def mixed(colour: str, target: int, twentieths: int) -> str:
    """Colour with so many twentieths of black (0) or white (255)."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(
        f"{(part * (20 - twentieths) + target * twentieths) // 20:02X}" for part in parts
    )


def largest_state(
    data: xr.Dataset, *names: str, time_range: tuple[float, float] | None = None
) -> tuple[float, ...]:
    """Size of the largest state in a result, for each name of a state; zero for other names.

    Beside it the rounding of a state that is zero is nothing. What is small at the end of a decay
    counts beside other states at that time.
    """
    if time_range is not None:
        low, high = time_range
        data = data.isel(time=((data["time"] >= low) & (data["time"] <= high)).values)
    states = tomllib.loads(str(data.attrs.get("system", ""))).get("states", [])
    drawn = [np.abs(data[name].values) for name in states if name in data.data_vars]
    finite = [float(values[np.isfinite(values)].max(initial=0.0)) for values in drawn]
    return tuple(max(finite, default=0.0) if name in states else 0.0 for name in names)


def finish_axes(
    ax: Axes, x_label: str, y_label: str, *, sizes: tuple[float, ...] = (0.0, 0.0)
) -> None:
    """Set the labels that the caller has not set before, and say where axes hold nothing.

    ``sizes`` of what is drawn, as `largest_state` has them: rounding beside them is drawn as zero.
    """
    _widen_constant(ax, sizes)
    across, up = _sides(ax)
    if not ax.get_xlabel():
        ax.set_xlabel(wrapped(x_label, across, float(ax.xaxis.label.get_fontsize())))
    if not ax.get_ylabel():
        ax.set_ylabel(wrapped(y_label, _OVER * up, float(ax.yaxis.label.get_fontsize())))
    if ax.lines and not np.isfinite(ax.dataLim.get_points()).any():
        ax.text(0.5, 0.5, _NOTHING, transform=ax.transAxes, ha="center", va="center", color="0.4",
                fontsize=ax.xaxis.label.get_fontsize())  # fmt: skip


def plain_numbers(axis: Axis) -> None:
    """Numbers such as 6 along a logarithmic axis of few decades, in place of 6e0."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    low, high = sorted(axis.get_view_interval())
    decades = float(np.log10(high / low)) if low > 0.0 else np.inf
    if decades > _MOST_DECADES:
        return
    parts = (1.0, 2.0, 5.0) if decades > _ONE_BY_ONE else tuple(np.arange(1.0, 10.0))
    axis.set_major_locator(LogLocator(subs=parts))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _widen_constant(ax: Axes, sizes: tuple[float, ...]) -> None:
    """Give what is constant but for rounding a span, so that rounding is not what is read.

    It is the span that matplotlib gives what is constant to the last digit. What is zero but for
    rounding gets that of the states beside which it is zero.
    """
    for (low, high), natural, axis, is_free, set_limits in (
        (ax.dataLim.intervalx, sizes[0], ax.xaxis, ax.get_autoscalex_on(), ax.set_xlim),
        (ax.dataLim.intervaly, sizes[1], ax.yaxis, ax.get_autoscaley_on(), ax.set_ylim),
    ):
        size = max(abs(low), abs(high))
        is_zero = 0.0 < size <= _ROUNDING * natural
        is_flat = is_zero or low < high < low + _FLAT * size
        if is_free and axis.get_scale() == "linear" and is_flat:
            span = _HEIGHT * (natural if is_zero else size)
            set_limits(low - span, high + span, auto=True)


def _sides(ax: Axes) -> tuple[float, float]:
    """Width and height of axes in points, before the figure makes room for labels."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    box = ax.get_window_extent()
    return box.width / figure.dpi * 72.0, box.height / figure.dpi * 72.0


def growing_colours() -> Colormap:
    """Colours from the first to the last."""
    import matplotlib
    from matplotlib.colors import ListedColormap

    return ListedColormap(matplotlib.colormaps[_MAP](np.linspace(0.0, _LAST, 256)))


def _drawn_height(ax: Axes) -> float:
    """Height of axes in points; of those with a shape of their own, what is left of it."""
    width, height = _sides(ax)
    if ax.get_aspect() == "auto":
        return height
    return min(height, width * float(ax.get_aspect()) * ax.get_data_ratio())


def colour_bar(
    ax: Axes, drawn: Any, label: str, *, inset: bool = False, extend: str = "neither"
) -> None:
    """Bar beside the axes with texts of the same size, whose label is no longer than the bar.

    It has a point at an end beyond which values have the last colour, as ``extend`` says. An inset
    one is as high as axes that have a shape of their own, such as equal scales.
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    place: dict[str, Any] = {"ax": ax, "pad": 0.02, "aspect": 25}
    if inset:
        place = {"cax": ax.inset_axes((1.03, 0.0, 0.035, 1.0))}
    bar = figure.colorbar(drawn, extend=extend, **place)
    size = float(ax.xaxis.label.get_fontsize())
    bar.set_label(wrapped(label, _drawn_height(ax), size), fontsize=size)
    bar.ax.tick_params(labelsize=size - 1.0, width=0.6, length=2.5)
    bar.ax.yaxis.get_offset_text().set_fontsize(size - 1.0)
    bar.outline.set_linewidth(0.6)
