"""Derivatives of the slots of a parameter tape with respect to some of the parameters.

Dual arithmetic along the tape: each instruction has two partial derivatives. A partial
derivative may be infinite (a square root at zero) and then counts only where its operand
moves at all. Piecewise functions have the derivative of the active branch.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import opcodes as op
from nonsmooth.engine.jit import kernel

__all__ = ["run_tape_rates"]


@kernel
def run_tape_rates(parameters, constants, tape, slots, chosen, rates):
    """Fill the derivatives of the slots of a tape that `run_tape` has filled.

    shapes: parameters (p,), constants (c,), tape (i, 4), slots (p + c + i,), chosen (P,)
    numbers of parameters, rates (p + c + i, P) output
    """
    base = parameters.size + constants.size
    for k in range(chosen.size):
        for j in range(base):
            rates[j, k] = 1.0 if j == chosen[k] else 0.0
    for i in range(tape.shape[0]):
        code, left, right = tape[i, 0], tape[i, 1], tape[i, 2]
        if code == op.SELECT:
            taken = right if slots[left] != 0.0 else tape[i, 3]
            for k in range(chosen.size):
                rates[base + i, k] = rates[taken, k]
            continue
        by_left, by_right = _partial(code, slots[left], slots[right], slots[base + i])
        for k in range(chosen.size):
            total = 0.0
            if rates[left, k] != 0.0:
                total += by_left * rates[left, k]
            # functions of one operand leave the right one at slot 0, with no weight
            if by_right != 0.0 and rates[right, k] != 0.0:
                total += by_right * rates[right, k]
            rates[base + i, k] = total


@kernel
def _partial(code, x, y, value):
    """Derivatives of the value of an instruction by its first and second operand."""
    if code < op.SIN:
        return _of_arithmetic(code, x, y, value)
    if code == op.ATAN2:
        square = x * x + y * y
        return y / square, -x / square
    if code < op.SINH:
        return _of_trigonometric(code, x, value), 0.0
    if code < op.SIGN:
        return _of_function(code, x, value), 0.0
    if code == op.ABS:
        return np.sign(x), 0.0
    if code == op.MINIMUM:
        return (1.0, 0.0) if x <= y else (0.0, 1.0)
    if code == op.MAXIMUM:
        return (1.0, 0.0) if x >= y else (0.0, 1.0)
    return 0.0, 0.0  # sign, heaviside and comparisons are constant in pieces


@kernel
def _of_arithmetic(code, x, y, value):
    if code == op.ADD:
        return 1.0, 1.0
    if code == op.MULTIPLY:
        return y, x
    if code == op.DIVIDE:
        return 1.0 / y, -value / y
    if code == op.POWER:
        return _of_power(x, y, value)
    return -1.0, 0.0


@kernel
def _of_power(x, y, value):
    """Of x ** y; at x = 0 the limits, and none by y where x is negative."""
    by_base = y * x ** (y - 1.0) if y != 0.0 else 0.0
    if x > 0.0:
        return by_base, value * math.log(x)
    return by_base, 0.0 if x == 0.0 and y > 0.0 else np.nan


@kernel
def _of_trigonometric(code, x, value):
    if code == op.SIN:
        return math.cos(x)
    if code == op.COS:
        return -math.sin(x)
    if code == op.TAN:
        return 1.0 + value * value
    if code == op.ATAN:
        return 1.0 / (1.0 + x * x)
    rate = 1.0 / math.sqrt((1.0 - x) * (1.0 + x)) if abs(x) <= 1.0 else np.nan
    return rate if code == op.ASIN else -rate


@kernel
def _of_function(code, x, value):
    if code == op.SINH:
        return math.cosh(x)
    if code == op.COSH:
        return math.sinh(x)
    if code == op.TANH:
        return 1.0 - value * value
    if code == op.EXP:
        return value
    if code == op.LOG:
        return 1.0 / x
    return 0.5 / value
