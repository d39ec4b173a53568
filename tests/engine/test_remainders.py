"""What Taylor series leave out, beside the bounds of it: every operation, against 50 digits.

A register with polynomial p of degree 20 has a bound R over a length h:
|f(s) - p(s)| <= R (s/h)^21.
Operands are polynomials in time, which series hold exactly, or functions of these, which have a
remainder of their own; states are solutions in closed form. Lengths go far beyond those of steps,
where remainders would drown in rounding.
"""

from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from engine.native_shim import remainders
from nonsmooth import Mode, System
from nonsmooth.engine import taylor_opcodes
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

LENGTHS = [2.0 ** (1 - k / 2) for k in range(24)]
PARTS = (0.1, 0.4, 0.7, 1.0)
FEW, MANY = 4, 60
# Computed coefficients are off by up to 5e-14 of the largest term (test_taylor_series). A bound is
# made of products of them; one that is 1e-11 of that term is so known to 1e-2.
KNOWN, ALLOWED = 1e-11, 1e-2

FUNCTIONS = {
    name: getattr(mp, name)
    for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "atan", "asin")
} | {"acos": mp.acos, "atan2": mp.atan2}


class Operands(NamedTuple):
    """Texts of x, v and of a number c; x and v at the start, and the other coefficients of both."""

    x: list[float]
    v: list[float]
    c: float


def plain(rng):
    """Numbers of size 1."""
    return Operands(*(list(rng.uniform(0.2, 1.5, 3) * rng.choice([-1, 1], 3)) for _ in "xv"), 1.5)


def positive(rng):
    """Starts from 1 down to 1e-4, where logarithms, roots and quotients become singular."""
    x, v, _ = plain(rng)
    x[0], v[0] = 10.0 ** rng.uniform(-4, 0, 2)
    return Operands(x, v, float(rng.choice([-30.0, -2.5, -0.5, 0.3, 1.5, 7.3, 30.5, 60.5])))


def steep(rng):
    """Factors of arguments up to 50, of either sign."""
    x, v, _ = plain(rng)
    return Operands(x, v, float(rng.choice([-50.0, -8.0, -1.0, 1.0, 3.0, 20.0])))


def near_one(rng):
    """Starts within 1 to 1e-4 of 1 or -1, where the slopes of arcs become infinite."""
    x, v, _ = plain(rng)
    x[0] = float(rng.choice([-1, 1]) * (1 - 10.0 ** rng.uniform(-4, -0.1)))
    return Operands(x, v, 0.5)


def near_pole(rng):
    """Starts within 1 to 1e-3 of the poles of the tangent."""
    x, v, _ = plain(rng)
    x[0] = float(rng.choice([-1, 1]) * (np.pi / 2 - 10.0 ** rng.uniform(-3, 0)))
    return Operands(x, v, 0.5)


OPERATIONS = {
    "x*v": plain,
    "x*v*x": plain,
    "x**2": plain,
    "(x*v)**12": plain,
    "x/v": positive,
    "1/(x*v)": positive,
    "sqrt(x)": positive,
    "sqrt(x**2 + v**2)": positive,
    "x**c": positive,
    "(x*v)**c": positive,
    "log(x)": positive,
    "exp(c*x)": steep,
    "exp(-c*x**2)": steep,
    "sin(c*x)": steep,
    "cos(c*x*v)": steep,
    "sinh(c*x)": steep,
    "cosh(c*x)": steep,
    "tan(x)": near_pole,
    "tanh(c*x)": steep,
    "atan(c*x)": steep,
    "asin(x)": near_one,
    "acos(x)": near_one,
    "atan2(x, v)": positive,
    # operands that have remainders
    "exp(x)*sin(v) + cos(x)/(2 + sin(v))": plain,
    "sqrt(1.5 + sin(c*x))": steep,
    "exp(-1/x)": positive,
    "exp(sin(c*x))": steep,
    "tan(sin(x))": near_pole,
    "log(cosh(c*x))": steep,
    "(x/v)**c": positive,
    "atan2(sin(x), v*exp(x))": positive,
    "atan(tan(x/2))": near_pole,
    "tanh(exp(x) - exp(v))": plain,
    "asin(sin(x)*cos(v))": plain,
    "acos(tanh(c*x))": steep,
    "sinh(sin(c*x))*cosh(cos(v))": steep,
    "1/(1 + exp(c*x))": steep,
}


def first_step(flow, start, parameters):
    """Tables, the segment after its first step, and the registers of the rates."""
    system = System(states=list(flow), parameters=parameters, modes={"m": Mode(flow)})
    tables = build_tables(system)
    sizes = tables.sizes
    anchor, segment = allocate_anchor(sizes), allocate_segment(sizes)
    anchor.state[:] = start
    records = allocate_records(sizes, np.array([0]), np.array([0.0]), 10)
    tangent = allocate_tangent(sizes, -1, 1)
    run((tables, no_rates(), no_scratch(), anchor, segment, tangent), records, -1, (0, 1e-9), 1e-12)
    return tables, segment, system.compiled.program.outlets[0]


def exceeding(tables, segment, register, function):
    """The number of bounds that are compared, and those that do not hold.

    An infinite one says that none was found, and what is below rounding cannot be seen.
    """
    with mp.workdps(50):
        coefficients = mpmath.taylor(function, 0, ORDER, chop=False)
        held, wrong = 0, []
        for length in LENGTHS:
            bound = remainders(tables, segment, 0, length)[register]
            largest = max(abs(c) * mpf(length) ** k for k, c in enumerate(coefficients))
            if not KNOWN * largest < bound < mp.inf:
                continue
            held += 1
            for part in PARTS:
                s = mpf(part) * mpf(length)
                polynomial = mp.polyval(coefficients, s, asc=True)
                off = abs(function(s) - polynomial)
                if not off <= mpf(bound) * mpf(part) ** (ORDER + 1) * (1 + ALLOWED):
                    wrong.append((length, part, float(off), bound))
    return held, wrong


def text_of(polynomial):
    """Rate of a polynomial in time."""
    return f"({polynomial[1]!r}) + ({2 * polynomial[2]!r})*t"


def as_function(text, operands):
    """A text as a function of time by mpmath."""
    code = compile(text, "an operation", "eval")

    def value(s):
        x, v = (mpf(a) + mpf(b) * s + mpf(c) * s**2 for a, b, c in (operands.x, operands.v))
        return eval(code, FUNCTIONS | {"x": x, "v": v, "c": mpf(operands.c)})

    return value


DRAWS = pytest.mark.parametrize("draws", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])


@pytest.mark.few(6)
@DRAWS
@pytest.mark.parametrize("text", OPERATIONS)
def test_bound_of_an_operation(text, draws):
    rng, held = np.random.default_rng(len(text)), 0
    for _ in range(draws):
        operands = OPERATIONS[text](rng)
        x, v = ([float(number) for number in each] for each in operands[:2])
        operands = Operands(x, v, operands.c)
        rate = text.replace("**c", f"**({operands.c!r})")
        flow = {"x": text_of(x), "v": text_of(v), "y": rate, "z": "sin(z)"}
        step = first_step(flow, [x[0], v[0], 0.0, 0.0], {"c": operands.c})
        count, wrong = exceeding(step[0], step[1], step[2][2], as_function(text, operands))
        assert wrong == [], operands
        held += count
    exact = text in ("x*v", "x**2", "x*v*x")  # polynomials of degree 6 at most
    assert held == 0 if exact else (held > 0 or draws == FEW)


SOLUTIONS = {
    # rate, solution from y at the start
    "y**2": lambda y, t: y / (1 - y * t),
    "-y**3": lambda y, t: y / mp.sqrt(1 + 2 * y * y * t),
    "y*(1 - y)": lambda y, t: 1 / (1 + (1 / y - 1) * mp.exp(-t)),
    "1 + y**2": lambda y, t: mp.tan(mp.atan(y) + t),
    "1 - y*y": lambda y, t: mp.tanh(mp.atanh(y) + t),
    "exp(-y)": lambda y, t: mp.log(mp.exp(y) + t),
    "sin(y)": lambda y, t: 2 * mp.atan(mp.tan(y / 2) * mp.exp(t)),
    "sqrt(y)": lambda y, t: (mp.sqrt(y) + t / 2) ** 2,
    "1/y": lambda y, t: mp.sqrt(y * y + 2 * t),
    "y**1.5": lambda y, t: (y**-0.5 - t / 2) ** -2,
    "cos(y)**2": lambda y, t: mp.atan(mp.tan(y) + t),
    "y*log(y)": lambda y, t: mp.exp(mp.log(y) * mp.exp(t)),
    "tan(y)": lambda y, t: mp.asin(mp.sin(y) * mp.exp(t)),
}


@pytest.mark.few(8)
@DRAWS
@pytest.mark.parametrize("rate", SOLUTIONS)
def test_bound_of_a_state(rate, draws):
    """Errors of states are integrals of those of their rates, which depend on them."""
    rng, held = np.random.default_rng(len(rate)), 0
    for _ in range(draws):
        start = float(rng.uniform(0.05, 0.95))
        tables, segment, _ = first_step({"y": rate, "z": "sin(z)"}, [start, 0.0], {})

        def solution(s, start=start):
            return SOLUTIONS[rate](mpf(start), s)

        count, wrong = exceeding(tables, segment, 0, solution)
        assert wrong == [], start
        held += count
    exact = rate == "sqrt(y)"  # whose solution is a polynomial
    assert held == 0 if exact else (held > 0 or draws == FEW)


def test_every_operation_is_here():
    seen = set()
    for text in OPERATIONS:
        flow = {"x": "1", "v": "1", "y": text.replace("**c", "**0.7"), "z": "sin(z)"}
        tables, *_ = first_step(flow, [0.5, 0.4, 0.0, 0.0], {"c": 0.7})
        seen |= set(tables.code["opcode"].tolist())
    assert seen == {getattr(taylor_opcodes, name) for name in taylor_opcodes.__all__}
