"""How pictures look: colours, line styles, labels with units."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
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
_LABEL_WIDTH = 34  # characters; at 8 points this is the height of a column-wide picture

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


def wrapped(label: str) -> str:
    """Label in lines that fit beside axes of a column's width."""
    return textwrap.fill(label, _LABEL_WIDTH)


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


def mixed(colour: str, target: int, twentieths: int) -> str:
    """Colour with so many twentieths of black (0) or white (255)."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(
        f"{(part * (20 - twentieths) + target * twentieths) // 20:02X}" for part in parts
    )


def finish_axes(ax: Axes, x_label: str, y_label: str) -> None:
    """Set the labels that the caller has not set before."""
    if not ax.get_xlabel():
        ax.set_xlabel(wrapped(x_label))
    if not ax.get_ylabel():
        ax.set_ylabel(wrapped(y_label))


def growing_colours() -> Colormap:
    """Colours from the first to the last."""
    import matplotlib
    from matplotlib.colors import ListedColormap

    return ListedColormap(matplotlib.colormaps[_MAP](np.linspace(0.0, _LAST, 256)))


def colour_bar(ax: Axes, drawn: Any, label: str, *, inset: bool = False) -> None:
    """Bar beside the axes with texts of the same size.

    An inset one is as high as axes that have a shape of their own, such as equal scales.
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    place: dict[str, Any] = {"ax": ax, "pad": 0.02, "aspect": 25}
    if inset:
        place = {"cax": ax.inset_axes((1.03, 0.0, 0.035, 1.0))}
    bar = figure.colorbar(drawn, **place)
    size = float(ax.xaxis.label.get_fontsize())
    bar.set_label(wrapped(label), fontsize=size)
    bar.ax.tick_params(labelsize=size - 1.0, width=0.6, length=2.5)
    bar.ax.yaxis.get_offset_text().set_fontsize(size - 1.0)
    bar.outline.set_linewidth(0.6)
