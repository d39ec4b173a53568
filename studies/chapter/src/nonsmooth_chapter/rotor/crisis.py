"""Whether a chaotic set meets an unstable orbit where it ends: the mark of a boundary crisis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from nonsmooth import System, continue_orbit, ensemble
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.rotor.coexistence import coexisting

__all__ = ["meeting_with_unstable_orbits"]

_ROTOR = ("x", "y", "vx", "vy")
_STEPS, _STEP = 60, 0.01  # of a branch either way, and of eta
_STROBES = 4000


def meeting_with_unstable_orbits(
    system: System, state: Mapping[str, float], inside: float, beyond: float
) -> list[Evidence]:
    """Distance of a chaotic set from the unstable orbits on the branches of what is left behind it.

    Parameters
    ----------
    system : System
        The rotor.
    state : mapping of str to float
        A state of the chaotic set.
    inside, beyond : float
        Last eta with the set, and one at which it is gone.

    Returns
    -------
    list of dict
        For each branch that has an unstable orbit at ``inside``: its ``period``, and the least
        ``distance`` of a strobe of the set from one of the orbit, beside the width of the set.
    """
    there = system.with_parameters(eta=inside)
    strobes = _points(ensemble(there, dict(state), record=_STROBES).isel(lane=0))
    size = float(np.ptp(strobes, axis=0).max())
    rows = []
    for motion in coexisting(system.with_parameters(eta=beyond), 12):
        if not motion["period"]:
            continue
        branch = continue_orbit(
            system.with_parameters(eta=beyond), "eta", (inside - 0.1, beyond + 0.05),
            initial=motion["state"], period=motion["period"], steps=_STEPS, step=_STEP,
            largest_step=_STEP,
        )  # fmt: skip
        for place in _crossings(branch, inside):
            orbit = _points(branch.isel(point=place))
            apart = np.abs(strobes - orbit).max(axis=1).min()
            rows.append({"period": motion["period"], "distance": float(apart) / size})
    return rows


def _points(data: xr.Dataset) -> np.ndarray:
    return np.stack([data[name].values for name in _ROTOR], axis=-1)


def _crossings(branch: xr.Dataset, eta: float) -> list[int]:
    """Unstable points of a branch next to a value."""
    side = branch["eta"].values > eta
    places = np.flatnonzero(side[1:] != side[:-1])
    return [int(k) for k in places if not bool(branch["stable"].values[k])]
