"""Derivatives of a tape against differences at 50 digits, and where there is no difference."""

import math

import mpmath
import pytest
from mpmath import mp

from engine.doubled_systems import FUNCTIONS
from engine.native_shim import run_tape
from nonsmooth.engine import opcodes as op


def rates(rows, parameters, chosen=None):
    """Value and derivatives of the last instruction of a tape without literals."""
    slots, found = run_tape(parameters, rows, range(len(parameters)) if chosen is None else chosen)
    return slots[-1], found[-1].tolist()


UNARY = set(FUNCTIONS) - {op.ADD, op.MULTIPLY, op.DIVIDE, op.POWER, op.ATAN2}


@pytest.mark.parametrize("code", sorted(FUNCTIONS))
@pytest.mark.parametrize("point", [(0.3, 0.7), (0.9, -1.4), (0.01, 2.0)])
def test_every_smooth_instruction(code, point):
    found = rates([(code, 0, 0 if code in UNARY else 1, 0)], point)[1]
    with mpmath.workdps(50):
        expected = [
            mp.diff(lambda x: FUNCTIONS[code](x, mp.mpf(point[1])), point[0]),
            mp.diff(lambda y: FUNCTIONS[code](mp.mpf(point[0]), y), point[1]),
        ]
    assert found == pytest.approx([float(x) for x in expected], rel=4e-15, abs=1e-300)


def test_chains_and_shared_slots():
    # d/dp of (p q)^p sin(p q)
    p, q = 1.3, 0.4
    rows = [(op.MULTIPLY, 0, 1, 0), (op.POWER, 2, 0, 0), (op.SIN, 2, 0, 0), (op.MULTIPLY, 3, 4, 0)]
    x = p * q
    by_p = x**p * ((math.log(x) + 1) * math.sin(x) + q * math.cos(x))
    by_q = x**p * (p / q * math.sin(x) + p * math.cos(x))
    assert rates(rows, [p, q])[1] == pytest.approx([by_p, by_q], rel=1e-14)
    assert rates(rows, [p, q], [1])[1] == pytest.approx([by_q], rel=1e-14)


@pytest.mark.parametrize(
    ("base", "exponent", "expected"),
    [(0.0, 2.0, 0.0), (0.0, 1.0, 1.0), (0.0, 0.0, 0.0), (-2.0, 3.0, 12.0), (-2.0, -1.0, -0.25)],
)
def test_powers_of_bases_that_have_no_logarithm(base, exponent, expected):
    assert rates([(op.POWER, 0, 1, 0)], [base, exponent], [0])[1] == [expected]


def test_exponent_at_base_zero():
    assert rates([(op.POWER, 0, 1, 0)], [0.0, 2.0], [1])[1] == [0.0]
    assert math.isnan(rates([(op.POWER, 0, 1, 0)], [-2.0, 2.0], [1])[1][0])


def test_an_infinite_derivative_counts_only_where_something_moves():
    # sqrt(p) at p = 0, by p and by a parameter that it does not depend on
    _, (by_p, by_q) = rates([(op.SQRT, 0, 0, 0)], [0.0, 1.0])
    assert by_p == math.inf
    assert by_q == 0.0
    assert rates([(op.DIVIDE, 1, 0, 0)], [2.0, 0.0], [1])[1] == [0.5]


def test_piecewise_functions_have_the_derivative_of_the_active_branch():
    def by(code, *values):
        third = 2 if len(values) > 2 else 0
        return rates([(code, 0, 1, third)], values)[1]

    assert by(op.ABS, -2.0, 1.0) == [-1.0, 0.0]
    assert by(op.SIGN, -2.0, 1.0) == [0.0, 0.0]
    assert by(op.MINIMUM, -2.0, 1.0) == [1.0, 0.0]
    assert by(op.MAXIMUM, -2.0, 1.0) == [0.0, 1.0]
    assert by(op.HEAVISIDE, -2.0, 1.0) == [0.0, 0.0]
    assert by(op.LESS, -2.0, 1.0) == [0.0, 0.0]
    assert by(op.SELECT, 1.0, 5.0, 6.0) == [0.0, 1.0, 0.0]
    assert by(op.SELECT, 0.0, 5.0, 6.0) == [0.0, 0.0, 1.0]
