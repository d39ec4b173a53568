"""What rounding can leave in the registers of a step, by running error analysis.

A guard that is small while its terms are large, x^2 + y^2 - 1 on the circle, is known no
better than its terms. Every register carries the largest size that it takes within the step
and the number of roundings, times sizes, that it may be off by (N. J. Higham, Accuracy and
Stability of Numerical Algorithms, 2002, section 3.3).
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import kernel

__all__ = ["fill_doubt"]

_LEADING = 6  # coefficients that make up the size of a function over a step


@kernel
def fill_doubt(code, terms, weights, first, last, slots, series, n_coordinates, length, doubt):
    """Sizes of registers over a step, and their rounding errors in units of 2^-52.

    shapes: code (r, 5), terms (t, 2), weights (t,), series (R, K), doubt (R, 2) an output
    """
    for i in range(n_coordinates):
        size = _extent(series[i], length)
        doubt[i, at.EXTENT], doubt[i, at.UNITS] = size, size
    for row in range(first, last):
        y, a, b = code[row, 1], code[row, 2], code[row, 3]
        size = _extent(series[y], length)
        doubt[y, at.EXTENT] = size
        instruction = code[row, 0]
        if instruction == op.COMBINE:
            units = 0.0
            for term in range(a, b):
                units += abs(weights[term]) * doubt[terms[term, 0], at.UNITS]
        elif instruction == op.MULTIPLY:
            units = _of_product(doubt, a, b)
        elif instruction == op.SQUARE:
            units = _of_product(doubt, a, a)
        else:
            units = _of_function(instruction, y, a, b, code[row, 4], slots, series, doubt)
        doubt[y, at.UNITS] = size + units


@kernel
def _extent(a, length):
    total = abs(a[_LEADING - 1])
    for k in range(_LEADING - 2, -1, -1):
        total = total * length + abs(a[k])
    return total


@kernel
def _of_product(doubt, a, b):
    return doubt[a, at.UNITS] * doubt[b, at.EXTENT] + doubt[b, at.UNITS] * doubt[a, at.EXTENT]


@kernel
def _of_function(instruction, y, a, b, c, slots, series, doubt):
    """Error that a function hands on: its rate at the start of the step times that of a."""
    units = doubt[a, at.UNITS]
    x, value = abs(series[a, 0]), abs(series[y, 0])
    if instruction == op.DIVIDE:
        divisor = abs(series[b, 0])
        return units / divisor + doubt[b, at.UNITS] * value / divisor
    if instruction == op.SQRT:
        return units / (2.0 * value)
    if instruction == op.POWER:
        return abs(slots[b]) * value / x * units
    if instruction == op.LOG:
        return units / x
    if instruction == op.ATAN2:
        both = units * doubt[b, at.EXTENT] + doubt[b, at.UNITS] * doubt[a, at.EXTENT]
        return both / abs(series[c, 0])
    if instruction == op.TAN or instruction == op.TANH:
        return units * (1.0 + value * value)
    f = y if instruction == op.EXP else b
    return units * abs(series[f, 0])
