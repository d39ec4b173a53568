"""Taylor coefficients of everything a mode computes, by its instructions on series.

A register holds the coefficients of a function of the time since the start of the step. The
instructions are passed once per order; each adds one coefficient from those there already
(A. Griewank and A. Walther, Evaluating Derivatives, 2008, table 13.2).
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import kernel, summing
from nonsmooth.engine.layout import CHAIN, first_of_signals

__all__ = ["fill_series", "product", "weighted"]


@kernel
def fill_series(
    code, terms, weights, first, last, slots, outlets, slaved, sizes, harmonics, series, low, high
):
    """Coefficients of order low ... high of all registers; those of the coordinates lead by one.

    shapes: code (r, 5), terms (t, 2), weights (t,), slots (s,), outlets (n + ..,), series (R, high + 1 or more), with the
    augmented coordinates in series[:N, 0]; those below order low must be there
    """
    n = sizes[0]
    for k in range(low, high + 1):
        inverse = 1.0 / (k + 1.0)
        for row in range(first, last):
            instruction = code[row, 0]
            y, a, b = code[row, 1], code[row, 2], code[row, 3]
            if instruction == op.COMBINE:
                total = 0.0
                for term in range(a, b):
                    total += weights[term] * series[terms[term, 0], k]
                series[y, k] = total
            elif instruction == op.MULTIPLY:
                series[y, k] = product(series[a], series[b], k)
            elif instruction == op.SQUARE:
                series[y, k] = _square(series[a], k)
            elif k == 0:
                series[y, 0] = _value(instruction, a, b, code[row, 4], slots, series)
            elif instruction < op.EXP:
                series[y, k] = _algebraic(instruction, y, a, b, slots, series, k)
            else:
                series[y, k] = _transcendental(instruction, y, a, b, code[row, 4], series, k)
        for i in range(n):
            if (slaved >> i) & 1:
                series[i, k] = series[outlets[i], k]
            elif k + 1 < series.shape[1]:
                series[i, k + 1] = series[outlets[i], k] * inverse
        if k + 1 < series.shape[1]:
            _advance_time(sizes, harmonics, series, k)


@kernel
def _advance_time(sizes, harmonics, series, k):
    """Coefficient k + 1 of 1, powers of time, harmonics and signals."""
    n, powers = sizes[0], sizes[1]
    inverse = 1.0 / (k + 1.0)
    series[n, k + 1] = 0.0
    for j in range(1, powers + 1):
        series[n + j, k + 1] = j * series[n + j - 1, k] * inverse
    for q in range(harmonics.shape[1]):
        cos = n + 1 + powers + 2 * q
        turn = harmonics[0, q] * inverse
        series[cos, k + 1] = -turn * series[cos + 1, k]
        series[cos + 1, k + 1] = turn * series[cos, k]
    for j in range(sizes[7]):
        last = first_of_signals(sizes) + CHAIN * (j + 1) - 1
        series[last, k + 1] = 0.0
        for i in range(last - CHAIN + 1, last):
            series[i, k + 1] = series[i + 1, k] * inverse


@summing
def product(a, b, k):
    """Coefficient k of a product; the newest coefficients come last, for they are waited for.

    shapes: a, b (k + 1,) or longer
    """
    if k == 0:
        return a[0] * b[0]
    return (_inner(a, b, k) + a[0] * b[k]) + a[k] * b[0]


@summing
def _square(a, k):
    if k == 0:
        return a[0] * a[0]
    total = 0.0
    for j in range(1, (k + 1) // 2):
        total += a[j] * a[k - j]
    if k % 2 == 0:
        total += 0.5 * a[k // 2] * a[k // 2]
    return 2.0 * (total + a[0] * a[k])


@summing
def _inner(a, b, k):
    """Sum of a_j b_(k-j) over 0 < j < k."""
    total = 0.0
    for j in range(1, k):
        total += a[j] * b[k - j]
    return total


@summing
def weighted(a, f, low, high, k):
    """Sum of j a_j f_(k-j) over low <= j <= high.

    shapes: a, f (k + 1,) or longer
    """
    total = 0.0
    for j in range(low, high + 1):
        total += j * a[j] * f[k - j]
    return total


@kernel
def _algebraic(instruction, y, a, b, slots, series, k):
    """Coefficient k > 0 of a quotient, a root, a power or a logarithm."""
    if instruction == op.DIVIDE:
        return (
            series[a, k] - series[y, 0] * series[b, k] - _inner(series[y], series[b], k)
        ) / series[b, 0]
    if instruction == op.SQRT:
        return (series[a, k] - _inner(series[y], series[y], k)) / (2.0 * series[y, 0])
    if instruction == op.LOG:
        rest = weighted(series[y], series[a], 1, k - 1, k) / k
        return (series[a, k] - rest) / series[a, 0]
    exponent = slots[b]
    total = 0.0
    for j in range(k):
        total += (exponent * (k - j) - j) * series[a, k - j] * series[y, j]
    return total / (k * series[a, 0])


@kernel
def _transcendental(instruction, y, a, b, c, series, k):
    """Coefficient k > 0 of a function with y' = a' f."""
    if instruction == op.ATAN2:
        total = weighted(series[a], series[b], 1, k, k) - weighted(series[b], series[a], 1, k, k)
        total -= weighted(series[y], series[c], 1, k - 1, k)
        return total / (k * series[c, 0])
    f = y if instruction == op.EXP else b
    total = weighted(series[a], series[f], 1, k, k) / k
    return -total if instruction == op.COS or instruction == op.ACOS else total


@kernel
def _value(instruction, a, b, c, slots, series):
    """Coefficient 0 of everything that is neither linear nor a product; nan out of its range."""
    x = series[a, 0]
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
