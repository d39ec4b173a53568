"""Derivatives of Taylor series in several directions, by the same instructions.

A direction is an initial state, or another coordinate, or a parameter. The directions do not
depend on each other; LANES of them are taken side by side. The series themselves are there
already, so y = f(a) has the derivative f'(a) da with a known factor: every instruction is one
product or two, or a quotient by a known series.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.layout import CHAIN, first_of_signals
from nonsmooth.engine.short_sums import add_lanes, add_products, set_lanes

__all__ = ["fill_duals"]

_0, _1, _2, _3 = np.uintp(0), np.uintp(1), np.uintp(2), np.uintp(3)


@kernel
def fill_duals(
    code, terms, weights, first, last, slots, slot_rates, offset, outlets, slaved, sizes,
    harmonics, harmonic_rates, series, dual, low, high, blocks,
):  # fmt: skip
    """Derivatives of the coefficients low ... high that fill_series has left.

    shapes: dual (R, B, high + 1 or more, LANES) with direction d in lane d % LANES of block
    d // LANES, the seeds in dual[:N, :, 0]; slot_rates (s, P) and harmonic_rates (P, K):
    derivatives with respect to parameters, which are the directions from ``offset`` on; the
    others as in fill_series; blocks: of directions, the first ones, others are left alone
    """
    n, orders = np.uintp(sizes[0]), np.uintp(dual.shape[2])
    n_rates = slot_rates.shape[1]
    for block in range(np.uintp(blocks)):
        # parameters of this block
        start = offset - at.LANES * np.int64(block)
        p_low, p_high = max(0, -start), min(n_rates, at.LANES - start)
        for k in range(np.uintp(low), np.uintp(high + 1)):
            for row in range(np.uintp(first), np.uintp(last)):
                instruction, y = code[row, _0], np.uintp(code[row, _1])
                a, b = np.uintp(code[row, _2]), np.uintp(code[row, _3])
                target = dual[y, block, k]
                if instruction == op.COMBINE:
                    set_lanes(0.0, dual[n, block, k], target)
                    for term in range(a, b):
                        source = np.uintp(terms[term, _0])
                        add_lanes(weights[term], dual[source, block, k], target)
                    for p in range(p_low, p_high):
                        total = 0.0
                        for term in range(a, b):
                            rate = slot_rates[terms[term, _1], p]
                            total += rate * series[np.uintp(terms[term, _0]), k]
                        target[start + p] += total
                elif instruction == op.MULTIPLY:
                    _set_product(1.0, series[b], dual[a, block], k, target)
                    _add_product(1.0, series[a], dual[b, block], k, target)
                elif instruction == op.SQUARE:
                    _set_product(2.0, series[a], dual[a, block], k, target)
                elif instruction < op.EXP:
                    _algebraic(instruction, y, a, b, slots, series, dual, block, k, target)
                else:
                    c = np.uintp(code[row, 4])
                    _transcendental(instruction, y, a, b, c, series, dual, block, k, target)
            for i in range(n):
                source = dual[np.uintp(outlets[i]), block, k]
                if (slaved >> i) & 1:
                    set_lanes(1.0, source, dual[i, block, k])
                elif k + _1 < orders:
                    set_lanes(1.0 / (k + 1.0), source, dual[i, block, k + _1])
            if k + _1 < orders:
                _advance_time(sizes, harmonics, dual, block, k)
                for p in range(p_low, p_high):
                    _turn(sizes, harmonic_rates[p], series, dual, block, start + p, k)


@inlined
def _set_product(scale, a, b, k, target):
    """Coefficient k of scale times a known series times a derivative."""
    set_lanes(scale * a[_0], b[k], target)
    add_products(scale, a, b, k, target)


@inlined
def _add_product(scale, a, b, k, target):
    add_lanes(scale * a[_0], b[k], target)
    add_products(scale, a, b, k, target)


@inlined
def _algebraic(instruction, y, a, b, slots, series, dual, block, k, target):
    """Quotient, root, power or logarithm, all of which end in a quotient."""
    u, v, scale = series[a], series[y], series[y, at.RECIPROCAL]
    change, result = dual[a, block], dual[y, block]
    if instruction == op.DIVIDE:  # b dy = da - y db
        set_lanes(scale, change[k], target)
        _add_product(-scale, v, dual[b, block], k, target)
        add_products(-scale, series[b], result, k, target)
    elif instruction == op.SQRT:  # 2 y dy = da
        set_lanes(scale, change[k], target)
        add_products(-2.0 * scale, v, result, k, target)
    elif instruction == op.LOG:  # a dy = da
        set_lanes(scale, change[k], target)
        add_products(-scale, u, result, k, target)
    else:  # a dy = c y da
        _set_product(scale * slots[b], v, change, k, target)
        add_products(-scale, u, result, k, target)


@inlined
def _transcendental(instruction, y, a, b, c, series, dual, block, k, target):
    """Functions with a known slope, and the angle of (b, a) with squared radius c."""
    if instruction == op.ATAN2:  # c dy = b da - a db
        scale = series[y, at.RECIPROCAL]
        _set_product(scale, series[b], dual[a, block], k, target)
        _add_product(-scale, series[a], dual[b, block], k, target)
        add_products(-scale, series[c], dual[y, block], k, target)
        return
    slope = series[y] if instruction == op.EXP else series[b]
    sign = -1.0 if instruction == op.COS or instruction == op.ACOS else 1.0
    _set_product(sign, slope, dual[a, block], k, target)


@kernel
def _advance_time(sizes, harmonics, dual, block, k):
    """Coefficient k + 1 of 1, powers of time, harmonics and signals."""
    n, powers, next_k = np.uintp(sizes[0]), np.uintp(sizes[1]), k + _1
    inverse = 1.0 / (k + 1.0)
    set_lanes(0.0, dual[n, block, k], dual[n, block, next_k])
    for j in range(_1, powers + _1):
        set_lanes(j * inverse, dual[n + j - _1, block, k], dual[n + j, block, next_k])
    for q in range(np.uintp(harmonics.shape[1])):
        cos = n + _1 + powers + _2 * q
        turn = harmonics[_0, q] * inverse
        set_lanes(-turn, dual[cos + _1, block, k], dual[cos, block, next_k])
        set_lanes(turn, dual[cos, block, k], dual[cos + _1, block, next_k])
    for j in range(sizes[7]):
        last = np.uintp(first_of_signals(sizes) + CHAIN * (j + 1) - 1)
        set_lanes(0.0, dual[last, block, k], dual[last, block, next_k])
        for i in range(last - np.uintp(CHAIN - 1), last):
            set_lanes(inverse, dual[i + _1, block, k], dual[i, block, next_k])


@kernel
def _turn(sizes, rates, series, dual, block, lane, k):
    """What a parameter adds to coefficient k + 1 of the harmonics by their frequencies."""
    for q in range(rates.size):
        cos = sizes[0] + 1 + sizes[1] + 2 * q
        rate = rates[q] / (k + 1.0)
        dual[cos, block, k + _1, lane] -= rate * series[cos + 1, k]
        dual[cos + 1, block, k + _1, lane] += rate * series[cos, k]
