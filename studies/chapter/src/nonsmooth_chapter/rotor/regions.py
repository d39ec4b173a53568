"""Regions of operation over the position of the rotor, and their boundaries: Figs. 34 and 35."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.models import snubber_boundaries
from nonsmooth.plot import contact_regions, print_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig34", "fig35"]

# The chapter prints no preload; one that is large enough to see all regions.
_DELTA = 0.3
_SMALL = 7
_CONDITIONS = {
    "I": r"$D<\gamma$",
    "II": "$|x_s|\\leq\\Delta_x$, $|y_s|\\leq\\Delta_y$",
    "III": "$|x_s|>\\Delta_x$\n$|y_s|\\leq\\Delta_y$",
    "IV": "$|x_s|\\leq\\Delta_x$, $|y_s|>\\Delta_y$",  # low region: in one line
    "V": "$|x_s|>\\Delta_x$\n$|y_s|>\\Delta_y$",
}

_WITHIN = (-1.09, 0.0)  # the narrow second region, where there is no name


def fig34(delta: float = _DELTA) -> tuple[Figure, xr.Dataset]:
    """Fig. 34: regions I to V for the whole plane.

    Parameters
    ----------
    delta : float, optional
        Preload along both axes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The regions with their names, and the conditions for them in the first quadrant.
    data : xarray.Dataset
        Result of `nonsmooth.models.snubber_boundaries`.

    Examples
    --------
    >>> figure, data = fig34()
    >>> data.attrs["delta_x"]
    0.3
    """
    figure, data = _regions(delta, "plane", 11.0, equations=False)
    _conditions(figure.axes[0])
    return figure, data


def fig35(delta: float = _DELTA) -> tuple[Figure, xr.Dataset]:
    """Fig. 35: the first quadrant with the boundaries by Eqs. (62)-(66).

    Parameters
    ----------
    delta : float, optional
        Preload along both axes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The regions and the numbers of their boundaries.
    data : xarray.Dataset
        Result of `nonsmooth.models.snubber_boundaries`.

    Examples
    --------
    >>> figure, data = fig35()
    >>> sorted(set(data["equation"].values.tolist()))
    [62, 63, 64, 65, 66]
    """
    return _regions(delta, "quadrant", 9.0, equations=True)


def _conditions(ax: Axes) -> None:
    """What holds in each region, under its name in the first quadrant, as the chapter has it."""
    named = {text.get_text(): text for text in ax.texts if min(text.get_position()) >= 0.0}
    for name, told in _CONDITIONS.items():
        if name in named and name != "II":
            ax.annotate(told, named[name].get_position(), (0, -7), textcoords="offset points",
                        ha="center", va="top", fontsize=_SMALL)  # fmt: skip
    ax.text(*_WITHIN, _CONDITIONS["II"], rotation=90, ha="center", va="center", fontsize=_SMALL)


def _regions(
    delta: float, view: str, width: float, *, equations: bool
) -> tuple[Figure, xr.Dataset]:
    data = snubber_boundaries(delta_x=delta, delta_y=delta)
    figure, (ax,) = print_figure(width=width, height=width)
    contact_regions(data, ax=ax, view=view, equations=equations)
    ax.set_xlabel(r"displacement of the rotor, $x_r/\gamma$")
    ax.set_ylabel(r"displacement of the rotor, $y_r/\gamma$")
    return figure, data
