"""The window of time of a system without a period.

Phases are counted in windows, and segments end with them, so that long runs lose nothing.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine.decoupling import CLOSE
from nonsmooth.engine.jit import kernel

__all__ = ["natural_window"]

# A compromise between restarts and the accuracy of long arguments.
_RADIANS = 32.0
_DWARFED = 1e3  # a coupling so much larger than the gap of its eigenvalues makes a chain
_AT_REST = 64.0  # where nothing oscillates or grows
_ROUNDED = 1e-14  # part of the largest eigenvalue that rounding leaves of one that is zero


@kernel
def natural_window(t):
    """Power of two near some radians of the fastest oscillation or growth of any mode.

    shapes: t (m, N, N), triangular

    Decay does not count: however fast, its exponential stays accurate. A coupling that
    dwarfs the gap of its eigenvalues counts, up to where the two become one cluster:
    x' = v + 1e-13 x is a rigid body to all intents. A rank less leaves an eigenvalue of 1e-17,
    which is no growth: a window of 1e18 would have no digits left for the phase.
    """
    fastest = 0.0
    for m in range(t.shape[0]):
        largest = 0.0
        for i in range(t.shape[1]):
            largest = max(largest, abs(t[m, i, i]))
        for i in range(t.shape[1]):
            rate = max(abs(t[m, i, i].imag), t[m, i, i].real)
            if rate > _ROUNDED * largest:
                fastest = max(fastest, rate)
    dwarfed = 0.0
    for m in range(t.shape[0]):
        for i in range(t.shape[1]):
            for j in range(i + 1, t.shape[1]):
                gap = abs(t[m, i, i] - t[m, j, j])
                if gap <= _RADIANS * fastest and abs(t[m, i, j]) > _DWARFED * gap:
                    dwarfed = max(dwarfed, min(abs(t[m, i, j]), _RADIANS / CLOSE * gap))
    fastest = max(fastest, dwarfed)
    if fastest == 0.0:
        return _AT_REST
    return 2.0 ** np.rint(math.log2(_RADIANS / fastest))
