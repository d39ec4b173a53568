"""Solutions of z' = f(t, z, p) as power series in time, to any order, by Picard's iteration.

A right-hand side is an ordinary Python function that returns one rate per state. It uses
operators and the functions below, so it takes mpmath numbers, balls and power series alike:

    def pendulum(t, z, p):
        angle, speed = z
        return [speed, -sin(angle) - p.c * speed]

Each pass z <- z0 + integral of f(t, z) makes one more coefficient right. The coefficients are
balls of python-flint, whose radii show what rounding did to them.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flint import arb, arb_series, ctx
from mpmath import mp, mpf

Function = Callable[[Any, Sequence[Any], Any], Any]  # of t, z, p


def sin(x: Any) -> Any:
    return x.sin() if hasattr(x, "sin") else mp.sin(x)


def cos(x: Any) -> Any:
    return x.cos() if hasattr(x, "cos") else mp.cos(x)


def exp(x: Any) -> Any:
    return x.exp() if hasattr(x, "exp") else mp.exp(x)


def sqrt(x: Any) -> Any:
    return x.sqrt() if hasattr(x, "sqrt") else mp.sqrt(x)


def expand(
    rates: Function, slaved: Mapping[int, Function], t: arb, z: Sequence[arb], p: Any, order: int
) -> tuple[arb_series, list[arb_series]]:
    """Clock and states as series in the time since ``t``, with ``order`` coefficients.

    ``slaved`` maps the number of a state to the relation that it follows instead of its rate.
    """
    ctx.cap = order
    start = [arb_series([x], 1) for x in z]
    clock, states = arb_series([t], 1), start
    for length in range(2, order + 1):
        known = [as_series(rate, length - 1) for rate in rates(clock, states, p)]
        clock = arb_series([t, 1], length)
        states = [
            arb_series([x], length) + rate.integral() for x, rate in zip(z, known, strict=True)
        ]
        for number, relation in slaved.items():
            states[number] = as_series(relation(clock, states, p), length)
    return clock, states


def as_series(x: Any, length: int) -> arb_series:
    """A value that may be a plain number, as a series."""
    return x if isinstance(x, arb_series) else arb_series([x], length)


def coefficients(series: arb_series) -> list[arb]:
    """All of them; flint leaves out the zeros at the end."""
    found = series.coeffs()
    return found + [arb(0)] * (series.prec - len(found))


def rate_of(row: Sequence[arb]) -> list[arb]:
    """The coefficients of the derivative."""
    return [c * (k + 1) for k, c in enumerate(row[1:])]


def safe_step(rows: Sequence[Sequence[arb]], tolerance: mpf, longest: mpf) -> mpf:
    """The step at which the last two terms of each row are below ``tolerance``."""
    step = longest
    for row in rows:
        for k in (len(row) - 2, len(row) - 1):
            size = mpf(float(abs(row[k].mid())))
            if size:
                step = min(step, (tolerance / size) ** (mpf(1) / k))
    return step


def value_at(row: Sequence[arb], s: arb) -> arb:
    """The sum of the row at s."""
    value = row[-1]
    for c in reversed(row[:-1]):
        value = value * s + c
    return value
