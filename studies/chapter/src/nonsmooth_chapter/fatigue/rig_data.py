"""Data that sections 3.3 and 3.4 print for the two-mass rig, and runs of it shared by claims."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.models import fatigue_rig

__all__ = [
    "SET_24",
    "SET_25",
    "Stay",
    "phase_of_samples",
    "rig_system",
    "start_up",
    "stays",
    "steady",
]

SET_24: dict[str, Any] = {
    "eta": 3.0, "lambda1": 2.0, "lambda2": 2.0, "theta": 7.828, "eps": 0.002012, "f1": 3.75,
    "f2": 3.75, "xi_Ls": 0.00255, "xi_s": 0.002, "xi_p1": 0.4, "xi_p2": 0.4,
}  # fmt: skip
SET_25: dict[str, Any] = SET_24 | {
    "eta": 2.5,
    "lambda1": 4.36,
    "lambda2": 4.36,
    "f1": 5.44,
    "f2": 3.52,
}

Stay = tuple[str, float, float]  # phase, when it begins, when it ends


def rig_system(data: dict[str, Any] | None = None, **changes: float) -> System:
    """Two-mass rig with the data of a figure.

    Parameters
    ----------
    data : dict of str to float, optional
        `SET_24` or `SET_25`; the first if left out.
    **changes : float
        Changed parameters.

    Returns
    -------
    System

    Examples
    --------
    >>> rig_system(SET_25, f2=5.0).parameter_values["f2"]
    5.0
    """
    return fatigue_rig(**((SET_24 if data is None else data) | changes))


@lru_cache(maxsize=8)
def start_up(system: System, periods: int = 40, samples: int = 400) -> xr.Dataset:
    """Run of the rig from zero, the position of rest.

    Parameters
    ----------
    system : System
        The rig.
    periods, samples : int, optional
        Periods of the base, and samples in each.

    Returns
    -------
    xarray.Dataset
    """
    return simulate(system, periods=periods, samples_per_period=samples)


@lru_cache(maxsize=8)
def steady(system: System, dropped: int = 400, periods: int = 4, samples: int = 1000) -> xr.Dataset:
    """Run of the rig after many periods from zero.

    Parameters
    ----------
    system : System
        The rig.
    dropped : int, optional
        Periods before it.
    periods, samples : int, optional
        Periods of the base, and samples in each.

    Returns
    -------
    xarray.Dataset
    """
    begin = simulate(system, periods=dropped, samples_per_period=1)
    return simulate(system, begin, periods=periods, samples_per_period=samples)


def stays(run: xr.Dataset) -> list[Stay]:
    """Phases of a run in turn, with their beginning and end; those of no duration left out.

    Parameters
    ----------
    run : xarray.Dataset
        Run of the rig with its event log.

    Returns
    -------
    list of (str, float, float)

    Examples
    --------
    >>> [phase for phase, _, _ in stays(start_up(rig_system()))][:4]
    ['i', 'iii', 'iv', 'ii']
    """
    names = run["mode"].attrs["flag_meanings"].split()
    times = [float(run["time"][0]), *map(float, run["event_time"].values)]
    modes = [int(run["mode"][0]), *map(int, run["event_to"].values)]
    found: list[Stay] = []
    for mode, begin, end in zip(modes, times, [*times[1:], float(run["time"][-1])], strict=True):
        if end <= begin:
            continue
        if found and found[-1][0] == names[mode]:
            found[-1] = (names[mode], found[-1][1], end)
        else:
            found.append((names[mode], begin, end))
    return found


def phase_of_samples(run: xr.Dataset) -> np.ndarray:
    """Phase of each sample of a run.

    Parameters
    ----------
    run : xarray.Dataset
        Run of the rig.

    Returns
    -------
    numpy.ndarray
        Names.
    """
    return np.array(run["mode"].attrs["flag_meanings"].split())[run["mode"].values]
