"""Whether a motion that nothing drives is a torus, or still on its way to a cycle.

Where time stands in no equation, strobes of a cycle fill a closed curve, and those of a motion that
settles to it slowly a tube about that curve. A tube is a torus to the eye, and an exponent that is
small beside one over the duration of a window is zero to an average. Three things tell more.

Growth along a torus is the change of a smooth function of its phases, up to an exponent. Averages
of such changes with weights that vanish smoothly at both ends of a window fall with its length
faster than any power, so that an exponent stands out by many digits (S. Das, Y. Saiki, E. Sander
and J. A. Yorke, Quantitative quasiperiodicity, Nonlinearity 30, 4111-4140, 2017). The growth is
that of an area, one side of which is the way of the motion itself: a plane that holds this way
knows at once which exponent is beside it, while a single neighbour needs as long as the decay.

States next to each other lie along a line on a cycle, and scatter over a surface on a torus.

The tube of a motion that settles is thinner later, and a torus is not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

__all__ = ["KEPT", "MotionTube", "SteadyRate", "steady_rate"]

Floats = npt.NDArray[np.float64]

_ERRORS = 3.0  # of an average that a rate must keep from zero
_ROUNDING = 1e-9  # of the growth in a window
_NEIGHBOURS = 8  # states next to each other, of which a line or a surface is made
_LINE = 0.05  # width of neighbours on a line, beside their length
KEPT = 0.8  # of the width is left at least of what does not become thinner
_LEAST_SCALE = 1e-300


class SteadyRate(NamedTuple):
    """Growth per interval that is the same in all of a record, with its error."""

    rate: float
    error: float
    intervals: int

    @property
    def decays(self) -> bool:
        """Whether it is below zero by more than its error and rounding."""
        least = max(_ERRORS * self.error, _ROUNDING / self.intervals)
        return bool(np.isfinite(self.rate) and self.rate < -least)


def steady_rate(growth: Floats) -> SteadyRate:
    """Weighted average of the growth in K intervals; the error is that of either half.

    An average over all of them is better than that by many digits where the growth is that of a
    torus, and the halves of other motions differ.
    """
    if not np.all(np.isfinite(growth)):
        return SteadyRate(np.nan, np.inf, growth.size)
    whole, *halves = (_smooth_average(part) for part in (growth, *np.array_split(growth, 2)))
    return SteadyRate(whole, max(abs(half - whole) for half in halves), growth.size)


def _smooth_average(values: Floats) -> float:
    place = (np.arange(values.size) + 0.5) / values.size
    weights = np.exp(-1.0 / (place * (1.0 - place)))
    return float(weights @ values / weights.sum())


class MotionTube(NamedTuple):
    """How thick the set is in which states lie: medians over them."""

    width: float  # of neighbours, across the longest extent of them
    is_line: bool  # whether they are hardly wider than a line

    @staticmethod
    def of(states: Floats, unit: Floats) -> MotionTube:
        """That of some states (K, n), each in a unit of its own, (n,)."""
        scaled = states / np.maximum(unit, _LEAST_SCALE)
        _, near = KDTree(scaled).query(scaled, k=min(_NEIGHBOURS, len(scaled)))
        clouds = scaled[near] - scaled[near].mean(axis=1, keepdims=True)
        sizes = np.linalg.svd(clouds, compute_uv=False)
        if sizes.shape[1] < 2:
            return MotionTube(0.0, True)
        length, width = (np.median(sizes[:, k]) for k in (0, 1))
        return MotionTube(float(width), bool(width <= _LINE * length))
