"""The rig as in a test: a cracked specimen under a mean load, shaken harmonically or chaotically.

The chapter gives no data of the rig in SI units. Ours: masses, springs and dampers that follow from
the parameters of Fig. 25 at 19.15 Hz with the chapter's specimen (`RIGS`: or from those of Fig. 24
at 20 Hz), forces of the cylinders large enough for contact, their difference set for the mean load.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import xarray as xr

from nonsmooth import simulate
from nonsmooth.excitation import Excitation
from nonsmooth.models import FatigueRig, set_load
from nonsmooth_chapter.fatigue.rig_data import SET_24
from nonsmooth_chapter.fatigue.rig_si_claims import rig_of_fig_25

__all__ = ["FREQUENCY", "RECORDS", "RIGS", "base_amplitude", "chaotic", "harmonic", "loaded_rig"]

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
