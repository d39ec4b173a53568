"""Where a life ends: at the last length, or at fracture before it."""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.fatigue.growth_rate import Loads, StressIntensity, block_at, intensity
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable

__all__ = ["final_length", "largest_load"]

_STEPS = 400  # of the search for the first length at which the toughness is reached


def largest_load(loads: Loads, crack: float) -> float:
    """Largest load at a length of the crack, in N."""
    if isinstance(loads, LoadBlock):
        return loads.largest
    if isinstance(loads, LoadTable):
        return max(block.largest for _, block in loads.at(crack))
    return block_at(loads, crack).largest


def final_length(
    stress_intensity: StressIntensity,
    loads: Loads,
    first: float,
    last: float,
    toughness: float | None,
) -> tuple[float, str]:
    """Length at which a life ends, and why."""
    if toughness is None:
        return last, "final length"

    def excess(crack: float) -> float:
        load = np.array([largest_load(loads, crack)])
        return float(intensity(stress_intensity, load, np.array([crack]))[0]) - toughness

    if excess(first) >= 0.0:
        raise OptionError(
            f"at the first length, {first:g} mm, the largest load already gives"
            f" {excess(first) + toughness:.4g} MPa sqrt(m), above the toughness of {toughness:g}"
        )
    before = first
    for crack in np.linspace(first, last, _STEPS + 1)[1:]:
        if excess(float(crack)) >= 0.0:
            break
        before = float(crack)
    else:
        return last, "final length"
    from scipy.optimize import brentq

    found = brentq(excess, before, float(crack), xtol=1e-14, rtol=1e-15)
    return float(found), "fracture"
