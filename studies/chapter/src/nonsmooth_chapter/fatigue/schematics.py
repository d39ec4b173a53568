"""Drawings of the fatigue-testing rig: two masses, Fig. 23, and one, Fig. 26."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import System
from nonsmooth.models import breathing_crack, fatigue_rig
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.drawing import arrow, bare, damper, spring

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig23", "fig26"]

_TEXT = 8
_FORCE, _MOTION = PALETTE["vermilion"], PALETTE["blue"]


def fig23() -> tuple[Figure, xr.Dataset]:
    """Fig. 23: two masses above and below the specimen.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Masses, springs and dashpots between the base and the specimen.
    data : xarray.Dataset
        ``value`` over ``parameter``: those of `nonsmooth.models.fatigue_rig`, the model drawn.

    Examples
    --------
    >>> figure, data = fig23()
    >>> data.sizes["parameter"] > 5
    True
    """
    figure, (ax,) = print_figure(width=11.0, height=12.0)
    for at in (0.0, 10.0):
        _wall(ax, (-4.0, at), (4.0, at))
    for side in (-4.0, 4.0):
        _wall(ax, (side, 0.0), (side, 10.0))
    for number, mass, end, near in (("1", 7.0, 10.0, 8.0), ("2", 2.0, 0.0, 2.0)):
        _box(ax, (-1.7, mass), (3.4, 1.0), f"$m_{number}$", "0.88")
        names = (rf"$k_{{Ls{number}}}$", rf"$c_{{Ls{number}}}$",
                 rf"$k_{{p{number}}}$", rf"$c_{{p{number}}}$")  # fmt: skip
        for at, name, part in zip((-1.5, -0.8, 0.8, 1.5), names, (spring, damper) * 2, strict=True):
            part(ax, np.array([at, near]), np.array([at, end]))
            beside = -0.75 if at < -1.0 else (0.75 if at > 1.0 else 0.0)
            if beside:
                _name(ax, (at + beside, 0.5 * (near + end) + 0.35), name)
            else:
                _name(ax, (at, end + (0.35 if end > near else -0.35)), name)
        arrow(ax, (0.0, near + 0.65 * (end - near)), (0.0, near), _FORCE, "")
        _name(ax, (0.0, near + 0.8 * (end - near)), f"$P_{number}$", _FORCE)
        face = 7.0 if number == "1" else 3.0
        spring(ax, np.array([0.0, face]), np.array([0.0, 5.3 if number == "1" else 5.0]))
        _name(ax, (0.75, 0.5 * (face + 5.15)), rf"$k_{{sc{number}}}$")
        arrow(ax, (2.3, mass + 1.0), (2.3, mass), _MOTION, "")
        _name(ax, (2.85, mass + 0.5), f"$x_{{m{number}}}$", _MOTION)
    _specimen(ax)
    arrow(ax, (4.6, 5.8), (4.6, 4.4), _MOTION, "")
    _name(ax, (5.7, 5.1), r"$A_b\,\sin\,\Omega t$", _MOTION)
    bare(ax, (-4.4, 6.8), (-0.8, 10.8))
    return figure, _parameters(fatigue_rig())


def fig26() -> tuple[Figure, xr.Dataset]:
    """Fig. 26: one mass, while both are in contact with the specimen.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The mass with the springs and the dashpot of Eq. (45).
    data : xarray.Dataset
        ``value`` over ``parameter``: those of `nonsmooth.models.breathing_crack`, which has the
        same mass on a cracked specimen.

    Examples
    --------
    >>> figure, data = fig26()
    >>> len(figure.axes)
    1
    """
    figure, (ax,) = print_figure(width=8.0, height=7.0)
    _wall(ax, (-2.6, 0.0), (2.6, 0.0))
    _box(ax, (-2.0, 2.6), (4.0, 1.2), "$M = m_1 + m_2$", "0.88")
    for at, name, part in ((-1.5, "$k_M$", spring), (0.0, "$c_M$", damper), (1.5, "$k_s$", spring)):
        part(ax, np.array([at, 0.0]), np.array([at, 2.6]))
        _name(ax, (at + 0.55, 1.3), name)
    arrow(ax, (2.5, 3.8), (2.5, 2.6), _MOTION, "")
    _name(ax, (3.0, 3.2), "$z_M$", _MOTION)
    arrow(ax, (3.0, 0.7), (3.0, -0.5), _MOTION, "")
    _name(ax, (4.0, 0.1), r"$A_b\,\sin\,\Omega t$", _MOTION)
    bare(ax, (-3.0, 5.0), (-0.8, 4.2))
    return figure, _parameters(breathing_crack())


def _specimen(ax: Axes) -> None:
    """The rigid beam on its springs and dashpots, between the contacts."""
    _box(ax, (-3.4, 5.0), (6.8, 0.3), "", "0.75")
    for side in (-1.0, 1.0):
        _wall(ax, (4.0 * side, 3.4), (2.2 * side, 3.4))
        spring(ax, np.array([3.2 * side, 3.4]), np.array([3.2 * side, 5.0]))
        damper(ax, np.array([2.5 * side, 3.4]), np.array([2.5 * side, 5.0]))
        _name(ax, (3.1 * side, 2.95), r"$\frac{1}{2}k_s,\ \frac{1}{2}c_s$")
    _name(ax, (-2.4, 5.65), "specimen")


def _wall(ax: Axes, begin: Any, end: Any) -> None:
    ax.plot(*zip(begin, end, strict=True), color="black", linewidth=1.6)


def _box(ax: Axes, corner: Any, size: Any, name: str, colour: str) -> None:
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle(corner, *size, facecolor=colour, edgecolor="black", linewidth=1.0))
    _name(ax, (corner[0] + 0.5 * size[0], corner[1] + 0.5 * size[1]), name)


def _name(ax: Axes, at: Any, text: str, colour: str = "black") -> None:
    ax.text(at[0], at[1], text, ha="center", va="center", fontsize=_TEXT, color=colour)


def _parameters(system: System) -> xr.Dataset:
    values = system.parameter_values
    return xr.Dataset(
        {"value": ("parameter", list(values.values()), {"long_name": "value of the parameter"})},
        {"parameter": list(values)},
        {"system": system.to_toml()},
    )
