"""Trajectories in subspaces and along the surfaces between them: Fig. 1 from real systems."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.plot import PALETTE, print_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig1"]

_TEXT = 8
# starts of the trajectories that are drawn, and how long each is followed
_ON_BELT = ((-0.3, 1.25), (-0.95, 0.05), (0.95, -0.75))
_AT_SPRING = ((0.2, 1.35), (-0.9, 0.0), (0.3, 0.0))
_LONGEST = 9.0
_WIDE, _THIN = 1.8, 0.9
_SIDES = {"above": ("-", _WIDE), "below": ("--", _WIDE), "on": ("-", _THIN)}


def _belt() -> System:
    """A block on a belt: dry friction, whose field jumps where the block moves with the belt."""
    return System(
        name="belt",
        states=["x", "v"],
        parameters={"v_b": 0.3, "F": 0.4},
        equations={"x": "v", "v": "-x - 0.1*v - F*sign(v - v_b)"},
    )


def _spring() -> System:
    """A mass that meets a spring: compliant contact, whose field does not jump."""
    return System(
        name="spring",
        states=["x", "v"],
        parameters={"e": 0.5, "beta": 6.0},
        equations={"x": "v", "v": "-x - 0.06*v - beta*max(x - e, 0)"},
    )


def fig1(friction: float = 0.4, stiffness: float = 6.0) -> tuple[Figure, xr.Dataset]:
    """Fig. 1: trajectories within subspaces, across the surface between them, and along it.

    Parameters
    ----------
    friction : float, optional
        Friction force of the block on the belt over the force of its spring per displacement.
    stiffness : float, optional
        Stiffness of the second spring over that of the first.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Left a block on a moving belt, whose trajectories arrive at the surface v = v_b and slide
        on it; right a mass that meets a spring, whose trajectories all cross.
    data : xarray.Dataset
        States ``x v`` over ``trajectory`` and ``time`` for either system, and the ``side`` of the
        surface that each point is on: 1, -1, or 0 on it.

    Examples
    --------
    >>> figure, data = fig1()
    >>> sorted({int(side) for side in data["belt_side"].values.ravel()})
    [-1, 0, 1]
    >>> sorted({int(side) for side in data["spring_side"].values.ravel()})
    [-1, 1]
    """
    belt = _belt().with_parameters(F=friction)
    spring = _spring().with_parameters(beta=stiffness)
    data = xr.merge([_trajectories(belt, _ON_BELT), _trajectories(spring, _AT_SPRING)])
    figure, (left, right) = print_figure(1, 2, width=16.0, height=7.5)
    _draw(left, data, "belt", len(_ON_BELT))
    _draw(right, data, "spring", len(_AT_SPRING))
    speed, gap = belt.parameter_values["v_b"], spring.parameter_values["e"]
    left.axhline(speed, color="0.75", linewidth=3.5, zorder=0)
    right.axvline(gap, color="0.75", linewidth=3.5, zorder=0)
    left.text(1.72, speed + 0.08, r"surface $v = v_b$", fontsize=_TEXT, ha="right")
    right.text(gap + 0.04, -1.3, r"surface $x = e$", fontsize=_TEXT)
    left.text(-1.25, 1.3, "subspace $X_1$", fontsize=_TEXT, color=PALETTE["blue"])
    left.text(-1.25, -1.3, "subspace $X_2$", fontsize=_TEXT, color=PALETTE["vermilion"])
    right.text(-1.25, 1.3, "subspace $X_1$", fontsize=_TEXT, color=PALETTE["vermilion"])
    right.text(0.75, 1.3, "subspace $X_2$", fontsize=_TEXT, color=PALETTE["blue"])
    left.set_title("(a) dry friction: across, or along", loc="left", fontsize=_TEXT)
    right.set_title("(b) compliant contact: across", loc="left", fontsize=_TEXT)
    data.attrs["note"] = "the chapter's figure is a sketch; these are a belt and a second spring"
    return figure, data


def _trajectories(system: System, starts: tuple[tuple[float, float], ...]) -> xr.Dataset:
    """States of some runs, and on which side of the surface each point lies."""
    times = np.linspace(0.0, _LONGEST, 1801)
    runs = [simulate(system, {"x": x, "v": v}, times=times) for x, v in starts]
    signs = {"+": 1, "-": -1, "0": 0}
    sides = np.array([signs[name[-2]] for name in system.mode_names])
    found = {
        f"{system.name}_{name}": (("trajectory", "time"), np.array([run[name] for run in runs]))
        for name in ("x", "v")
    }
    side = np.array([sides[run["mode"].values] for run in runs])
    found[f"{system.name}_side"] = (("trajectory", "time"), side)
    words = {"x": "displacement", "v": "velocity", "side": "side of the surface, 0 on it"}
    data = xr.Dataset(found, {"time": times})
    for name in data.data_vars:
        data[name].attrs["long_name"] = words[str(name).rpartition("_")[2]]
    return data


def _draw(ax: Axes, data: xr.Dataset, name: str, count: int) -> None:
    """Trajectories with a line of its own for every side."""
    looks = {1: ("above", PALETTE["blue"]), -1: ("below", PALETTE["vermilion"]), 0: ("on", "black")}
    for k in range(count):
        x, v, side = (data[f"{name}_{part}"].values[k] for part in ("x", "v", "side"))
        ax.plot(x[0], v[0], "o", color="black", markersize=3.5)
        ends = [0, *np.flatnonzero(np.diff(side)) + 1, side.size]
        for first, last in pairwise(ends):
            place, colour = looks[int(side[first])]
            style, width = _SIDES[place]
            part = slice(max(first - 1, 0), last)
            ax.plot(x[part], v[part], style, color=colour, linewidth=width)
            if place != "on":
                _arrow(ax, x[first:last], v[first:last], colour)
    ax.set_xlabel("displacement, x")
    ax.set_ylabel("velocity, v")
    ax.set_xlim(-1.3, 1.75)
    ax.set_ylim(-1.55, 1.55)


def _arrow(ax: Axes, x: np.ndarray, v: np.ndarray, colour: str) -> None:
    """Direction of a piece, at its middle."""
    k = x.size // 2
    if k < 10 or k + 4 >= x.size:
        return
    ax.annotate(
        "", (x[k + 4], v[k + 4]), (x[k], v[k]),
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 0.1},
    )  # fmt: skip
