"""Resistance of the soil over the penetration of a tool: Fig. 3(b).

The chapter draws it without numbers. Here it is that of the slider that the chapter describes, in
units of the friction limit, pushed in and drawn back by a prescribed displacement, and under the
mole itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import simulate
from nonsmooth.models import moling
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.mole.soil_claims import pushed_slider

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig3b"]

_TEXT = 8
_SLOW, _RATES = 1e-4, (1.0, 4.0)
_DEPTH = 2.5
_SAMPLES = 2000
_SETTLED = 40  # periods; the motion of Fig. 7(d) settles to rounding within twenty
_LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "black", "linewidth": 1.6},
    {"color": PALETTE["blue"], "linewidth": 1.1},
    {"color": PALETTE["vermilion"], "linewidth": 1.1, "linestyle": "-."},
)
_MOLE: dict[str, Any] = {"color": "#7A2060", "linewidth": 1.6}
_LAW: dict[str, Any] = {"color": "0.6", "linewidth": 3.2, "linestyle": (0, (2, 1))}


def fig3b(xi: float = 0.05, b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Fig. 3(b): resistance of the slider over penetration, quasi-static and dynamic.

    Parameters
    ----------
    xi : float, optional
        Damping of the slider; the chapter prints none for this figure, that of Fig. 7 is taken.
    b : float, optional
        Static force on the mole of the right panel; a = 0.3 and omega = 0.1 as in Fig. 7.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Pushes of prescribed displacement, in and back: slow, and fast enough for the damper to be
        felt; one impact of the mole in its settled motion, its beginning and its end. Broken: the
        elasto-plastic law without damper, min(penetration, 1) on the way in.
    data : xarray.Dataset
        ``penetration`` and ``resistance`` over ``rate`` and ``sample``; ``mole_penetration`` and
        ``mole_resistance`` over ``mole_sample``.

    Examples
    --------
    >>> figure, data = fig3b()
    >>> float(data["resistance"].max()), round(float(data["mole_resistance"].max()), 12)
    (1.0, 1.0)
    """
    rates = (_SLOW, *_RATES)
    pushes = [
        simulate(pushed_slider(xi, rate, _DEPTH), periods=1, samples_per_period=_SAMPLES)
        for rate in rates
    ]
    impact = _impact(xi, b)
    figure, axes = print_figure(1, 3, width=16.0, height=7.5)
    deepest = float(impact["penetration"].max())
    _draw_law(axes[0], _DEPTH)
    for rate, run, look in zip(rates, pushes, _LOOKS, strict=True):
        name = "quasi-static push" if rate == _SLOW else f"push at rate {rate:g}"
        axes[0].plot(run["penetration"], run["resistance"], label=name, **look)
    for ax in axes[1:]:
        _draw_law(ax, deepest)
        ax.plot(impact["penetration"], impact["resistance"], label="mole", **_MOLE)
    axes[1].set_xlim(-0.05, 1.75)
    axes[2].set_xlim(deepest - 1.75, deepest + 0.05)
    titles = (f"(a) push of depth {_DEPTH:g}, and back", f"(b) mole, b = {b:g}: its impact",
              "(c) mole: its release")  # fmt: skip
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title, loc="left", fontsize=_TEXT)
        ax.set_xlabel("penetration [$P_f/k$]")
        ax.set_ylabel("resistance [$P_f$]" if ax is axes[0] else "")
        ax.set_ylim(-0.05, 1.1)
    lines = [*axes[0].get_lines(), axes[1].get_lines()[-1]]
    figure.legend(handles=lines, loc="outside upper center", ncols=5, frameon=False, fontsize=7,
                  columnspacing=1.2)  # fmt: skip
    return figure, _dataset(xi, b, rates, pushes, impact)


def _impact(xi: float, b: float) -> xr.Dataset:
    """Resistance over penetration from one impact of the settled mole to its release."""
    system = moling(b=b, xi=xi)
    settled = simulate(system, simulate(system, periods=_SETTLED), periods=2)
    names = settled["event_name"].values
    hits = settled["event_time"].values[names == "impact"]
    leaves = settled["event_time"].values[settled["event_to"].values == 0]
    began = float(hits[0])
    ended = float(leaves[leaves > began][0])
    times = np.linspace(began, ended, _SAMPLES + 1)
    # samples stand closer where contact begins, for the resistance rises in a twentieth of it
    near = began + (ended - began) * np.geomspace(1e-6, 0.1, _SAMPLES)
    start = simulate(system, periods=_SETTLED)
    run = simulate(system, start, times=np.unique(np.concatenate([times, near, [began - 1.0]])))
    depth = run["x"].values - float(run["x"].sel(time=began, method="nearest"))
    touching = run["mode"].values != 0
    force = np.where(
        touching, np.minimum(2.0 * xi * run["y"].values + run["q"].values, 1.0), 0.0
    )  # in progression the slider slips at its limit
    # at the instant of the impact the resistance jumps to what the damper takes
    depth[0], force[0] = 0.0, 0.0
    return xr.Dataset(
        {"penetration": ("sample", depth), "resistance": ("sample", force)},
        attrs={"status": settled.attrs["status"]},
    )


def _draw_law(ax: Axes, depth: float) -> None:
    """Elasto-plastic law: elastic up to the friction limit, slip, elastic on the way back."""
    ax.plot(
        [0.0, 1.0, depth, depth - 1.0], [0.0, 1.0, 1.0, 0.0], label="law without damper", **_LAW
    )


def _dataset(
    xi: float, b: float, rates: tuple[float, ...], pushes: list[xr.Dataset], impact: xr.Dataset
) -> xr.Dataset:
    over = ("rate", "sample")
    depth = {"long_name": "penetration of the tool", "units": "P_f/k"}
    force = {"long_name": "resistance of the slider", "units": "P_f"}
    return xr.Dataset(
        {
            "penetration": (over, np.stack([run["penetration"].values for run in pushes]), depth),
            "resistance": (over, np.stack([run["resistance"].values for run in pushes]), force),
            "mole_penetration": ("mole_sample", impact["penetration"].values, depth),
            "mole_resistance": ("mole_sample", impact["resistance"].values, force),
        },
        {"rate": ("rate", list(rates), {"long_name": "angular frequency of the push"})},
        {
            "xi": xi, "b": b, "depth": _DEPTH, "status": impact.attrs["status"],
            "note": "the chapter draws this figure without numbers",
            "nonsmooth_version": pushes[0].attrs["nonsmooth_version"],
        },
    )  # fmt: skip
