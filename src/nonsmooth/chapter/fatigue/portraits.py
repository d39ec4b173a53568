"""Phase portraits of the beam at four crack ratios, by both stiffness laws: Fig. 28."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.chapter.fatigue.beam_data import ETA, WIDTH, XI, turn
from nonsmooth.chapter.fatigue.crack_motions import period_of
from nonsmooth.models import breathing_crack

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["LAWS", "RATIOS", "closed_arcs", "portrait_beam", "settled_orbit"]

RATIOS = (0.32, 0.5, 0.7, 0.9)
LAWS: tuple[Literal["cubic", "guinea"], ...] = ("cubic", "guinea")
_DROPPED, _LOOKED = 2000, 64  # periods from rest, and strobes in which a period is sought
_MOST = 8  # periods of an orbit that are drawn
_SAMPLES = 1000  # per period


def portrait_beam(
    ratio: float, law: Literal["cubic", "guinea"] = "cubic", **parameters: float
) -> System:
    """Beam with a crack ratio of Fig. 28 and the convention for what the chapter lacks.

    Parameters
    ----------
    ratio : float
        Length of the crack beside the width of the specimen.
    law : {"cubic", "guinea"}, optional
        Open stiffness over the length of the crack.
    **parameters : float
        Changed parameters.

    Returns
    -------
    System

    Examples
    --------
    >>> portrait_beam(0.5).parameter_values["crack"]
    10.0
    """
    system = breathing_crack(xi=XI, eta=ETA, crack=round(ratio * WIDTH, 9), law=law)
    return system.with_parameters(**parameters)


@lru_cache(maxsize=32)
def settled_orbit(system: System) -> xr.Dataset:
    """Orbit that the beam settles to from rest.

    Parameters
    ----------
    system : System
        The beam.

    Returns
    -------
    xarray.Dataset
        Run over one period of the motion, or over 8 of the forcing where it has none; attribute
        ``period_of_motion``.

    Examples
    --------
    >>> settled_orbit(portrait_beam(0.32)).attrs["period_of_motion"]
    1
    """
    run = simulate(system, periods=_DROPPED + _LOOKED, samples_per_period=1, events=False)
    points = np.stack([run["u"].values, run["v"].values], axis=1)
    period = period_of(points[-_LOOKED:], _LOOKED // 2)
    start = {"u": points[-1, 0], "v": points[-1, 1]}
    orbit = simulate(system, start, periods=period or _MOST, samples_per_period=_SAMPLES)
    orbit.attrs["period_of_motion"] = period
    return orbit


def closed_arcs(orbit: xr.Dataset) -> np.ndarray:
    """Points of an orbit in the phase plane while the crack is closed.

    Parameters
    ----------
    orbit : xarray.Dataset
        Run of the beam.

    Returns
    -------
    numpy.ndarray
        Deflection and velocity, one row for each sample.

    Examples
    --------
    >>> bool((closed_arcs(settled_orbit(portrait_beam(0.32)))[:, 0] <= 0.0).all())
    True
    """
    here = orbit["u"].values <= 0.0
    return np.stack([orbit["u"].values[here], orbit["v"].values[here]], axis=1)
