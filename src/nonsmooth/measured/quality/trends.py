"""Drift: a mean that moves, against its uncertainty; and a mean that runs away."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.flaw import Flaw, Readings

__all__ = ["trend_findings"]

Floats = npt.NDArray[np.float64]

_BLOCKS = 24  # whose means are compared
_FEWEST_BLOCKS = 8
_CYCLES = 6.0  # of the slowest strong motion in a block, so that its window takes it off
_DEGREE = 2  # of the curve of a drift: an integrated offset is a parabola
_TAKEN_OFF = 4  # degree of what is taken for a trend and no motion
_FEWEST = 16  # samples of a block
_STRONG = 0.01  # of the power is in what is slower than the slowest strong motion


def trend_findings(data: Readings) -> Iterator[Flaw]:
    """Trend of the means of blocks of a channel."""
    good = np.isfinite(data.values)
    values = np.where(good, data.values, np.nanmean(data.values) if good.any() else 0.0)
    means, ranges, middles = _blocks(values, data)
    if means.size < _FEWEST_BLOCKS:
        return
    change, chance = _change(means, middles)
    if not chance < data.rate or abs(change) <= data.noise.most:
        return
    typical = float(np.median(ranges))
    away = abs(change) > typical
    what = (
        f"by more than the motion itself, {data.size(typical)}: the motion progresses, or an"
        " integral runs away"
        if away
        else f"beside a motion of {data.size(typical)}, from largest to smallest"
    )
    yield Flaw(
        data.name, "runaway" if away else "drift", *data.span, data.values.size, change,
        f"the mean of {data.name} moves by {data.size(change)} over the record, {what}",
    )  # fmt: skip


def _change(means: Floats, middles: Floats) -> tuple[float, float]:
    """Change along a parabola through the means, and the chance that there is none.

    Means of blocks that follow each other are correlated by slow motions: as those of a process
    of first order, whose correlation is estimated.
    """
    from scipy.stats import f as fisher

    place = 2.0 * (middles - middles[0]) / (middles[-1] - middles[0]) - 1.0
    powers = np.polynomial.legendre.legvander(place, _DEGREE)
    curve = powers @ np.linalg.lstsq(powers, means, rcond=None)[0]
    left = means - curve
    free = means.size - _DEGREE - 1
    total, told = float(left @ left), float(((curve - means.mean()) ** 2).sum())
    # over the record, and not from the middle of the first block to that of the last one
    change = math.copysign(float(np.ptp(curve)), curve[-1] - curve[0])
    change *= means.size / (means.size - 1.0)
    if total <= 0.0:
        return change, 0.0 if told else 1.0
    # the estimate is too low by about 2 / n, for what the curve takes off
    rho = float(left[1:] @ left[:-1]) / total + 2.0 / means.size
    rho = min(max(rho, 0.0), 0.9)
    larger = (1.0 + rho) / (1.0 - rho)
    return change, float(fisher.sf(told / _DEGREE / (total / free * larger), _DEGREE, free))


def _blocks(values: Floats, data: Readings) -> tuple[Floats, Floats, Floats]:
    """Weighted mean and range of blocks, and their middles in time.

    The weights leave less than 3e-5 of what turns several times within a block, so a motion need
    not fit into a block in whole cycles.
    """
    from scipy.signal.windows import blackmanharris

    longest = values.size // _FEWEST_BLOCKS
    cycle = _slowest_cycle(values)
    length = max(math.ceil(_CYCLES * cycle), values.size // _BLOCKS, _FEWEST)
    if length > longest:
        return np.empty(0), np.empty(0), np.empty(0)
    count = values.size // length
    table = values[: count * length].reshape(count, length)
    weights = blackmanharris(length)
    means = table @ (weights / weights.sum())
    middles = data.times[: count * length].reshape(count, length).mean(axis=1)
    return means, np.ptp(table, axis=1), middles


def _slowest_cycle(values: Floats) -> float:
    """Samples of a cycle of the slowest motion that matters, a slow trend taken off."""
    from scipy.signal import periodogram

    place = np.linspace(-1.0, 1.0, values.size)
    powers = np.polynomial.legendre.legvander(place, _TAKEN_OFF)
    left = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
    frequencies, power = periodogram(left, window="hann")
    power[:3] = 0.0  # what is left of a trend
    total = power.sum()
    if total <= 0.0:
        return 2.0
    share = np.cumsum(power) / total
    return 1.0 / float(frequencies[int(np.searchsorted(share, _STRONG))] or frequencies[1])
