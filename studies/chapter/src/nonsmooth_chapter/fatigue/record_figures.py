"""Simulated counterparts of the measured records: Figs. 16 and 17."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.fatigue.loaded_rig import (
    FREQUENCY,
    RECORDS,
    RIGS,
    base_amplitude,
    chaotic,
    harmonic,
)
from nonsmooth_chapter.fatigue.record_claims import chaotic_shaking

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig16", "fig17"]

_TEXT = 8
_SHOWN = ("base", "absolute1", "X3", "pneumatic1")
_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "black", "linewidth": 1.2},
    {"color": PALETTE["vermilion"], "linewidth": 1.2, "linestyle": "--"},
)
_OURS = (
    "The rig's data are ours: masses, springs, dampers from the parameters of Figs. 25, 24 with the"
    " chapter's\nspecimen; cylinders pressed to keep contact; crack of {crack:g} mm (ours); {more}."
)


def fig16(crack: float = 12.0, periods: int = 4) -> tuple[Figure, xr.Dataset]:
    """Fig. 16: simulated histories under harmonic shaking, mean load and amplitude 100 N at 20 Hz.

    The amplitude of the base is set at a crack of 6.4 mm and kept. The measured histories and the
    data of the rig are not in the chapter: which are ours is written in the figure.

    Parameters
    ----------
    crack : float, optional
        Length of the crack in mm.
    periods : int, optional
        Periods that are drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (d) of the chapter, two rigs.
    data : xarray.Dataset
        The records over ``rig`` and ``time``.

    Examples
    --------
    >>> figure, data = fig16(periods=1)
    >>> data["X3"].dims, data["X3"].attrs["units"]
    (('rig', 'time'), 'mm')
    """
    runs = [harmonic(name, crack, 100.0, periods=periods) for name in RIGS]
    data = _together(runs, crack)
    data.attrs["base_amplitude"] = [base_amplitude(name, 100.0) for name in RIGS]
    more = (
        "base "
        + " and ".join(f"{a:.2f}" for a in data.attrs["base_amplitude"])
        + " mm, for 100 N at 6.4 mm"
    )
    return _drawn(data, _OURS.format(crack=crack, more=more)), data


def fig17(crack: float = 10.0, drop: float = 6.0, shown: float = 0.6) -> tuple[Figure, xr.Dataset]:
    """Fig. 17: simulated histories under chaotic shaking, mean load zero.

    Parameters
    ----------
    crack : float, optional
        Length of the crack in mm.
    drop, shown : float, optional
        Time left out, and shown, in s.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (d) of the chapter, two rigs.
    data : xarray.Dataset
        The records over ``rig`` and ``time``.

    Examples
    --------
    >>> figure, data = fig17(drop=2.0, shown=0.1)
    >>> data.attrs["phases"]
    ['i', 'i']
    """
    runs = [chaotic(name, crack, 0.0, chaotic_shaking(name, 0.0), drop, 4) for name in RIGS]
    steps = int(np.searchsorted(runs[0]["time"].values, runs[0]["time"].values[0] + shown)) + 1
    data = _together([run.isel(time=slice(0, steps)) for run in runs], crack)
    data.attrs["phases"] = [str(run.attrs["phases"]) for run in runs]
    more = (
        "base: Ueda's Duffing wave,\nstrongest line 20 Hz, with the power of the sine that gives"
        " 100 N at 6.4 mm"
    )
    return _drawn(data, _OURS.format(crack=crack, more=more)), data


def _together(runs: list[xr.Dataset], crack: float) -> xr.Dataset:
    time = runs[0]["time"].values - float(runs[0]["time"][0])
    columns = {
        name: (("rig", "time"), np.stack([run[name].values for run in runs]),
               {"long_name": RECORDS[name], "units": runs[0][name].attrs["units"]})
        for name in (*_SHOWN, "load")
    }  # fmt: skip
    return xr.Dataset(
        columns,
        {"rig": list(RIGS),
         "time": ("time", time, {"long_name": "time", "units": "s"})},
        {"crack": crack, "frequency": FREQUENCY},
    )  # fmt: skip


def _drawn(data: xr.Dataset, note: str) -> Figure:
    figure, axes = print_figure(4, 1, width=16.0, height=19.0, share_x=True)
    for ax, name, letter in zip(axes, _SHOWN, "abcd", strict=True):
        for rig, style in zip(RIGS, _STYLES, strict=True):
            values = data[name].sel(rig=rig).values
            ax.plot(data["time"].values, values, label=f"rig of {rig}", **style)
        _finish(ax, f"({letter}) {RECORDS[name]}", str(data[name].attrs["units"]))
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(0.0, float(data["time"][-1]))
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False,
        fontsize=_TEXT,
    )  # fmt: skip
    figure.supxlabel(note, fontsize=7, ha="left", x=0.01)
    return figure


def _finish(ax: Axes, title: str, unit: str) -> None:
    ax.set_title(title, loc="left", fontsize=_TEXT)
    ax.set_ylabel(f"[{unit.replace('^2', '$^2$')}]")
    ax.axhline(0.0, color="0.75", linewidth=0.5, zorder=0)
