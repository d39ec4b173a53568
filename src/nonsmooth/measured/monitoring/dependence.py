"""What windows are worth that follow each other, and records that differ: design effects.

A design effect is the variance of a share beside that which as many independent windows would
give. It is taken from the ranks above their upper quartile, since it is for limits that few windows
exceed: exceedances themselves are too few to tell it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import beta, norm, rankdata, t

__all__ = ["Worth", "correlation_time", "design_effect", "tail_effect"]

Floats = npt.NDArray[np.float64]

_TAIL = 0.75  # share of ranks that count as equal
_LEVEL = 0.95  # of all intervals
_OUTSIDE = (1.0 - _LEVEL) / 2.0


class Worth(NamedTuple):
    """Windows of some records, and by how much their dependence enlarges variances."""

    size: int
    effect: float
    records: int

    @property
    def effective(self) -> float:
        """Independent windows that would tell as much."""
        return self.size / self.effect

    def interval(self, share: float) -> tuple[float, float]:
        """95 % interval of the rate above a limit that was set for ``share``.

        Of one record the rate has a beta distribution, as that of an order statistic.
        """
        if self.records > 1:
            ends = self.interval_of_seen(share)
            return float(ends[0]), float(ends[1])
        number = self.effective + 1.0
        spread = beta(share * number, (1.0 - share) * number)
        low = float(spread.ppf(_OUTSIDE)) if share * number >= 1.0 else 0.0
        return low, float(spread.ppf(1.0 - _OUTSIDE))

    def interval_of_seen(self, share: npt.ArrayLike) -> tuple[Floats, Floats]:
        """95 % interval of a probability of which a share was seen, after Clopper and Pearson.

        It begins at zero where less than one independent window was seen.
        """
        seen, number = np.asarray(share, dtype=float), self._known()
        hits = seen * number
        # where there is no limit, the beta function has no such parameters
        low = beta.ppf(_OUTSIDE, np.maximum(hits, 1.0), np.maximum(number - hits, 0.0) + 1.0)
        high = beta.ppf(1.0 - _OUTSIDE, hits + 1.0, np.where(seen < 1.0, number - hits, 1.0))
        return np.where(hits < 1.0, 0.0, low), np.where(seen < 1.0, high, 1.0)

    def _known(self) -> float:
        """Effective number, less for what few records leave unknown of their differences."""
        if self.records < 2:
            return self.effective
        factor = norm.ppf(1.0 - _OUTSIDE) / t.ppf(1.0 - _OUTSIDE, self.records - 1)
        return self.effective * float(factor) ** 2


def tail_effect(runs: list[Floats]) -> float:
    """Design effect for shares of scores above a high limit; one run of windows per record."""
    ranks = rankdata(np.concatenate(runs))
    tail = np.maximum(ranks - _TAIL * ranks.size, 0.0)
    return design_effect(np.split(tail, np.cumsum([one.size for one in runs])[:-1]))


def design_effect(runs: list[Floats]) -> float:
    """Design effect of a mean: by correlation in time, or by differences between records.

    The larger one counts, and one at least: both are estimates.
    """
    mean = np.concatenate(runs).mean()
    parts = [one - mean for one in runs]
    power = sum(float(one @ one) for one in parts)
    if power == 0.0:
        return 1.0
    between = 0.0
    if len(parts) > 1:
        totals = sum(float(one.sum()) ** 2 for one in parts)
        between = len(parts) / (len(parts) - 1) * totals / power
    return max(1.0, between, correlation_time(parts))


def correlation_time(parts: list[Floats]) -> float:
    """Integrated autocorrelation time, by the initial positive sequence of Geyer.

    Up to the lag M it is too small by its part (2 M + 1) / n, since the mean is that of the same
    windows (U. Wolff, Computer Physics Communications 156 (2004), 143); this is put right.

    parts: deviations from one mean, in order of time within each part
    """
    power = sum(float(one @ one) for one in parts)
    total, longest, last = -1.0, max(one.size for one in parts), 0
    for lag in range(0, longest - 1, 2):
        pair = sum(
            float(one[: one.size - k] @ one[k:])
            for one in parts
            for k in (lag, lag + 1)
            if k < one.size
        )
        if pair <= 0.0:
            break
        total, last = total + 2.0 * pair / power, lag + 1
    number = sum(one.size for one in parts)
    return max(total * (1.0 + (2.0 * last + 1.0) / number), 1.0)
