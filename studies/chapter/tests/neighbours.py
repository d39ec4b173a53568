"""Largest exponent of the mole from pairs of runs that start a small distance apart."""

from __future__ import annotations

import numpy as np

import nonsmooth as ns
from nonsmooth_chapter.mole.sweeps import bounded_states

__all__ = ["neighbour_exponent"]

# The offset is far above rounding, and small after its growth.
_PAIRS, _OFFSET, _TURNED, _GROWN = 60, 1e-10, 2, 3


def neighbour_exponent(system: ns.System, transient: int, record: int) -> tuple[float, float]:
    """Mean growth of a small distance, per period, along the free flights of a motion from rest."""
    run = ns.simulate(system, periods=transient + record, samples_per_period=1)
    strobes = run.isel(time=slice(transient, None))
    # the distance turns to the direction of growth within the first periods
    flights = np.flatnonzero(strobes["mode"].values == 0)
    growth = []
    for k in flights[:: max(1, len(flights) // _PAIRS)]:
        start = {name: float(strobes[name][k]) for name in "pyq"}
        ends = [
            bounded_states(
                ns.simulate(
                    system,
                    start | {"y": start["y"] + offset},
                    periods=_TURNED + _GROWN,
                    samples_per_period=1,
                )
            )
            for offset in (0.0, _OFFSET)
        ]
        distance = np.abs(ends[1] - ends[0]).max(axis=1)
        if distance[_TURNED] > 0.0 and distance[-1] > 0.0:
            growth.append(np.log(distance[-1] / distance[_TURNED]) / _GROWN)
    return float(np.mean(growth)), float(np.std(growth, ddof=1) / np.sqrt(len(growth)))
