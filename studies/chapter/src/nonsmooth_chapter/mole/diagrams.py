"""Diagrams of the mole over its static force: Fig. 8.

The chapter prints neither the range of b nor how the columns begin. Here b goes up to a, above
which the force never draws the mass off the ground, and every column begins at rest; where the
column of a followed sweep ends in another motion, that one is drawn too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram
from nonsmooth.models import moling
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.mole.static_force_sweeps import (
    AMPLITUDES,
    PROTOCOLS,
    Sweep,
    even_forces,
    first_fifty,
    settled_labels,
)
from nonsmooth_chapter.mole.windows import stretches, widest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig8"]

_XI, _OMEGA = 0.05, 0.1
_TEXT = 8  # points, as in the rest of the figure
_SAME = 1e-4  # between strobes of one periodic motion that two protocols found
_MARKS = {  # colour, and on the right a shape too
    "restart": ("black", "."),
    "follow up": (PALETTE["blue"], "^"),
    "follow down": (PALETTE["vermilion"], "v"),
}


def fig8(columns: int = 400, transient: int = 400, record: int = 100) -> tuple[Figure, xr.Dataset]:
    """Fig. 8: velocity at strobes and progression in 50 periods, over b for three amplitudes.

    Parameters
    ----------
    columns : int, optional
        Columns of each diagram.
    transient, record : int, optional
        Periods left out and drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (c) left, (d) to (f) right; dashed lines are the ends of the widest periodic
        window.
    data : xarray.Dataset
        Over ``a``, ``start``, ``column`` and ``point``: ``b``, ``y``, ``period``, ``per_period``;
        ``first_50`` from rest.

    Examples
    --------
    >>> figure, data = fig8(columns=6, transient=50, record=20)
    >>> data["y"].dims, len(figure.axes)
    (('a', 'start', 'column', 'point'), 6)
    """
    figure, axes = print_figure(3, 2, width=16.0, height=17.0)
    kept = []
    for row, a in enumerate(AMPLITUDES):
        data = _diagrams(a, columns, transient, record)
        kept.append(data)
        velocity, progression = axes[2 * row : 2 * row + 2]
        _draw_velocity(data, velocity)
        _draw_progression(data, progression)
        for ax, letter in ((velocity, "abc"[row]), (progression, "def"[row])):
            ax.set_title(f"({letter}) a = {a:g}", loc="left", fontsize=_TEXT)
            ax.set_xlabel("static force, b" if row == len(AMPLITUDES) - 1 else "")
            ax.set_xlim(0.0, a)
            for b in data["window"].values:
                ax.axvline(b, color="0.45", linewidth=0.7, linestyle=(0, (4, 3)), zorder=0)
    _place_legend(figure)
    data = xr.concat(kept, xr.DataArray(list(AMPLITUDES), dims="a", name="a"))
    data.attrs = kept[0].attrs
    return figure, data


def _diagrams(a: float, columns: int, transient: int, record: int) -> xr.Dataset:
    """All that the two panels of one amplitude show."""
    forces = even_forces(a, columns)
    system = moling(a=a, xi=_XI, omega=_OMEGA)
    found = [
        bifurcation_diagram(
            system, "b", forces, start=start, transient=transient, record=record
        ).isel(lane=0)
        for start in PROTOCOLS
    ]
    over = ("start", "column")
    gain = [diagram["v_per_period"].values for diagram in found]
    periods = np.stack([diagram["period"].values for diagram in found])
    # near a period doubling a motion without a period need not be chaotic: exponents decide
    labels, exponents = settled_labels(found[0].expand_dims("lane"), a=a, xi=_XI, omega=_OMEGA)
    window = widest(stretches(Sweep(np.array(forces), labels, gain[0], exponents)))
    units = {"long_name": "progression in the first 50 periods from rest"}
    return xr.Dataset(
        {
            "b": ("column", list(forces), {"long_name": "static force"}),
            "y": (
                (*over, "point"),
                np.stack([diagram["y"].values for diagram in found]),
                {"long_name": "velocity of the mass at strobes"},
            ),
            "period": (over, periods, {"long_name": "period of the motion, 0: none found"}),
            "per_period": (over, np.stack(gain), {"long_name": "settled progression per period"}),
            "first_50": ("column", first_fifty(a, forces), units),
            "window": ("edge", [window["low"], window["high"]]),
            "status": (over, np.stack([diagram["status"].values for diagram in found])),
        },
        {"start": list(PROTOCOLS)},
        {
            "xi": _XI,
            "omega": _OMEGA,
            "transient": transient,
            "record": record,
            "nonsmooth_version": found[0].attrs["nonsmooth_version"],
        },
    )


def _elsewhere(data: xr.Dataset, start: str) -> np.ndarray:
    """Columns in which a followed sweep ends in another motion than from rest."""
    rest, other = data.sel(start="restart"), data.sel(start=start)
    periods = rest["period"].values, other["period"].values
    extremes = [
        np.stack([part["y"].min("point").values, part["y"].max("point").values])
        for part in (rest, other)
    ]
    apart = np.abs(extremes[0] - extremes[1]).max(axis=0) > _SAME
    periodic = (periods[0] > 0) | (periods[1] > 0)
    return periodic & apart


def _draw_velocity(data: xr.Dataset, ax: Axes) -> None:
    for start in PROTOCOLS:
        part = data.sel(start=start)
        if start != "restart":
            part = part.isel(column=_elsewhere(data, start))
        y = part["y"].values
        ax.plot(
            np.repeat(part["b"].values, y.shape[1]), y.ravel(), linestyle="none",
            marker=_MARKS[start][1], markersize=0.9 if start == "restart" else 2.0,
            markeredgewidth=0.0, color=_MARKS[start][0], rasterized=True,
        )  # fmt: skip
    ax.set_ylabel("velocity, y")


def _draw_progression(data: xr.Dataset, ax: Axes) -> None:
    ax.plot(data["b"], data["first_50"], linestyle="none", marker=".", markersize=2.5,
            markeredgewidth=0.0, color="black")  # fmt: skip
    for start in PROTOCOLS[1:]:
        part = data.sel(start=start).isel(column=_elsewhere(data, start))
        colour, shape = _MARKS[start]
        ax.plot(
            part["b"], 50.0 * part["per_period"], linestyle="none", marker=shape, markersize=3.0,
            markeredgewidth=0.0, color=colour,
        )  # fmt: skip
    ax.set_ylabel("progression in 50 periods")


def _place_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    names = ("each column from rest", "another motion as b rises", "another as b falls")
    handles = [
        Line2D([], [], linestyle="none", marker=shape, color=colour, markersize=4.0, label=name,
               markeredgewidth=0.0)
        for name, (colour, shape) in zip(names, _MARKS.values(), strict=True)
    ]  # fmt: skip
    handles.append(
        Line2D([], [], color="0.45", linewidth=0.7, linestyle=(0, (4, 3)),
               label="widest periodic window")
    )  # fmt: skip
    figure.legend(
        handles=handles, loc="outside upper center", ncols=4, frameon=False, fontsize=7,
        title=rf"$\xi = {_XI:g}$, $\omega = {_OMEGA:g}$", title_fontsize=7,
    )  # fmt: skip
