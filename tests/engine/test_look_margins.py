"""Margins of looks by signs, beside what their coefficients are really off by: ball arithmetic.

A look reads a guard g on a step in Bernstein form b of degree 15. With a zero of order r at the left
end, value and slope there are left out as far as r says: |b(t) - g(t)| is to be at most the margin
times the sum of the Bernstein polynomials number r to 15, so that coefficients above the margin
prove that g is positive. Guards and flows are those of `guard_cases`, with all kinds of spectra, and
chains of equal decays or oscillators that a tiny coupling closes.
"""

from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from flint import ctx
from mpmath import mpf

from engine import conditioning
from engine.flow_survey import coefficients
from engine.guard_cases import GuardCase, augmented, draw_guards
from engine.guard_survey import guarded
from engine.native_shim import look
from engine.spectra import CLASSES, Case
from engine.test_nearly_defective import chain, two_oscillators
from nonsmooth.engine.lanes import allocate_segment
from nonsmooth.errors import ModelError
from nonsmooth.simulation.runner import build_tables

DEGREE, LEVELS, ORDERS = 15, 7, 3
PLACES = (0.125, 0.375, 0.625, 1.0)
BITS, DIGITS = 320, 60
FADED = 1e-280  # a motion below it, and its margin, are nothing
FEW, MANY = range(4 * len(CLASSES)), range(80 * len(CLASSES))
COUPLINGS = [0.0, 1e-20, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8]


class Worst(NamedTuple):
    """The largest error in margins, and where it is."""

    part: float
    where: object


def parameter_values(case):
    """Values of the parameters of the template."""
    n, k = len(case.flow.start), case.flow.frequencies.size
    values = coefficients(case.flow)
    for g, row in enumerate(case.guards):
        values |= {f"h{g}_{j}": row[j] for j in range(n)} | {f"b{g}": row[n]}
        values |= {f"hc{g}_{j}": row[n + 1 + 2 * j] for j in range(k)}
        values |= {f"hs{g}_{j}": row[n + 2 + 2 * j] for j in range(k)}
    return {name: float(value) for name, value in values.items()}


def guard_at(case, row, time):
    """A guard after a time, right to 60 digits of its terms."""
    if time == 0.0:
        state = [mpf(float(x)) for x in case.start]
    else:
        with ctx.workprec(BITS):
            state = [
                mpf(y.mid().str(DIGITS, radius=False))
                for y in conditioning.flow(case.matrix, case.start, time, BITS)
            ]
    return mpmath.fdot([mpf(float(h)) for h in row], state)


def slope_at_start(case, row):
    """Rate of a guard at the start."""
    rates = [
        mpmath.fdot([mpf(float(a)) for a in line], [mpf(float(x)) for x in case.start])
        for line in case.matrix
    ]
    return mpmath.fdot([mpf(float(h)) for h in row], rates)


def weights_at(t):
    """Bernstein polynomials of degree 15 at t."""
    return [mpmath.binomial(DEGREE, i) * t**i * (1 - t) ** (DEGREE - i) for i in range(DEGREE + 1)]


def worst_of(case, level, order, time):
    """The largest error of all guards of a case in their margins."""
    n, k, e = len(case.flow.start), case.flow.frequencies.size, len(case.guards)
    tables = build_tables(guarded(n, k, e), parameter_values(case))
    if tables.spans["looks"][0] == 0:
        return None
    segment = allocate_segment(tables.sizes)
    segment.z[:] = case.start
    worst = Worst(0.0, None)
    with mpmath.workdps(DIGITS):
        for g, row in enumerate(case.guards):
            seen = look(tables, segment, g, level, order, time)
            if order > 0 and seen.fading > 1e-3 * seen.margin:
                continue  # such a look is left open
            for place in PLACES:
                end = time + seen.step * place
                t = (mpf(end) - mpf(time)) / mpf(seen.step)  # the place, now that the end is rounded
                weights = weights_at(t)
                true = guard_at(case, row, end)
                if order > 0:
                    true -= guard_at(case, row, 0.0)
                if order > 1:
                    true -= slope_at_start(case, row) * (mpf(end) - mpf(time))
                found = mpmath.fdot(weights, [mpf(float(b)) for b in seen.coefficients])
                margin = mpf(seen.margin) + mpf(seen.fading) + FADED
                part = float(abs(found - true) / (margin * sum(weights[order:])))
                if part > worst.part:
                    worst = Worst(part, (level, order, time, g, place))
    return worst
