"""Smoothed motions beside the exact one: distance, time on surfaces, creep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.smoothing.ladder import Ladder, Stretch
from nonsmooth.analysis.smoothing.stick_times import bands_of, creep_beside, time_beside, time_on

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["compared_motions"]


def compared_motions(
    ladder: Ladder, stretch: Stretch, exact: xr.Dataset, runs: list[xr.Dataset], band: float
) -> dict[str, Any]:
    """Variables of the report that come from the motions."""
    system, count = ladder.exact, ladder.epsilons.size
    surfaces = bands_of(system)
    start, stop = float(stretch.times[0]), float(stretch.times[-1])
    error = np.full((count, len(system.states)), np.nan)
    beside, creep = np.full((2, count, len(surfaces)), np.nan)
    for i, (epsilon, run) in enumerate(zip(ladder.epsilons, runs, strict=True)):
        if run.attrs["status"] != "completed":
            continue
        for k, state in enumerate(system.states):
            error[i, k] = np.abs(run[state].values - exact[state].values).max()
        for k, surface in enumerate(surfaces):
            beside[i, k] = time_beside(ladder.soft, run, system, surface, band * epsilon)
            creep[i, k] = creep_beside(run, system, exact, surface)
    on = np.array([time_on(exact, surface, start, stop) for surface in surfaces])
    over = ("epsilon", "surface")
    return {
        "surface": ("surface", np.array([s.name for s in surfaces], str)),
        "state": ("state", np.array(system.states)),
        "status": ("epsilon", np.array([run.attrs["status"] for run in runs], str)),
        "error": (("epsilon", "state"), error),
        "stick_time_exact": ("surface", on),
        "stick_time": (over, beside),
        "stick_time_error": (over, beside - on),
        "creep": (over, creep),
    }
