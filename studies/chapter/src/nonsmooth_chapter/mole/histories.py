"""Histories of the mole: Figs. 5(b), 5(d), 6 and 7.

The chapter prints the parameters; the spans of Figs. 5 and 6 are ours, and all runs start
from rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from nonsmooth import simulate
from nonsmooth.models import moling
from nonsmooth.plot import print_figure, time_history

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig5b", "fig5d", "fig6", "fig7"]

_FORCES = (0.05, 0.095, 0.1, 0.15, 0.19, 0.27)
_KEPT = ["p", "y", "q", "v", "x", "z", "mode"]
_ATTRIBUTES = ("system_name", "nonsmooth_version", "period", "tolerance")
_LABELS = {"x": "mass, x", "v": "slider bottom, v"}
_TEXT = 8  # points, as in the rest of the figure
_TIME, _DISPLACEMENT = r"time, $\tau$", "displacement"


def fig5b() -> tuple[Figure, xr.Dataset]:
    """Fig. 5(b): a = 0.5, omega = 0.11, xi = 0.35, b = 0.456.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The first ten periods from rest.
    data : xarray.Dataset
        The run.

    Examples
    --------
    >>> figure, data = fig5b()
    >>> data.attrs["status"]
    'completed'
    """
    return _test_history(b=0.456, xi=0.35, omega=0.11)


def fig5d() -> tuple[Figure, xr.Dataset]:
    """Fig. 5(d): a = 0.5, omega = 0.1, xi = 0.11, b = 0.48.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The first ten periods from rest.
    data : xarray.Dataset
        The run.

    Examples
    --------
    >>> figure, data = fig5d()
    >>> data.attrs["status"]
    'completed'
    """
    return _test_history(b=0.48, xi=0.11, omega=0.1)


def fig6() -> tuple[Figure, xr.Dataset]:
    """Fig. 6: from rest for six static forces, a = 0.3, omega = 0.1, xi = 0.05.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Six panels, tau from 0 to 1200.
    data : xarray.Dataset
        Trajectories over ``parameter`` and ``time``.

    Examples
    --------
    >>> figure, data = fig6()
    >>> data.sizes["parameter"], round(float(data["v"].max()))
    (6, 591)
    """
    return _six_forces(0.0, 1200.0)


def fig7() -> tuple[Figure, xr.Dataset]:
    """Fig. 7: the same histories for tau from 800 to 1200.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Six panels.
    data : xarray.Dataset
        Trajectories over ``parameter`` and ``time``.

    Examples
    --------
    >>> figure, data = fig7()
    >>> float(data["time"][0]) >= 800.0
    True
    """
    return _six_forces(800.0, 1200.0)


def _test_history(b: float, xi: float, omega: float) -> tuple[Figure, xr.Dataset]:
    run = simulate(moling(a=0.5, b=b, xi=xi, omega=omega), periods=10)
    figure, (ax,) = print_figure(width=12.0, height=6.5)
    _draw(run, ax, None)
    given = rf"$a = 0.5$, $b = {b:g}$, $\xi = {xi:g}$, $\omega = {omega:g}$"
    figure.suptitle(given, fontsize=_TEXT)
    return figure, run


def _draw(run: xr.Dataset, ax: Axes, span: tuple[float, float] | None, legend: bool = True) -> None:
    ax.set_xlabel(_TIME)
    ax.set_ylabel(_DISPLACEMENT)
    time_history(run, ["x", "v"], ax=ax, time_range=span, labels=_LABELS, legend=legend)


def _six_forces(began: float, ended: float) -> tuple[Figure, xr.Dataset]:
    figure, axes = print_figure(3, 2, width=16.0, height=17.0)
    kept = []
    for panel, (b, ax) in enumerate(zip(_FORCES, axes, strict=True)):
        run = simulate(moling(b=b), t_end=ended)
        _draw(run, ax, (began, ended), legend=False)
        ax.set_title(f"({'abcdef'[panel]}) b = {b:g}", loc="left", fontsize=_TEXT)
        if panel < 4:
            ax.set_xlabel("")
        if panel % 2:
            ax.set_ylabel("")
        part = run[_KEPT].sel(time=slice(began, ended))
        part.attrs = {name: run.attrs[name] for name in _ATTRIBUTES}
        kept.append(part.assign({name: run.attrs[name] for name in ("system", "status")}))
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=2,
        frameon=False,
        fontsize=_TEXT,
        title=r"$a = 0.3$, $\xi = 0.05$, $\omega = 0.1$",
        title_fontsize=_TEXT,
    )
    data = xr.concat(kept, "parameter")
    return figure, data.assign_coords(b=("parameter", list(_FORCES)))
