"""Taylor coefficients of everything a mode computes, by its instructions on series.

A register holds the coefficients of a function of the time since the start of the step. The
instructions are passed once per order; each adds one coefficient from those there already
(A. Griewank and A. Walther, Evaluating Derivatives, 2008, table 13.2).

A sum leaves out its newest coefficients, which it would have to wait for; they come in last.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.layout import CHAIN, first_of_signals
from nonsmooth.engine.short_sums import inner, weighted

__all__ = ["fill_series"]

_0, _1, _2, _3 = np.uintp(0), np.uintp(1), np.uintp(2), np.uintp(3)
_LAG, _MIRROR = np.uintp(at.LAG), np.uintp(at.MIRROR + at.ORDER)
_RECIPROCAL = np.uintp(at.RECIPROCAL)


@kernel
def fill_series(
    code, terms, weights, first, last, slots, outlets, slaved, sizes, harmonics, series, low, high
):
    """Coefficients of order low ... high of all registers; those of the coordinates lead by one.

    shapes: code (r, 5), terms (t, 2), weights (t,), slots (s,), outlets (n + ..,), series
    (R, SERIES_ROW) with the augmented coordinates in series[:N, 0]; low is 0, or 1 when those
    of order 0 are there
    """
    n = sizes[0]
    n_registers = np.uintp(first_of_signals(sizes) + CHAIN * sizes[7] + last - first)
    finite = True
    # unsigned numbers are not tested for counting from the end, which costs as much as a sum
    for k in range(np.uintp(low), np.uintp(high + 1)):
        for row in range(np.uintp(first), np.uintp(last)):
            instruction, y = code[row, _0], np.uintp(code[row, _1])
            a, b = np.uintp(code[row, _2]), np.uintp(code[row, _3])
            if instruction == op.COMBINE:
                total = 0.0
                for term in range(a, b):
                    total += weights[term] * series[np.uintp(terms[term, _0]), k]
                series[y, k] = total
            elif k == _0:
                c = np.uintp(code[row, 4])
                series[y, _0] = _value(instruction, a, b, c, slots, series)
                series[y, _RECIPROCAL] = _reciprocal(instruction, y, a, b, c, series)
            elif instruction == op.MULTIPLY:
                rest = inner(series[a], series[b], k)
                series[y, k] = (rest + series[a, _0] * series[b, k]) + series[a, k] * series[b, _0]
            elif instruction == op.SQUARE:
                rest = inner(series[a], series[a], k)
                series[y, k] = rest + 2.0 * series[a, _0] * series[a, k]
            elif instruction < op.EXP:
                series[y, k] = _algebraic(instruction, y, a, b, slots, series, k)
            else:
                c = np.uintp(code[row, 4])
                series[y, k] = _transcendental(instruction, y, a, b, c, series, k)
        next_k, inverse = k + _1, 1.0 / (k + 1.0)
        for i in range(np.uintp(n)):
            outlet = np.uintp(outlets[i])
            if (slaved >> i) & 1:
                series[i, k] = series[outlet, k]
            elif k < at.ORDER:
                series[i, next_k] = series[outlet, k] * inverse
        if k < at.ORDER:
            _advance_time(sizes, harmonics, series, k)
        if k > 0:
            for i in range(n_registers):
                # the sums of later orders see coefficient k from now on
                series[i, _LAG + k] = series[i, _MIRROR - k] = series[i, k]
                if not math.isfinite(series[i, k]):
                    finite = False
    if not finite:
        _forget(series)


@kernel
def _forget(series):
    """Clear what later steps would multiply by zero: zero times infinity is not zero."""
    for i in range(series.shape[0]):
        for j in range(at.LAG, at.SERIES_ROW):
            series[i, j] = 0.0


@kernel
def _advance_time(sizes, harmonics, series, k):
    """Coefficient k + 1 of 1, powers of time, harmonics and signals."""
    n, powers, next_k, inverse = np.uintp(sizes[0]), np.uintp(sizes[1]), k + _1, 1.0 / (k + 1.0)
    series[n, next_k] = 0.0
    for j in range(_1, powers + _1):
        series[n + j, next_k] = j * series[n + j - _1, k] * inverse
    for q in range(np.uintp(harmonics.shape[1])):
        cos = n + _1 + powers + _2 * q
        turn = harmonics[_0, q] * inverse
        series[cos, next_k] = -turn * series[cos + _1, k]
        series[cos + _1, next_k] = turn * series[cos, k]
    for j in range(sizes[7]):
        last = np.uintp(first_of_signals(sizes) + CHAIN * (j + 1) - 1)
        series[last, next_k] = 0.0
        for i in range(last - np.uintp(CHAIN - 1), last):
            series[i, next_k] = series[i + _1, k] * inverse


@inlined
def _algebraic(instruction, y, a, b, slots, series, k):
    """Coefficient k > 0 of a quotient, a root, a power or a logarithm."""
    u, v = series[a], series[y]
    if instruction == op.DIVIDE:
        w = series[b]
        return ((u[k] - inner(v, w, k)) - v[_0] * w[k]) * v[_RECIPROCAL]
    if instruction == op.SQRT:
        return (u[k] - inner(v, v, k)) * v[_RECIPROCAL]
    if instruction == op.LOG:
        return (u[k] - weighted(v, u, k) / k) * v[_RECIPROCAL]
    # k a_0 y_k = sum of (c (k - j) - j) a_(k-j) y_j over j < k
    c = slots[b]
    total = (c * weighted(u, v, k) - weighted(v, u, k)) / k
    return (total + c * u[k] * v[_0]) * v[_RECIPROCAL]


@inlined
def _transcendental(instruction, y, a, b, c, series, k):
    """Coefficient k > 0 of a function with y' = a' f."""
    u = series[a]
    if instruction == op.ATAN2:
        v, w = series[b], series[c]
        total = weighted(u, v, k) - weighted(v, u, k) - weighted(series[y], w, k)
        return (total / k + (u[k] * v[_0] - v[k] * u[_0])) * series[y, _RECIPROCAL]
    f = series[y] if instruction == op.EXP else series[b]
    total = weighted(u, f, k) / k + u[k] * f[_0]
    return -total if instruction == op.COS or instruction == op.ACOS else total


@kernel
def _reciprocal(instruction, y, a, b, c, series):
    """What a recurrence is divided by at every order, of which the next ones wait."""
    if instruction == op.DIVIDE:
        return 1.0 / series[b, 0]
    if instruction == op.SQRT:
        return 0.5 / series[y, 0]
    if instruction == op.ATAN2:
        return 1.0 / series[c, 0]
    return 1.0 / series[a, 0]


@kernel
def _value(instruction, a, b, c, slots, series):
    """Coefficient 0 of everything that is not linear; nan out of its range."""
    x = series[a, 0]
    if instruction == op.MULTIPLY:
        return x * series[b, 0]
    if instruction == op.SQUARE:
        return x * x
    if instruction == op.DIVIDE:
        return x / series[b, 0]
    if instruction == op.SQRT:
        return math.sqrt(x) if x >= 0.0 else np.nan
    if instruction == op.POWER:
        return x ** slots[b] if x > 0.0 else np.nan
    if instruction == op.LOG:
        return math.log(x) if x > 0.0 else np.nan
    if instruction == op.ATAN2:
        return math.atan2(x, series[b, 0])
    if instruction < op.TAN:
        return _entire(instruction, x)
    if instruction == op.TAN:
        return math.tan(x)
    if instruction == op.TANH:
        return math.tanh(x)
    if instruction == op.ATAN:
        return math.atan(x)
    if abs(x) > 1.0:
        return np.nan
    return math.asin(x) if instruction == op.ASIN else math.acos(x)


@kernel
def _entire(instruction, x):
    if instruction == op.EXP:
        return math.exp(x)
    if instruction == op.SIN:
        return math.sin(x)
    if instruction == op.COS:
        return math.cos(x)
    return math.sinh(x) if instruction == op.SINH else math.cosh(x)
