"""The parameter tape: coefficients of a system from the values of its parameters.

A tape is a list of instructions on numbered slots: parameters first, then literals, then
one slot per instruction. It lets one compiled kernel set up any system.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import opcodes as op
from nonsmooth.engine.arrays import copy_vector
from nonsmooth.engine.jit import kernel

__all__ = ["run_tape"]


@kernel
def run_tape(parameters, constants, tape, slots):
    """Fill the slots of a tape.

    shapes: parameters (p,), constants (c,), tape (i, 4), slots (p + c + i,)
    """
    n_parameters = parameters.size
    base = n_parameters + constants.size
    copy_vector(parameters, slots, n_parameters)
    for i in range(constants.size):
        slots[n_parameters + i] = constants[i]
    for i in range(tape.shape[0]):
        code = tape[i, 0]
        x = slots[tape[i, 1]]
        y = slots[tape[i, 2]]
        if code < op.SIN:
            slots[base + i] = _arithmetic(code, x, y)
        elif code < op.SIGN:
            slots[base + i] = _function(code, x, y)
        else:
            slots[base + i] = _piecewise(code, x, y, slots[tape[i, 3]])


@kernel
def _arithmetic(code, x, y):
    if code == op.ADD:
        return x + y
    if code == op.MULTIPLY:
        return x * y
    if code == op.DIVIDE:
        return x / y
    if code == op.POWER:
        return x**y
    return -x


@kernel
def _function(code, x, y):
    if code < op.SINH:
        return _trigonometric(code, x, y)
    if code == op.SINH:
        return math.sinh(x)
    if code == op.COSH:
        return math.cosh(x)
    if code == op.TANH:
        return math.tanh(x)
    if code == op.EXP:
        return math.exp(x)
    if code == op.LOG:
        return math.log(x) if x > 0.0 else np.nan
    return math.sqrt(x) if x >= 0.0 else np.nan


@kernel
def _trigonometric(code, x, y):
    if code == op.SIN:
        return math.sin(x)
    if code == op.COS:
        return math.cos(x)
    if code == op.TAN:
        return math.tan(x)
    if code == op.ASIN:
        return math.asin(x) if abs(x) <= 1.0 else np.nan
    if code == op.ACOS:
        return math.acos(x) if abs(x) <= 1.0 else np.nan
    if code == op.ATAN:
        return math.atan(x)
    return math.atan2(x, y)


@kernel
def _piecewise(code, x, y, third):
    if code == op.SIGN:
        return np.sign(x)
    if code == op.ABS:
        return abs(x)
    if code == op.MINIMUM:
        return min(x, y)
    if code == op.MAXIMUM:
        return max(x, y)
    if code == op.HEAVISIDE:
        return 1.0 if x >= 0.0 else 0.0
    if code == op.GREATER:
        return 1.0 if x > y else 0.0
    if code == op.GREATER_EQUAL:
        return 1.0 if x >= y else 0.0
    if code == op.LESS:
        return 1.0 if x < y else 0.0
    if code == op.LESS_EQUAL:
        return 1.0 if x <= y else 0.0
    return y if x != 0.0 else third
