"""Orbits of the rig at 13.1 Hz in both directions: Fig. 42(b), (d)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth import regime, simulate
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.rotor.data import rig
from nonsmooth_chapter.rotor.ring_motion import in_contact
from nonsmooth_chapter.rotor.speed_sweeps import last_strobe

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["fig42"]

_SPEED = 13.1
_TEXT = 8


def fig42(transient: int = 1000, samples: int = 500) -> tuple[Figure, xr.Dataset]:
    """Fig. 42: velocity over displacement in x and in y at 13.1 Hz, the model's part.

    Parameters
    ----------
    transient : int, optional
        Periods left out, from zero.
    samples : int, optional
        Samples per period.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (b) and (d) of the chapter; the thick parts are in contact with the ring.
    data : xarray.Dataset
        The run over one period of the motion, in mm and mm/s.

    Examples
    --------
    >>> figure, data = fig42(transient=200, samples=50)
    >>> data["vx"].attrs["units"], data.attrs["period_of_motion"]
    ('mm/s', 1)
    """
    machine = rig(speed=_SPEED)
    system = machine.system()
    period = int(regime(system, transient=transient)["period"]) or 8
    run = machine.to_si(
        simulate(system, last_strobe(system, transient), periods=period, samples_per_period=samples)
    )
    run.attrs["period_of_motion"] = period
    figure, axes = print_figure(1, 2, width=16.0, height=7.0)
    touching = in_contact(run)
    for ax, axis, letter in zip(axes, "xy", "bd", strict=True):
        place, velocity = run[axis].values, run[f"v{axis}"].values
        ax.plot(place, velocity, color="black", linewidth=0.9, label="free")
        ax.plot(
            np.where(touching, place, np.nan), np.where(touching, velocity, np.nan),
            color=PALETTE["vermilion"], linewidth=2.2, label="in contact",
        )  # fmt: skip
        ax.plot(place[0], velocity[0], "o", color=PALETTE["blue"], markersize=3.5, label="strobe")
        ax.set_xlabel(f"displacement in {axis} [mm]")
        ax.set_ylabel(f"velocity in {axis} [mm/s]")
        ax.set_title(f"({letter}) {_SPEED:g} Hz, period {period}", loc="left", fontsize=_TEXT)
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False,
        fontsize=_TEXT,
    )  # fmt: skip
    return figure, run
