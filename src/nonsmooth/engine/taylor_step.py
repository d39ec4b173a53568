"""How long a step of a Taylor mode may be: what its series allow, and no longer than needed."""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.logarithm import exp2, log2

__all__ = ["converging_step", "step_inside", "step_of_roots"]

# The step over the radius of convergence, base 2 (A. Jorba and M. Zou, A software package for the
# numerical integration of ODEs by means of high-order Taylor methods, 2005): exp(-2) and some care
_LOG_RADIUS = (-2.0 - 0.7 / (at.ORDER - 1)) / math.log(2.0)
_NOTHING = -960.0  # logarithm of a size that is nothing; far below it digits are lost
_LONG = 1000.0  # logarithm of a step that no series limits
_SMALLEST = -744.0  # exp of less is zero
_INVERSE = 1.0 / np.arange(at.ORDER + 1).clip(1)
_HALF_PI = 0.5 * math.pi
_LEADING = 4  # coefficients that tell how large a function is
# A series of which nothing is left from here on is a polynomial. Others may be sparse: of
# atan(t^2) every fourth coefficient is there.
_POLYNOMIAL = 10
_TINY = 1e-300  # the next coefficients may have been lost to underflow
_MOST_FALL = 0.9  # part by which an argument may fall in one step
_MOST_HALVINGS = 1100
_BEYOND = 0.5  # logarithm of the step over half of a bound of all roots


@kernel
def converging_step(a, noise, longest):
    """Step within which a series converges well, at most ``longest``.

    Each of the last two coefficients times the step to its order may be the radius to the same
    power of any of the leading terms, or the noise that rounding leaves anyway.
    """
    first = 0
    while first < at.ORDER and a[first] == 0.0:
        first += 1
    last = _last_term(a, at.ORDER, first)
    if last == first:
        return longest
    other = _last_term(a, last - 1, first)
    size = log2(abs(a[last])) - last * _LOG_RADIUS
    other_size = log2(abs(a[other])) - other * _LOG_RADIUS
    limit = (_NOTHING - size) * _INVERSE[last]
    other_limit = (_NOTHING - other_size) * _INVERSE[other] if other > first else _LONG
    if noise > 0.0:
        unit = log2(noise)
        limit = max(limit, (unit - size) * _INVERSE[last] - _LOG_RADIUS)
        other_limit = max(other_limit, (unit - other_size) * _INVERSE[other] - _LOG_RADIUS)
    for j in range(first, min(first + _LEADING, last)):
        leading = log2(abs(a[j]))
        limit = max(limit, (leading - size) * _INVERSE[last - j])
        if j < other:
            other_limit = max(other_limit, (leading - other_size) * _INVERSE[other - j])
    return min(longest, exp2(min(limit, other_limit)))


@inlined
def _last_term(a, p, first):
    """The last order from p down to one before which all that is left is a polynomial."""
    while p > first and (a[p] == 0.0 or (p < _POLYNOMIAL and abs(a[p]) > _TINY)):
        p -= 1
    return max(p, first)


@kernel
def step_inside(code, first, last, series, longest):
    """Step within which all functions converge, and none comes to the edge of its range.

    A function may be flat where the step starts and steep where it ends, and only its own
    series, however small its coefficients, knows. Where an argument only touches zero, as in
    sqrt(v^2), the series knows nothing of the edge and goes on with the wrong sign behind it.

    shapes: code (r, 5), series (R, ORDER + 1)
    """
    length = longest
    for row in range(first, last):
        function, y, a = code[row, 0], code[row, 1], code[row, 2]
        if function == op.TANH:
            # its poles are i pi/2 from the real line
            length = _step_of_argument(series[a], _HALF_PI + abs(series[a, 0]), length)
        elif function == op.EXP and series[y, 0] == 0.0:
            # zero as long as the argument is so far below that of the smallest number
            length = _step_of_argument(series[a], _SMALLEST - series[a, 0], length)
        elif function >= op.DIVIDE:
            length = converging_step(series[y], 0.0, length)
        if function == op.SQRT:
            length = _positive_step(series[y], length)
        elif function == op.POWER or function == op.LOG:
            length = _positive_step(series[a], length)
        elif function == op.ATAN2:
            length = _positive_step(series[code[row, 4]], length)
    return length


@kernel
def _step_of_argument(a, room, longest):
    """Step within which an argument changes by a small part of some room.

    For functions that tell nothing of the steep parts to come: where tanh is 1 and exp is 0
    to the last digit, their coefficients are lost.
    """
    room = log2(max(room, 1.0)) + _LOG_RADIUS
    shortest = _LONG
    for k in range(1, at.ORDER + 1):
        # each term has its share 2^-k of the change
        shortest = min(shortest, (room - log2(abs(a[k]))) * _INVERSE[k] - 1.0)
    return min(longest, exp2(shortest))


@kernel
def _positive_step(a, longest):
    """Step within which a positive function loses at most a part of its value."""
    length = longest
    for _ in range(_MOST_HALVINGS):
        change = abs(a[at.ORDER])
        for k in range(at.ORDER - 1, 0, -1):
            change = change * length + abs(a[k])
        change *= length
        if not change > _MOST_FALL * a[0]:
            break
        length *= max(0.5, _MOST_FALL * a[0] / change)
    return length


@kernel
def step_of_roots(a, order, longest, shortest):
    """Step that does not go far beyond where all roots of a guard surely are.

    Behind them lies nothing to be found, while terms that are large there would drown the
    guard in their rounding: a polynomial has a series without end. The bound of the roots is
    Fujiwara's (M. Marden, Geometry of Polynomials, 1966, section 30).

    order: of the zero at the start that is known by construction; shortest: not to be cut short
    by small flights, as at the end of accumulating impacts
    """
    least = max(order + 1, 2)  # a first root of a line at the start is of no interest
    length = longest
    for _ in range(at.ORDER):
        top = _largest_term(a, length)
        if top < least:
            break
        logarithm, leading = -_LONG, log2(abs(a[top]))
        for j in range(order, top):
            if a[j] != 0.0:
                logarithm = max(logarithm, (log2(abs(a[j])) - leading) * _INVERSE[top - j])
        beyond = max(exp2(logarithm + _BEYOND), shortest)
        if logarithm == -_LONG or beyond >= length:
            break
        length = beyond
    return length


@kernel
def _largest_term(a, length):
    top, largest, power = 0, abs(a[0]), 1.0
    for k in range(1, at.ORDER + 1):
        power *= length
        if abs(a[k]) * power > largest:
            top, largest = k, abs(a[k]) * power
    return top
