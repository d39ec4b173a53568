"""The flow of a Taylor mode: one step of its series, read wherever it is asked for.

A step is to a Taylor mode what a segment is to a linear one: it starts at the anchor, it is
as long as its series allow, and samples, guards and events only read its polynomials.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.logarithm import log2
from nonsmooth.engine.rounding import fill_doubt
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["read_guard_of_step", "start_step", "state_of_step"]

# The step over the radius of convergence, base 2 (A. Jorba and M. Zou, A software package for the
# numerical integration of ODEs by means of high-order Taylor methods, 2005): exp(-2) and some care
_LOG_RADIUS = (-2.0 - 0.7 / (at.ORDER - 1)) / math.log(2.0)
_LONG = 1000.0  # logarithm of a step that no series limits
_LEADING = 4  # coefficients that tell how large a function is
_UNIT = 2.220446049250313e-16
_MARGIN = 8.0  # roundings: those of the coefficients and of the polynomial read at a point
_FAR = 1e300


@kernel
def start_step(tables, segment, m, limit):
    """Series of all registers at segment.z, and the length of the step; nan where they fail."""
    n, series, outlets = tables.sizes[0], segment.series, tables.outlets[m]
    n_exits = tables.wiring[m, 0, at.N_EXITS]
    first, middle = tables.code_rows[m, 0], tables.code_rows[m, 1]
    slaved = tables.wiring[m, 0, at.SLAVED]
    for i in range(segment.z.size):
        series[i, 0] = segment.z[i]
    fill_series(
        tables.code, tables.terms, tables.weights, first, middle, tables.values, outlets,
        slaved, tables.sizes, tables.harmonics, series, 0, at.ORDER,
    )  # fmt: skip
    length = limit
    logarithm = _LONG
    for i in range(n):
        logarithm = min(logarithm, _log_step(series[i]))
    for g in range(n_exits):
        logarithm = min(logarithm, _log_step(series[outlets[n + g]]))
    length = min(limit, 2.0**logarithm)
    fill_doubt(
        tables.code, tables.terms, tables.weights, first, middle, tables.values, series,
        segment.z.size, length, segment.doubt,
    )  # fmt: skip
    spans = tables.spans[m]
    spans[at.RUNG], spans[at.REACH], spans[at.FASTEST] = _FAR, length, 1.0 / length
    segment.point[0] = 0.0
    for g in range(n_exits):
        _bound_guard(series[outlets[n + g]], segment.doubt[outlets[n + g]], length, segment.scan[g])
    return length


@kernel
def _log_step(a):
    """Logarithm of the step within which the series of a register converges well.

    The last coefficient times the step to its order may be _RADIUS to the same power of any of
    the leading terms, and likewise the last but one.
    """
    shortest = _LONG
    for p in range(at.ORDER - 1, at.ORDER + 1):
        last = log2(abs(a[p])) - p * _LOG_RADIUS
        longest = -_LONG
        for j in range(_LEADING):
            longest = max(longest, (log2(abs(a[j])) - last) * (1.0 / (p - j)))
        shortest = min(shortest, longest)
    return shortest


@kernel
def _bound_guard(a, doubt, length, scan):
    """Margin of a guard, and bound of its sixth Taylor coefficient, over the whole step."""
    bound, size = 0.0, abs(a[0])
    power, scale = 1.0, 1.0
    chosen = 1.0  # k over TERMS
    for k in range(1, at.ORDER + 1):
        scale *= length
        size += abs(a[k]) * scale
        if k >= at.TERMS:
            bound += chosen * abs(a[k]) * power
            power *= length
            chosen *= (k + 1.0) / (k + 1.0 - at.TERMS)
    remainder = (abs(a[at.ORDER - 1]) / length + abs(a[at.ORDER])) * scale
    scan[at.BOUND] = bound
    scan[at.MARGIN] = _MARGIN * _UNIT * (size + doubt[at.UNITS]) + remainder
    scan[at.TAKEN_OFF], scan[at.FADING] = 0.0, 0.0


@kernel
def read_guard_of_step(tables, segment, m, g):
    """Taylor coefficients of a guard at the current point; bound and margin hold all along."""
    s = segment.point[0]
    a, scan = segment.series[tables.outlets[m, tables.sizes[0] + g]], segment.scan[g]
    if s == 0.0:
        for j in range(at.TERMS):
            scan[j] = a[j]
        return
    # the polynomial shifted to s, by Horner's rule for all coefficients at once
    c0, c1, c2, c3, c4, c5 = a[at.ORDER], 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(at.ORDER - 1, -1, -1):
        c5 = c5 * s + c4
        c4 = c4 * s + c3
        c3 = c3 * s + c2
        c2 = c2 * s + c1
        c1 = c1 * s + c0
        c0 = c0 * s + a[k]
    scan[0], scan[1], scan[2], scan[3], scan[4], scan[5] = c0, c1, c2, c3, c4, c5


@kernel
def state_of_step(series, s, out_state):
    """States at a point of the step.

    shapes: series (R, ORDER + 1), out_state (n,)
    """
    for i in range(out_state.size):
        total = series[i, at.ORDER]
        for k in range(at.ORDER - 1, -1, -1):
            total = total * s + series[i, k]
        out_state[i] = total
