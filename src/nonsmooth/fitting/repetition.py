"""Whether a record shows a motion that repeats itself, and after how many periods.

A cycle of a record is a Fourier series. The record repeats itself if one series serves both of its
halves as well as one for each (F test), and if nothing but white residuals is left (Ljung-Box
test). A transient fails the first test, chaos and a longer cycle the second. Both are careful: what
is not surely steady is fitted as a transient, which takes any motion and more time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.linalg import lstsq
from scipy.stats import f as f_distribution

from nonsmooth.fitting.channels import ObservedChannel
from nonsmooth.fitting.correlated import ljung_box

__all__ = ["repeats_after"]

Floats = npt.NDArray[np.float64]

_LONGEST = 8  # periods of a cycle that are looked at
_FEWEST = 4  # cycles in a record
_PER_TERM = 8  # samples for each term of the series
_HARMONICS = 40  # of a period
_LEVEL = 0.01  # probability below which a test speaks against a steady motion


def repeats_after(channels: Sequence[ObservedChannel], times: Floats, period: float) -> int | None:
    """Smallest number of periods after which all channels repeat themselves; None for none.

    Channels of events are not looked at.
    """
    sampled = [channel for channel in channels if not channel.shows_events]
    if not sampled:
        return None
    for cycle in range(1, _LONGEST + 1):
        if times[-1] - times[0] < _FEWEST * cycle * period:
            return None
        if all(_repeats(channel.values, times, cycle, period) for channel in sampled):
            return cycle
    return None


def _repeats(values: Floats, times: Floats, cycle: int, period: float) -> bool:
    good = np.isfinite(values)
    values, times = values[good], times[good]
    length = cycle * period
    cycles = (times[-1] - times[0]) / length
    most = min(values.size // _PER_TERM, int(values.size / cycles))
    harmonics = min(_HARMONICS * cycle, (most - 1) // 2)
    if harmonics < 2 * cycle:
        return False
    angle = 2.0 * np.pi / length * np.outer(times, np.arange(1, harmonics + 1))
    terms = np.column_stack([np.ones(values.size), np.cos(angle), np.sin(angle)])
    half = times < 0.5 * (times[0] + times[-1])
    whole = _left(terms, values)
    parts = np.concatenate([_left(terms[half], values[half]), _left(terms[~half], values[~half])])
    count = terms.shape[1]
    rest = float(parts @ parts) / (values.size - 2 * count)
    if rest <= 0.0:
        return False
    ratio = (float(whole @ whole) - float(parts @ parts)) / count / rest
    same = f_distribution.sf(ratio, count, values.size - 2 * count)
    return bool(same > _LEVEL and ljung_box(whole)[1] > _LEVEL)


def _left(terms: Floats, values: Floats) -> Floats:
    """Residuals of the least squares."""
    found: Floats = values - terms @ lstsq(terms, values, lapack_driver="gelsy")[0]
    return found
