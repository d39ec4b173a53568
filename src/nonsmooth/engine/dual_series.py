"""Derivatives of Taylor series in several directions, by the same instructions.

A direction is an initial state, or another coordinate, or a parameter. Directions are handled
four at a time, so that the processor does the same to all four; their number is a multiple of
four, with zeros in those that are left over.
"""

from __future__ import annotations

import math

from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import inlined, kernel, summing
from nonsmooth.engine.layout import LANES

__all__ = ["fill_duals"]


@kernel
def fill_duals(
    code, terms, weights, first, last, slots, slot_rates, offset, outlets, slaved, sizes, harmonics,
    harmonic_rates, series, dual, low, high,
):  # fmt: skip
    """Derivatives of the coefficients low ... high that fill_series has left.

    shapes: dual (R, high + 1 or more, D), the seeds in dual[:N, 0]; slot_rates (s, P) and
    harmonic_rates (P, K): derivatives with respect to parameters, which are the directions from
    ``offset`` on
    """
    n = sizes[0]
    for k in range(low, high + 1):
        for row in range(first, last):
            y, a, b = code[row, 1], code[row, 2], code[row, 3]
            instruction = code[row, 0]
            if instruction == op.COMBINE:
                _combine(y, a, b, terms, weights, slot_rates, offset, series, dual, k)
            elif instruction == op.MULTIPLY:
                _product(series[a], series[b], dual[a], dual[b], dual[y], k)
            elif instruction == op.SQUARE:
                _product(series[a], series[a], dual[a], dual[a], dual[y], k)
            elif instruction < op.EXP:
                _algebraic(instruction, y, a, b, slots, slot_rates, offset, series, dual, k)
            else:
                _transcendental(instruction, y, a, b, code[row, 4], series, dual, k)
        for i in range(n):
            for d in range(dual.shape[2]):
                if (slaved >> i) & 1:
                    dual[i, k, d] = dual[outlets[i], k, d]
                elif k + 1 < dual.shape[1]:
                    dual[i, k + 1, d] = dual[outlets[i], k, d] / (k + 1)
        if k + 1 < dual.shape[1]:
            _advance_time(n, sizes[1], offset, harmonics, harmonic_rates, series, dual, k)


@kernel
def _advance_time(n, powers, offset, harmonics, harmonic_rates, series, dual, k):
    for d in range(dual.shape[2]):
        dual[n, k + 1, d] = 0.0
        for j in range(1, powers + 1):
            dual[n + j, k + 1, d] = j * dual[n + j - 1, k, d] / (k + 1)
        for q in range(harmonics.shape[1]):
            cos = n + 1 + powers + 2 * q
            w = harmonics[0, q]
            w_rate = 0.0
            if 0 <= d - offset < harmonic_rates.shape[0]:
                w_rate = harmonic_rates[d - offset, q]
            sine = w * dual[cos + 1, k, d] + w_rate * series[cos + 1, k]
            cosine = w * dual[cos, k, d] + w_rate * series[cos, k]
            dual[cos, k + 1, d] = -sine / (k + 1)
            dual[cos + 1, k + 1, d] = cosine / (k + 1)


@kernel
def _combine(y, low, high, terms, weights, slot_rates, offset, series, dual, k):
    """Sum of registers times constants, which may depend on parameters."""
    target = dual[y, k]
    _clear(target)
    for term in range(low, high):
        register, slot = terms[term, 0], terms[term, 1]
        for d in range(target.size):
            target[d] += weights[term] * dual[register, k, d]
        for p in range(slot_rates.shape[1]):
            target[offset + p] += slot_rates[slot, p] * series[register, k]


@summing
def _add_products(a, dual, low, high, k, factor, target):
    """target += factor times the sum of a_(k-j) dual_j over low <= j <= high.

    shapes: a (K,), dual (K, D), target (D,)
    """
    for d in range(0, target.size, LANES):
        x0, x1, x2, x3 = 0.0, 0.0, 0.0, 0.0
        for j in range(low, high + 1):
            weight = a[k - j]
            x0 += weight * dual[j, d]
            x1 += weight * dual[j, d + 1]
            x2 += weight * dual[j, d + 2]
            x3 += weight * dual[j, d + 3]
        target[d] += factor * x0
        target[d + 1] += factor * x1
        target[d + 2] += factor * x2
        target[d + 3] += factor * x3


@summing
def _add_weighted(a, dual, u, v, low, high, k, factor, target):
    """target += factor times the sum of (u (k - j) + v j) a_(k-j) dual_j.

    shapes: as in _add_products
    """
    for d in range(0, target.size, LANES):
        x0, x1, x2, x3 = 0.0, 0.0, 0.0, 0.0
        for j in range(low, high + 1):
            weight = (u * (k - j) + v * j) * a[k - j]
            x0 += weight * dual[j, d]
            x1 += weight * dual[j, d + 1]
            x2 += weight * dual[j, d + 2]
            x3 += weight * dual[j, d + 3]
        target[d] += factor * x0
        target[d + 1] += factor * x1
        target[d + 2] += factor * x2
        target[d + 3] += factor * x3


@inlined
def _clear(target):
    for d in range(target.size):
        target[d] = 0.0


@inlined
def _divide(target, divisor):
    for d in range(target.size):
        target[d] /= divisor


@kernel
def _product(a, b, dual_a, dual_b, dual_y, k):
    target = dual_y[k]
    _clear(target)
    _add_products(b, dual_a, 0, k, k, 1.0, target)
    _add_products(a, dual_b, 0, k, k, 1.0, target)


@kernel
def _algebraic(instruction, y, a, b, slots, slot_rates, offset, series, dual, k):
    """Quotient, root, power, logarithm: the recurrence of the value, differentiated."""
    target = dual[y, k]
    if instruction == op.POWER:
        _power(y, a, b, slots, slot_rates, offset, series, dual, k)
        return
    if instruction == op.LOG:
        _clear(target)
        if k == 0:
            for d in range(target.size):
                target[d] = dual[a, 0, d] / series[a, 0]
            return
        _add_products(series[y], dual[a], 0, 0, k, -float(k), target)
        _add_weighted(series[a], dual[y], 0.0, 1.0, 1, k - 1, k, -1.0, target)
        _add_weighted(series[y], dual[a], 1.0, 0.0, 1, k - 1, k, -1.0, target)
        for d in range(target.size):
            target[d] = (target[d] / k + dual[a, k, d]) / series[a, 0]
        return
    for d in range(target.size):
        target[d] = dual[a, k, d]
    if instruction == op.DIVIDE:
        _add_products(series[b], dual[y], 0, k - 1, k, -1.0, target)
        _add_products(series[y], dual[b], 0, k, k, -1.0, target)
        _divide(target, series[b, 0])
    else:
        _add_products(series[y], dual[y], 0, k - 1, k, -2.0, target)
        _divide(target, 2.0 * series[y, 0])


@kernel
def _power(y, a, b, slots, slot_rates, offset, series, dual, k):
    """y = a^c, from k a_0 y_k = sum of (c (k - j) - j) a_(k-j) y_j over j < k."""
    target, exponent = dual[y, k], slots[b]
    base = series[a, 0]
    if k == 0:
        for d in range(target.size):
            target[d] = series[y, 0] * exponent * dual[a, 0, d] / base
        for p in range(slot_rates.shape[1]):
            target[offset + p] += slot_rates[b, p] * math.log(base) * series[y, 0]
        return
    for d in range(target.size):
        target[d] = -k * dual[a, 0, d] * series[y, k]
    _add_weighted(series[a], dual[y], exponent, -1.0, 0, k - 1, k, 1.0, target)
    # the same sum by the other factor: j counts the coefficient of a
    _add_weighted(series[y], dual[a], -1.0, exponent, 1, k, k, 1.0, target)
    for p in range(slot_rates.shape[1]):
        total = 0.0
        for j in range(k):
            total += (k - j) * series[a, k - j] * series[y, j]
        target[offset + p] += slot_rates[b, p] * total
    _divide(target, k * base)


@kernel
def _transcendental(instruction, y, a, b, c, series, dual, k):
    """Functions with y' = a' f, differentiated."""
    target = dual[y, k]
    _clear(target)
    if instruction == op.ATAN2:
        _angle(y, a, b, c, series, dual, k)
        return
    f = y if instruction == op.EXP else b
    sign = -1.0 if instruction == op.COS or instruction == op.ACOS else 1.0
    if k == 0:
        # the register with f may come later, but its value does not: it belongs to y
        rate = _rate(instruction, series[a, 0], series[y, 0], series[f, 0])
        for d in range(target.size):
            target[d] = sign * rate * dual[a, 0, d]
        return
    _add_weighted(series[f], dual[a], 0.0, 1.0, 1, k, k, sign / k, target)
    _add_weighted(series[a], dual[f], 1.0, 0.0, 0, k - 1, k, sign / k, target)


@kernel
def _rate(instruction, x, y, f):
    if instruction == op.TAN:
        return 1.0 + y * y
    if instruction == op.TANH:
        return 1.0 - y * y
    return f


@kernel
def _angle(y, a, b, c, series, dual, k):
    """Angle of (b, a) with squared radius c: y' c = b a' - a b'."""
    target = dual[y, k]
    if k == 0:
        for d in range(target.size):
            crossed = series[b, 0] * dual[a, 0, d] - series[a, 0] * dual[b, 0, d]
            target[d] = crossed / series[c, 0]
        return
    for d in range(target.size):
        target[d] = -k * dual[c, 0, d] * series[y, k]
    _add_weighted(series[b], dual[a], 0.0, 1.0, 1, k, k, 1.0, target)
    _add_weighted(series[a], dual[b], 1.0, 0.0, 0, k - 1, k, 1.0, target)
    _add_weighted(series[a], dual[b], 0.0, 1.0, 1, k, k, -1.0, target)
    _add_weighted(series[b], dual[a], 1.0, 0.0, 0, k - 1, k, -1.0, target)
    _add_weighted(series[c], dual[y], 0.0, 1.0, 1, k - 1, k, -1.0, target)
    _add_weighted(series[y], dual[c], 1.0, 0.0, 1, k - 1, k, -1.0, target)
    _divide(target, k * series[c, 0])
