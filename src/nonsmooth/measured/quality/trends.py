"""Drift: a mean that moves, against its uncertainty; and a mean that runs away."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.finding import Finding, Samples

__all__ = ["trend_findings"]

Floats = npt.NDArray[np.float64]

_BLOCKS = 24  # whose means are compared
_FEWEST_BLOCKS = 8
_CYCLES = 6.0  # of the slowest strong motion in a block, so that its window takes it off
_FEWEST = 16  # samples of a block
_STRONG = 0.01  # of the power is in what is slower than the slowest strong motion


def trend_findings(data: Samples) -> Iterator[Finding]:
    """Trend of the means of blocks of a channel."""
    good = np.isfinite(data.values)
    values = np.where(good, data.values, np.nanmean(data.values) if good.any() else 0.0)
    means, ranges, middles = _blocks(values, data)
    if means.size < _FEWEST_BLOCKS:
        return
    change, chance = _change(means, middles, data.span)
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
    yield Finding(
        data.name, "runaway" if away else "drift", *data.span, data.values.size, change,
        f"the mean of {data.name} moves by {data.size(change)} over the record, {what}",
    )  # fmt: skip


def _change(means: Floats, middles: Floats, span: tuple[float, float]) -> tuple[float, float]:
    """Change along a straight line over the record, and the chance that there is none.

    Means of blocks that follow each other are correlated by slow motions: as those of a process
    of first order, whose correlation is estimated.
    """
    from scipy.stats import t as student

    place = middles - middles.mean()
    slope = float(place @ means / (place @ place))
    left = means - means.mean() - slope * place
    free = means.size - 2
    total = float(left @ left)
    length = span[1] - span[0]
    if total <= 0.0:
        return slope * length, 0.0 if slope else 1.0
    # the estimate is too low by about (1 + 4 rho) / n, for what a line takes off
    rho = float(left[1:] @ left[:-1]) / total + 2.0 / means.size
    rho = min(max(rho, 0.0), 0.9)
    error = math.sqrt(total / free / float(place @ place) * (1.0 + rho) / (1.0 - rho))
    return slope * length, 2.0 * float(student.sf(abs(slope) / error, free))


def _blocks(values: Floats, data: Samples) -> tuple[Floats, Floats, Floats]:
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
    """Samples of a cycle of the slowest motion that matters, with a straight line taken off."""
    from scipy.signal import detrend, periodogram

    frequencies, power = periodogram(detrend(values), window="hann")
    # a trend that is no straight line is in the first lines, and is what is looked for
    power[:3] = 0.0
    total = power.sum()
    if total <= 0.0:
        return 2.0
    share = np.cumsum(power) / total
    return 1.0 / float(frequencies[int(np.searchsorted(share, _STRONG))] or frequencies[1])
