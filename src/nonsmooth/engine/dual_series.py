"""Derivatives of Taylor series in several directions, by the same instructions.

A direction is an initial state, or another coordinate, or a parameter. Every recurrence of
`taylor_series` is differentiated; the directions do not depend on each other.
"""

from __future__ import annotations

import math

from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.layout import CHAIN, first_of_signals
from nonsmooth.engine.taylor_series import product, weighted

__all__ = ["fill_duals"]


@kernel
def fill_duals(
    code, terms, weights, first, last, slots, slot_rates, offset, outlets, slaved, sizes,
    harmonics, harmonic_rates, series, dual, low, high,
):  # fmt: skip
    """Derivatives of the coefficients low ... high that fill_series has left.

    shapes: dual (R, D, high + 1 or more), the seeds in dual[:N, :, 0]; slot_rates (s, P) and
    harmonic_rates (P, K): derivatives with respect to parameters, which are the directions from
    ``offset`` on; the others as in fill_series
    """
    n = sizes[0]
    for k in range(low, high + 1):
        for row in range(first, last):
            y, a, b = code[row, 1], code[row, 2], code[row, 3]
            instruction = code[row, 0]
            if instruction == op.COMBINE:
                _combine(y, a, b, terms, weights, slot_rates, offset, series, dual, k)
            elif instruction == op.MULTIPLY:
                for d in range(dual.shape[1]):
                    change = product(series[a], dual[b, d], k) + product(series[b], dual[a, d], k)
                    dual[y, d, k] = change
            elif instruction == op.SQUARE:
                for d in range(dual.shape[1]):
                    dual[y, d, k] = 2.0 * product(series[a], dual[a, d], k)
            elif instruction == op.POWER:
                _power(y, a, b, slots, slot_rates, offset, series, dual, k)
            elif instruction < op.EXP:
                for d in range(dual.shape[1]):
                    dual[y, d, k] = _algebraic(instruction, y, a, b, series, dual, d, k)
            else:
                for d in range(dual.shape[1]):
                    dual[y, d, k] = _transcendental(
                        instruction, y, a, b, code[row, 4], series, dual, d, k
                    )
        for i in range(n):
            for d in range(dual.shape[1]):
                if (slaved >> i) & 1:
                    dual[i, d, k] = dual[outlets[i], d, k]
                elif k + 1 < dual.shape[2]:
                    dual[i, d, k + 1] = dual[outlets[i], d, k] / (k + 1)
        if k + 1 < dual.shape[2]:
            _advance_time(sizes, offset, harmonics, harmonic_rates, series, dual, k)


@kernel
def _advance_time(sizes, offset, harmonics, harmonic_rates, series, dual, k):
    n, powers = sizes[0], sizes[1]
    for d in range(dual.shape[1]):
        dual[n, d, k + 1] = 0.0
        for j in range(1, powers + 1):
            dual[n + j, d, k + 1] = j * dual[n + j - 1, d, k] / (k + 1)
        for q in range(harmonics.shape[1]):
            cos = n + 1 + powers + 2 * q
            w = harmonics[0, q]
            w_rate = 0.0
            if 0 <= d - offset < harmonic_rates.shape[0]:
                w_rate = harmonic_rates[d - offset, q]
            sine = w * dual[cos + 1, d, k] + w_rate * series[cos + 1, k]
            cosine = w * dual[cos, d, k] + w_rate * series[cos, k]
            dual[cos, d, k + 1] = -sine / (k + 1)
            dual[cos + 1, d, k + 1] = cosine / (k + 1)
        for j in range(sizes[7]):
            last = first_of_signals(sizes) + CHAIN * (j + 1) - 1
            dual[last, d, k + 1] = 0.0
            for i in range(last - CHAIN + 1, last):
                dual[i, d, k + 1] = dual[i + 1, d, k] / (k + 1)


@kernel
def _combine(y, low, high, terms, weights, slot_rates, offset, series, dual, k):
    """Sum of registers times constants, which may depend on parameters."""
    for d in range(dual.shape[1]):
        total = 0.0
        for term in range(low, high):
            total += weights[term] * dual[terms[term, 0], d, k]
        dual[y, d, k] = total
    for p in range(slot_rates.shape[1]):
        for term in range(low, high):
            rate = slot_rates[terms[term, 1], p]
            dual[y, offset + p, k] += rate * series[terms[term, 0], k]


@kernel
def _algebraic(instruction, y, a, b, series, dual, d, k):
    """Quotient, root, logarithm; coefficient k of the target must not count in its own sum."""
    u, v = series[a], series[y]
    u_d, v_d = dual[a, d], dual[y, d]
    v_d[k] = 0.0
    if instruction == op.DIVIDE:
        change = product(series[b], v_d, k) + product(v, dual[b, d], k)
        return (u_d[k] - change) / series[b, 0]
    if instruction == op.SQRT:
        return (u_d[k] - 2.0 * product(v, v_d, k)) / (2.0 * v[0])
    if k == 0:
        return u_d[0] / u[0]
    # k a_0 y_k = k a_k - sum of j y_j a_(k-j)
    change = weighted(v_d, u, 1, k - 1, k) + weighted(v, u_d, 1, k, k)
    return (u_d[k] - change / k) / u[0]


@kernel
def _power(y, a, b, slots, slot_rates, offset, series, dual, k):
    """y = a^c, from k a_0 y_k = sum of (c (k - j) - j) a_(k-j) y_j over j < k."""
    exponent, base, u, v = slots[b], series[a, 0], series[a], series[y]
    for d in range(dual.shape[1]):
        u_d, v_d = dual[a, d], dual[y, d]
        if k == 0:
            v_d[0] = v[0] * exponent * u_d[0] / base
            continue
        v_d[k] = 0.0
        # c j a_j y_(k-j) over all j, less j y_j a_(k-j), which holds k a_0 y_k as well
        total = exponent * (weighted(u_d, v, 1, k, k) + weighted(u, v_d, 1, k, k))
        total -= weighted(v_d, u, 1, k, k) + weighted(v, u_d, 1, k, k)
        v_d[k] = total / (k * base)
    for p in range(slot_rates.shape[1]):
        rate = slot_rates[b, p]
        if k == 0:
            dual[y, offset + p, 0] += rate * math.log(base) * v[0]
        else:
            dual[y, offset + p, k] += rate * weighted(u, v, 1, k, k) / (k * base)


@kernel
def _transcendental(instruction, y, a, b, c, series, dual, d, k):
    """Functions with y' = a' f, differentiated."""
    if instruction == op.ATAN2:
        return _angle(y, a, b, c, series, dual, d, k)
    f = y if instruction == op.EXP else b
    sign = -1.0 if instruction == op.COS or instruction == op.ACOS else 1.0
    if k == 0:
        # the register with f may come later, but its value does not: it belongs to y
        return sign * _rate(instruction, series[y, 0], series[f, 0]) * dual[a, d, 0]
    # f may be the target or come later: only its coefficients below k are needed
    change = weighted(dual[a, d], series[f], 1, k, k) + weighted(series[a], dual[f, d], 1, k, k)
    return sign * change / k


@kernel
def _rate(instruction, y, f):
    if instruction == op.TAN:
        return 1.0 + y * y
    if instruction == op.TANH:
        return 1.0 - y * y
    return f


@kernel
def _angle(y, a, b, c, series, dual, d, k):
    """Angle of (b, a) with squared radius c: y' c = b a' - a b'."""
    u, v, w = series[a], series[b], series[c]
    u_d, v_d, w_d, y_d = dual[a, d], dual[b, d], dual[c, d], dual[y, d]
    if k == 0:
        return (v[0] * u_d[0] - u[0] * v_d[0]) / w[0]
    change = weighted(u_d, v, 1, k, k) + weighted(u, v_d, 1, k, k)
    change -= weighted(v_d, u, 1, k, k) + weighted(v, u_d, 1, k, k)
    change -= weighted(y_d, w, 1, k - 1, k) + weighted(series[y], w_d, 1, k, k)
    return change / (k * w[0])
