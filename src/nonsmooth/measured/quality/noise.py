"""White noise and quantisation of a channel, and how long chance lets it stand still."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Noise", "longest_by_chance", "noise_of"]

Floats = npt.NDArray[np.float64]

_ORDERS = (5, 6)  # of differences that leave noise and hardly anything of a motion
_SHARE = 0.25  # of the differences, the smallest ones: impacts are among the others
_QUANTILE = 0.318639363964375  # of the size of a standard normal variable, for that share
_WHITE = 1.25  # largest ratio between the estimates of both orders where noise is white
_UNSURE = 0.05  # of an estimate, from its own scatter
_ROUNDING = 1e-9  # of the range; recorders have coarser steps, and what is below is arithmetic
_SEEN = 0.35  # of a step of the recorder; less noise cannot be told from rounding
_FEWEST_EQUAL = 3  # samples in a row that are told as equal at all


class Noise(NamedTuple):
    """Noise of a channel."""

    deviation: float  # standard deviation, quantisation included
    step: float  # between neighbouring values of the recorder
    visible: bool  # whether noise moves the last digit of a channel at rest

    @property
    def least(self) -> float:
        """Standard deviation of what was there before quantisation, from below."""
        before = (self.deviation * (1.0 - _UNSURE)) ** 2 - self.step**2 / 12.0
        found = math.sqrt(max(before, 0.0))
        return found if self.visible and found > _SEEN * self.step else 0.0

    @property
    def most(self) -> float:
        """Standard deviation with quantisation, from above."""
        return max(self.deviation * (1.0 + _UNSURE), self.step / math.sqrt(12.0))


def noise_of(values: Floats) -> Noise:
    """Noise of readings, some of which may be nan.

    Differences of white noise of all orders tell the same deviation. Those of a sampled motion
    fall or grow with the order: then there is no noise to be seen.
    """
    finite = values[np.isfinite(values)]
    levels = np.unique(finite)
    apart = np.diff(levels)
    apart = apart[apart > _ROUNDING * np.ptp(levels)] if levels.size > 1 else apart
    step = float(apart.min()) if apart.size else 0.0
    found = [_deviation(values, order) for order in _ORDERS]
    if min(found) <= 0.0:
        return Noise(max(found), step, False)
    white = 1.0 / _WHITE < found[1] / found[0] < _WHITE
    return Noise(found[1], step, white)


def _deviation(values: Floats, order: int) -> float:
    with np.errstate(invalid="ignore"):
        moves = (np.diff(values) != 0.0).astype(float)
        differences = np.abs(np.diff(values, order))
    # where all samples are equal there is no noise to be learned: those may be frozen
    alive = np.convolve(moves, np.ones(order), "valid") > 0.0
    differences = differences[np.isfinite(differences) & alive]
    if differences.size < 8:
        return 0.0
    gain = math.sqrt(math.comb(2 * order, order))
    return float(np.quantile(differences, _SHARE)) / _QUANTILE / gain


def longest_by_chance(noise: Noise, count: int, rate: float) -> float:
    """Samples in a row that may be equal by chance in a channel at rest.

    White noise of standard deviation s before rounding to steps q gives the same value L times
    in a row with the probability sum P_k^L, P_k that of the step k. The expected number of such
    runs among all samples is at most ``rate``. A moving channel has shorter runs. Infinite where
    noise does not show.
    """
    if not noise.visible or noise.least <= 0.0:
        return math.inf
    shares = _shares(noise.step / noise.least)
    if shares.max() >= 1.0:
        return math.inf
    low, high = 1, 2 * count
    if _expected(shares, high, count) > rate:
        return math.inf
    while low < high:
        middle = (low + high) // 2
        low, high = (
            (low, middle) if _expected(shares, middle, count) <= rate else (middle + 1, high)
        )
    return max(low, _FEWEST_EQUAL) - 1


def _shares(step: float) -> Floats:
    """Probabilities of the steps, by rows: a level in the middle of one, and between two."""
    from scipy.special import ndtr

    reach = math.ceil(6.0 / step) if step > 1e-3 else 0
    if reach == 0:  # so fine that all but a few samples differ
        return np.full((2, 1), step / math.sqrt(2.0 * math.pi))
    k = np.arange(-reach, reach + 1)
    rows = [ndtr((k + 0.5 - at) * step) - ndtr((k - 0.5 - at) * step) for at in (0.0, 0.5)]
    return np.array(rows)


def _expected(shares: Floats, length: int, count: int) -> float:
    # in a fine grid many steps have nearly the same share, and one row stands for all of them
    many = 1.0 / max(float(shares.max()), 1e-300) if shares.shape[1] == 1 else 1.0
    return count * many * float((shares**length).sum(axis=1).max())
