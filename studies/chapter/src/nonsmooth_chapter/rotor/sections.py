"""Sections of the rotor's motion at strobes: Fig. 37."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import stroboscopic_map
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.rotor.data import set_a

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["PANELS", "fig37"]

# Preload and eta of the four panels as printed, and for (a) and (b) the eta of the other one.
PANELS = {"a": (0.0, 2.223), "b": (0.1, 2.181), "c": (0.0, 2.442), "d": (0.1, 2.442)}
_EXCHANGED = {"a": 2.181, "b": 2.223}
_TEXT = 8


def fig37(transient: int = 1000, record: int = 8000) -> tuple[Figure, xr.Dataset]:
    """Fig. 37: velocity over displacement at strobes, from zero, for the four pairs printed.

    Parameters
    ----------
    transient, record : int, optional
        Periods left out and drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (d). In (a) and (b) orange points belong to the eta printed for the other of
        the two panels.
    data : xarray.Dataset
        ``x`` and ``vx`` over ``panel``, ``reading`` ("printed", "exchanged") and ``point``, and
        their ``eta``; nan where there is no other reading.

    Examples
    --------
    >>> figure, data = fig37(transient=50, record=20)
    >>> data["x"].dims, len(figure.axes)
    (('panel', 'reading', 'point'), 4)
    """
    from matplotlib.artist import setp

    figure, axes = print_figure(2, 2, width=16.0, height=13.0)
    readings = ("printed", "exchanged")
    shape = (len(PANELS), len(readings))
    values = {name: np.full((*shape, record), np.nan) for name in ("x", "vx")}
    etas = np.full(shape, np.nan)
    for row, (ax, (panel, (delta, printed))) in enumerate(zip(axes, PANELS.items(), strict=True)):
        for column, eta in enumerate((printed, _EXCHANGED.get(panel))):
            if eta is None:
                continue
            found = stroboscopic_map(set_a(delta, eta), transient=transient, record=record)
            few = np.unique(found["x"].values.round(9)).size < 20
            ax.plot(
                found["x"], found["vx"], linestyle="none", rasterized=True,
                marker="o" if column == 0 else "^", markeredgewidth=0.0,
                markersize=5.0 if few else 0.7, label=rf"$\eta$ = {eta:g}, {readings[column]}",
                color=("black", PALETTE["vermilion"])[column],
            )  # fmt: skip
            etas[row, column] = eta
            for name, array in values.items():
                array[row, column] = found[name].values
        ax.set_title(
            rf"({panel}) $\Delta_x = \Delta_y = {delta:g}$, $\eta = {printed:g}$",
            loc="left", fontsize=_TEXT,
        )  # fmt: skip
        if panel in _EXCHANGED:
            key = ax.legend(frameon=False, fontsize=7, loc="best")
            for handle in filter(None, key.legend_handles):
                setp(handle, markersize=4.0)
        ax.set_xlabel(r"displacement, $x_r/\gamma$" if row > 1 else "")
        ax.set_ylabel(r"velocity, $v_{x_r}$" if row % 2 == 0 else "")
    over = ("panel", "reading", "point")
    names = {"x": "displacement of the rotor in x", "vx": "velocity of the rotor in x"}
    data = xr.Dataset(
        {name: (over, array, {"long_name": names[name]}) for name, array in values.items()}
        | {"eta": (over[:2], etas, {"long_name": "frequency ratio"})},
        {"panel": list(PANELS), "reading": list(readings)},
        {"transient": transient, "record": record},
    )
    return figure, data
