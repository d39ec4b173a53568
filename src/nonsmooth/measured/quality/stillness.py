"""Channels that stand still: clipped at a rail, frozen, or constant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.cut_peaks import cut_tops
from nonsmooth.measured.quality.flaw import Flaw, Readings
from nonsmooth.measured.quality.noise import longest_by_chance

__all__ = ["equal_runs", "still_findings"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_LEAVING = 0.5  # of the slope into a rail, at least, that out of it has where a signal is clipped
_CUT = 0.5  # of the flat tops, that are cut off where a signal without noise is clipped
_SLOPE = 3  # samples before and after a flat top by which slopes are told
_FEWEST_RUNS = 20  # by which the longest one is judged where noise does not show


class Runs(NamedTuple):
    """Stretches of equal samples: the first one of each, and how many they are."""

    first: npt.NDArray[np.int64]
    length: npt.NDArray[np.int64]

    def places(self, chosen: Mask) -> npt.NDArray[np.int64]:
        """Numbers of the samples of the chosen stretches."""
        first, length = self.first[chosen], self.length[chosen]
        begun = np.repeat(np.cumsum(length) - length, length)
        return np.repeat(first, length) + np.arange(int(length.sum())) - begun


def equal_runs(values: Floats) -> Runs:
    """Stretches of two equal samples or more."""
    with np.errstate(invalid="ignore"):
        equal = np.diff(values) == 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], equal.astype(np.int8), [0]])))
    first, last = edges[::2], edges[1::2]
    return Runs(first, last - first + 1)


def still_findings(data: Readings) -> Iterator[Flaw]:
    """What stands still in a channel, and whether noise tells why."""
    values = data.values
    finite = np.isfinite(values)
    if not finite.any():
        return
    low, high = float(values[finite].min()), float(values[finite].max())
    if low == high:
        yield Flaw(
            data.name, "constant", *data.span, int(finite.sum()), low,
            f"{data.name} is {data.size(low)} throughout: at rest, or the probe is dead",
            doubtful=False,
        )  # fmt: skip
        return
    runs = equal_runs(values)
    limit = longest_by_chance(data.noise, values.size, data.rate)
    railed = np.zeros(runs.first.size, dtype=bool)
    for rail, word in ((low, "lowest"), (high, "highest")):
        here = values[runs.first] == rail if runs.first.size else railed
        if here.any() and _is_clipped(data, runs, here, rail, limit):
            railed |= here
            yield _clipped(data, runs, here, rail, word)
    yield from _frozen(data, runs, ~railed, limit)


def _clipped(data: Readings, runs: Runs, here: Mask, rail: float, word: str) -> Flaw:
    at = runs.places(here)
    return Flaw(
        data.name, "clipped", float(data.times[at[0]]), float(data.times[at[-1]]), at.size, rail,
        f"{data.name} is clipped at {data.size(rail)}, its {word} value: {at.size} samples in"
        f" {int(here.sum())} flat tops, the longest of {int(runs.length[here].max())}; the true"
        " peaks lie beyond",
        at,
    )  # fmt: skip


def _is_clipped(data: Readings, runs: Runs, here: Mask, rail: float, limit: float) -> bool:
    """Whether samples pile up at an extreme value more than at the top of a smooth arch.

    The time that a parabola spends within a depth d of its top goes as the root of d, and that of
    an arch as flat as x^4 as the fourth root. So of the samples in the uppermost m + 1 steps at
    most the share (m + 1)^(-1/2) or (m + 1)^(-1/4) is in the uppermost one; the latter counts
    where no noise mixes the steps. The number there is binomial at worst.
    """
    from scipy.stats import binom

    if runs.length[here].max() > limit:
        return True
    values, noise = data.values, data.noise
    width = max(1.0, round(noise.deviation / noise.step)) if noise.step > 0.0 else 1.0
    with np.errstate(invalid="ignore"):
        near = int((np.abs(values - rail) < (width + 0.5) * noise.step).sum())
    at = int(runs.length[here].sum())
    power = -0.5 if noise.least > 0.0 else -0.25
    # one sample is the extreme one of any record
    by_chance = float(binom.sf(at - 2, max(near - 1, at - 1), (width + 1.0) ** power))
    if by_chance <= data.rate and noise.least > 0.0:
        return True
    cut = cut_tops(data, rail, runs.first[here], runs.length[here])
    if by_chance > data.rate:
        return bool(cut.any())  # one peak may be cut off, and all others be lower
    return bool(cut.mean() >= _CUT) if cut.size else _leaves_as_it_came(values, runs, here)


def _leaves_as_it_came(values: Floats, runs: Runs, here: Mask) -> bool:
    """Whether a signal leaves its flat tops as steeply as it came.

    That is so of a signal that was cut off. What comes to rest against a stop leaves it slowly.
    """
    before, after = runs.first[here], runs.first[here] + runs.length[here] - 1
    inside = (before >= _SLOPE) & (after < values.size - _SLOPE)
    if not inside.any():
        return False
    before, after = before[inside], after[inside]
    into = np.abs(values[before] - values[before - _SLOPE])
    out = np.abs(values[after + _SLOPE] - values[after])
    with np.errstate(invalid="ignore", divide="ignore"):
        return bool(np.nanmedian(out / into) >= _LEAVING)


def _frozen(data: Readings, runs: Runs, chosen: Mask, limit: float) -> Iterator[Flaw]:
    lengths = runs.length[chosen]
    others = _longest_of_others(lengths, data.rate)
    if math.isfinite(limit) and (data.noise.least >= data.noise.step or others <= limit):
        why = f"its noise of {data.size(data.noise.deviation)} lets chance give {limit:.0f} at most"
    elif others > 0.0:
        # noise of less than a step may be rounding: then rests of the motion are compared, too
        limit = others
        why = f"its noise hardly shows, and all other rests are far below {limit:.0f} samples"
    else:
        return
    for k in np.flatnonzero(chosen & (runs.length > limit)):
        begin, count = int(runs.first[k]), int(runs.length[k])
        value = float(data.values[begin])
        first, last = float(data.times[begin]), float(data.times[begin + count - 1])
        yield Flaw(
            data.name, "frozen", first, last, count, value,
            f"{data.name} stands still at {data.size(value)} from t = {first:.6g} to {last:.6g},"
            f" {count} samples; {why}",
            np.arange(begin, begin + count),
        )  # fmt: skip


def _longest_of_others(lengths: npt.NDArray[np.int64], rate: float) -> float:
    """Length that a rest has by chance, judged by the second longest one; 0 where few are known.

    Lengths that fall off as fast as exponential ones, N of them, have a longest one beyond r
    times the second longest with a probability of about N^(1 - r). The excess counts twice, since
    a last digit that moves once may cut all other rests in two.
    """
    if lengths.size < _FEWEST_RUNS:
        return 0.0
    second = float(np.sort(lengths)[-2])
    return second * (1.0 + 2.0 * math.log(1.0 / rate) / math.log(lengths.size))
