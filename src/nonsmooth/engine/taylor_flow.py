"""The flow of a Taylor mode: one step of its series, read wherever it is asked for.

A step is to a Taylor mode what a segment is to a linear one: it starts at the anchor, it is
as long as its series allow, and samples, guards and events only read its polynomials.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.rounding import fill_doubt
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.taylor_series import fill_series
from nonsmooth.engine.taylor_step import converging_step, step_inside, step_of_roots

__all__ = ["read_guard_of_step", "start_step", "state_of_step"]

_UNIT = 2.220446049250313e-16
_MARGIN = 8.0  # roundings: those of the coefficients and of the polynomial read at a point
_FAR = 1e300
_SHORT = 2.0**-40  # part of the longest step
_CHOICES = np.array([float(math.comb(k, at.TERMS)) for k in range(at.ORDER + 1)])
_MOST_ROUNDS = 20  # of a length and the rounding errors within it, which need each other


@kernel
def start_step(tables, rates, segment, m, limit):
    """Series of all registers at segment.z, and the length of the step; nan where they fail.

    States that are solved for are put on their relations before.
    """
    n, series, outlets = tables.sizes[0], segment.series, tables.outlets[m]
    n_exits = tables.wiring[m, 0, at.N_EXITS]
    first, middle = tables.code_rows[m, 0], tables.code_rows[m, 1]
    slaved = at.explicit(tables.wiring, m)
    if tables.wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
        return math.nan
    for i in range(segment.z.size):
        series[i, 0] = segment.z[i]
    fill_series(
        tables.code, tables.terms, tables.weights, first, middle, tables.values, outlets,
        slaved, tables.sizes, tables.harmonics, series, 0, at.ORDER,
    )  # fmt: skip
    length = limit
    for i in range(n):
        length = converging_step(series[i], 0.0, length)
    length = step_inside(tables.code, first, middle, series, length)
    for g in range(n_exits):
        order = segment.order[g]
        if order < at.TERMS:
            length = step_of_roots(series[outlets[n + g]], order, length, _SHORT * limit)
    for _ in range(_MOST_ROUNDS):
        fill_doubt(
            tables.code, tables.terms, tables.weights, first, middle, tables.values, series,
            segment.z.size, length, segment.doubt,
        )  # fmt: skip
        whole = length
        for g in range(n_exits):
            noise = _UNIT * segment.doubt[outlets[n + g], at.UNITS]
            length = converging_step(series[outlets[n + g]], noise, length)
        if length > 0.5 * whole:
            break
    spans = tables.spans[m]
    spans[at.RUNG], spans[at.REACH], spans[at.FASTEST] = _FAR, length, 1.0 / length
    segment.point[0] = 0.0
    for g in range(n_exits):
        _bound_guard(series[outlets[n + g]], segment.doubt[outlets[n + g]], length, segment.scan[g])
    for i in range(n):
        if not math.isfinite(series[i, at.ORDER]):
            return math.nan
    for g in range(n_exits):
        if not math.isfinite(series[outlets[n + g], at.ORDER]):
            return math.nan
    return length


@kernel
def _bound_guard(a, doubt, length, scan):
    """Margin of a guard, and bound of its sixth Taylor coefficient, over the whole step."""
    bound, size = 0.0, abs(a[0])
    power, scale = 1.0, 1.0
    for k in range(1, at.ORDER + 1):
        scale *= length
        size += abs(a[k]) * scale
        if k >= at.TERMS:
            bound += _CHOICES[k] * abs(a[k]) * power
            power *= length
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
