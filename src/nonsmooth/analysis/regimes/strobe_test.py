"""The 0-1 test of strobes, with the period taken off that they nearly have.

Weak chaos often visits a few narrow bands in turn. That is a strong periodic part with little
chaos on it, and the test would need a very long series to see it. The mean of every band taken off,
what is left is chaotic or not as before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.zero_one_test import correlations_of

__all__ = ["StrobeTest", "strobe_test"]

_FREQUENCIES = 25
_LONGEST = 50  # period that is looked for

Floats = npt.NDArray[np.float64]


class StrobeTest(NamedTuple):
    """K of a series, and how near it comes to repeating: root mean square, in its own scatter."""

    k: float
    nearest: float


def strobe_test(values: Floats) -> StrobeTest:
    """Test of one series without its strongest period."""
    periods = range(1, min(_LONGEST, values.size // 4) + 1)
    distance = [float(np.square(values[p:] - values[:-p]).mean()) for p in periods]
    p = 1 + int(np.argmin(distance))
    scatter = 2.0 * float(values.var())
    rest = values - values.mean()
    for k in range(p):
        rest[k::p] -= rest[k::p].mean()
    return StrobeTest(
        float(np.median(correlations_of(rest, _FREQUENCIES, 0)[1])),
        float(np.sqrt(distance[p - 1] / scatter)) if scatter > 0.0 else 0.0,
    )
