"""A logarithm and its inverse, good enough for the length of a step, at a tenth of the cost."""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine.jit import inlined

__all__ = ["exp2", "log2"]

_FRACTION = (1 << 52) - 1
_ONE = 1023 << 52


@inlined
def log2(x):
    """Logarithm of x >= 0 to base 2, to 0.01; about -1023 of zero, 1024 or more of infinity."""
    bits = np.float64(x).view(np.int64)
    mantissa = np.int64((bits & _FRACTION) | _ONE).view(np.float64)
    # parabola through the ends of [1, 2] with the least error between them
    return (bits >> 52) - 1023 + (mantissa - 1.0) * (1.0 + 0.3431 * (2.0 - mantissa))


@inlined
def exp2(x):
    """2 to the power x to 0.3 %; 0 below the range of numbers, infinity above."""
    whole = math.floor(min(max(x, -1023.0), 1024.0))
    part = x - whole
    power = np.int64((np.int64(whole) + 1023) << 52).view(np.float64)
    return power * (1.0 + part * (1.0 - 0.3431 * (1.0 - part)))
