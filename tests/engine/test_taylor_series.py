"""Coefficients of all orders by the compiled kernels, against derivatives by mpmath.

The states are x = 0.7 + 0.3 s - 0.2 s^2 and v = 1.1 - 0.4 s + 0.1 s^2, solutions of equations
whose rates are lines of the time; other rates are functions of both.
"""

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from nonsmooth import Mode, System
from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.lanes import (
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
)
from nonsmooth.engine.tables import ORDER
from nonsmooth.runs.runner import build_tables

X, V = (0.7, 0.3, -0.2), (1.1, -0.4, 0.1)
PARAMETERS = {"a": 0.7, "b": -1.3, "c": 0.4}


def _x(s):
    return mpf(X[0]) + mpf(X[1]) * s + mpf(X[2]) * s**2


def _v(s):
    return mpf(V[0]) + mpf(V[1]) * s + mpf(V[2]) * s**2


def first_step(text):
    """The segment after its first step, and the register of a rate."""
    system = System(
        states=["x", "v", "y"],
        parameters=PARAMETERS,
        modes={"m": Mode({"x": "0.3 - 0.4*t", "v": "-0.4 + 0.2*t", "y": text})},
    )
    tables = build_tables(system)
    sizes = tables.sizes
    anchor, segment = allocate_anchor(sizes), allocate_segment(sizes)
    anchor.state[:] = X[0], V[0], 0.0
    records = allocate_records(sizes, np.array([0]), np.array([0.0]), 10)
    tangent = allocate_tangent(sizes, -1, 1)
    lane = (tables, no_rates(), no_scratch(), anchor, segment, tangent)
    run(lane, records, -1, (0, 1e-9), 1e-12)
    return segment, system.compiled.program.outlets[0, 2]


TEXTS = {
    # sums with each form of products, and with many terms
    "x*v + v": lambda x, v: x * v + v,
    "x**2 - 3*v**2": lambda x, v: x**2 - 3 * v**2,
    "a*x*v + b*v*(x - 2*v)": lambda x, v: _A * x * v + _B * v * (x - 2 * v),
    "x**2 - x*v + 1": lambda x, v: x**2 - x * v + 1,
    "2*v**2 + x": lambda x, v: 2 * v**2 + x,
    "x*v*(x + v) - x**2 + v**2 + 3*x - v + a": lambda x, v: (
        x * v * (x + v) - x**2 + v**2 + 3 * x - v + _A
    ),
    "(x*v)**3": lambda x, v: (x * v) ** 3,
    "sin(x) + cos(x) + sqrt(v) + log(x) + exp(v) - 2*x": lambda x, v: (
        mp.sin(x) + mp.cos(x) + mp.sqrt(v) + mp.log(x) + mp.exp(v) - 2 * x
    ),
    # every function
    "x/v": lambda x, v: x / v,
    "1/(1 + x**2)": lambda x, v: 1 / (1 + x**2),
    "sqrt(x*v)": lambda x, v: mp.sqrt(x * v),
    "v**a": lambda x, v: v ** mpf(0.7),
    "x**(-c)": lambda x, v: x ** -mpf(0.4),
    "log(x)": lambda x, v: mp.log(x),
    "exp(-x*v)": lambda x, v: mp.exp(-x * v),
    "sin(3*x)": lambda x, v: mp.sin(3 * x),
    "cos(2*v)": lambda x, v: mp.cos(2 * v),
    "sinh(x)": lambda x, v: mp.sinh(x),
    "cosh(v)": lambda x, v: mp.cosh(v),
    "tan(x/2)": lambda x, v: mp.tan(x / 2),
    "tanh(v)": lambda x, v: mp.tanh(v),
    "atan(x)": lambda x, v: mp.atan(x),
    "asin(x/2)": lambda x, v: mp.asin(x / 2),
    "acos(v/3)": lambda x, v: mp.acos(v / 3),
    "atan2(x, v)": lambda x, v: mp.atan2(x, v),
    # time and harmonics
    "x*cos(2*t + 0.3) + t*v": None,
}
_A, _B = mpf(0.7), mpf(-1.3)


@pytest.mark.parametrize("text", TEXTS)
def test_all_coefficients(text):
    function = TEXTS[text]

    def along(s):
        if function is None:
            return _x(s) * mp.cos(2 * s + mpf(0.3)) + s * _v(s)
        return function(_x(s), _v(s))

    with mp.workdps(60):
        true = [float(c) for c in mpmath.taylor(along, 0, ORDER)]
    segment, register = first_step(text)
    found = segment.series["c"][register]
    # The functions have their singular places farther than 0.9 from the start. On a circle of that
    # radius the k-th term has an error of some tens of roundings, each with the k or so that a
    # recurrence hands on: 20 * 20 * 1.1e-16 = 5e-14 of the largest term.
    radius = 0.9
    size = max(abs(c) * radius**k for k, c in enumerate(true))
    for k, (each, truth) in enumerate(zip(found, true, strict=True)):
        assert each * radius**k == pytest.approx(truth * radius**k, rel=1e-13, abs=5e-14 * size)


def test_rounding_is_known_where_there_are_no_guards():
    # the length of a step asks for it; what an earlier step has left would make a run that goes on
    # another one than a run in one piece
    segment, register = first_step("x*v")
    extent, units = segment.doubt[register]
    assert 0.0 < extent < units
