"""Records of the rig with its masses under harmonic and chaotic loads."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import simulate
from nonsmooth.excitation import Excitation
from nonsmooth.models import FatigueRig, set_load
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.fatigue.chaotic_loads import wave
from nonsmooth_chapter.fatigue.rig import SET_24
from nonsmooth_chapter.fatigue.rig_claims import rig_of_fig_25

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "FREQUENCY",
    "RECORDS",
    "RIGS",
    "base_amplitude",
    "chaotic",
    "chaotic_shaking",
    "fig16",
    "fig17",
    "harmonic",
    "loaded_rig",
]


# The rig as in a test: a cracked specimen under a mean load, shaken harmonically or chaotically.
#
# The chapter gives no data of the rig in SI units. Ours: masses, springs and dampers that follow
# from the parameters of Fig. 25 at 19.15 Hz with the chapter's specimen (`RIGS`: or from those of
# Fig. 24 at 20 Hz), forces of the cylinders large enough for contact, their difference set for the
# mean load.

FREQUENCY = 20.0  # Hz
START = 6.4  # mm, length at which the base amplitude of a test is set
RIGS = ("Fig. 25", "Fig. 24")
_PRELOAD = 900.0  # N, of mass 2; contact is verified in each run
_GRAVITY = 9.80665
RECORDS = {
    "base": "base acceleration",
    "absolute1": "acceleration of mass 1",
    "X3": "displacement of the specimen",
    "pneumatic1": "dynamic force of cylinder 1",
    "load": "load on the specimen",
}


def loaded_rig(name: str = RIGS[0], crack: float = START, mean: float = 100.0) -> FatigueRig:
    """Rig with a crack in its specimen and a mean load on it, at 20 Hz.

    Parameters
    ----------
    name : str, optional
        One of `RIGS`: whose parameters it has.
    crack : float, optional
        Length of the crack in mm.
    mean : float, optional
        Load at rest in N.

    Returns
    -------
    FatigueRig

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = loaded_rig(crack=10.0)
    >>> run = rig.to_si(ns.simulate(rig.system(), times=[0.0]))
    >>> round(float(run["load"][0]), 9)
    100.0
    """
    if name == "Fig. 25":
        rig = replace(rig_of_fig_25(), frequency=FREQUENCY)
    else:
        rig = FatigueRig.from_dimensionless(frequency=FREQUENCY, base_amplitude=1.0, **SET_24)
    rig = rig.cracked(crack)
    assert rig.open_stiffness is not None
    own = rig.open_stiffness if mean > 0.0 else rig.specimen_stiffness
    # gamma (2 k_Ls + k (1 + eps)) is the difference of the forces, and the load is k gamma
    soft = 2.0 * rig.leaf_stiffness + own * (1.0 + rig.leaf_stiffness / rig.contact_stiffness)
    weight = rig.mass * _GRAVITY
    return replace(
        rig,
        cylinder_force_1=_PRELOAD + mean * soft / own - weight,
        cylinder_force_2=_PRELOAD + weight,
    )


@lru_cache(maxsize=16)
def base_amplitude(name: str, mean: float, load: float = 100.0) -> float:
    """Amplitude of the base that gives a load amplitude at the first length of the crack.

    Parameters
    ----------
    name : str
        One of `RIGS`.
    mean, load : float
        Mean and amplitude of the load in N.

    Returns
    -------
    float
        In mm.
    """
    rig = loaded_rig(name, START, mean)
    return float(set_load(rig, load, crack=START)["base_amplitude"])


def harmonic(
    name: str, crack: float, mean: float, periods: int = 1, dropped: int = 400, samples: int = 512
) -> xr.Dataset:
    """Steady motion under the base amplitude that was set at the first length.

    Parameters
    ----------
    name : str
        One of `RIGS`.
    crack, mean : float
        Length of the crack in mm, mean load in N.
    periods, dropped, samples : int, optional
        Periods kept and left out, samples in each.

    Returns
    -------
    xarray.Dataset
        In SI units.
    """
    rig = replace(loaded_rig(name, crack, mean), base_amplitude=base_amplitude(name, mean))
    begin = simulate(rig.system(), periods=dropped, samples_per_period=1)
    return rig.to_si(simulate(rig.system(), begin, periods=periods, samples_per_period=samples))


def chaotic(
    name: str, crack: float, mean: float, record: Excitation, drop: float, finer: int = 1
) -> xr.Dataset:
    """Motion under a record of base acceleration, from rest.

    Parameters
    ----------
    name : str
        One of `RIGS`.
    crack, mean : float
        Length of the crack in mm, mean load in N.
    record : Excitation
        Base acceleration.
    drop : float
        What is left out first, in s.
    finer : int, optional
        Samples for each of the record's.

    Returns
    -------
    xarray.Dataset
        The records of `RECORDS` over ``time``, in SI units; attribute ``phases``.
    """
    rig = loaded_rig(name, crack, mean)
    knots, _ = record.closed()
    count = finer * (knots.size - 1) + 1
    seconds = np.interp(np.arange(count) / finer, np.arange(knots.size), knots)
    times = np.asarray(rig.from_si({"time": seconds})["time"])
    run = simulate(rig.system(record.as_signal()), times=times, t_start=float(times[0]))
    seen_in = run["mode"].attrs["flag_meanings"].split()
    found = rig.to_si(run)
    seen = {seen_in[int(number)] for name in ("event_to", "mode") for number in run[name].values}
    found = found[list(RECORDS)].isel(time=slice(int(np.searchsorted(seconds, drop)), None))
    found.attrs = {"phases": " ".join(sorted(seen)), "crack": crack, "mean_load": mean}
    return found


def chaotic_shaking(name: str, mean: float) -> Excitation:
    """The stated Duffing wave with the power of the harmonic shaking of a test.

    Parameters
    ----------
    name : str
        One of the rigs of `loaded_rig`.
    mean : float
        Mean load in N.

    Returns
    -------
    Excitation
    """
    omega = 2.0 * np.pi * FREQUENCY
    amplitude = 1e-3 * base_amplitude(name, mean) * omega**2
    return wave().scaled(amplitude / np.sqrt(2.0 * wave().power()))


# Simulated counterparts of the measured records: Figs. 16 and 17.

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
