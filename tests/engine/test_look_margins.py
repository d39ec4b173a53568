"""Margins of looks by signs, beside what their coefficients are really off by: ball arithmetic.

A look reads a guard g on a step in Bernstein form b of degree 15. With a zero of order r at the
left end, value and slope there are left out as far as r says: |b(t) - g(t)| is to be at most the
margin times the sum of the Bernstein polynomials number r to 15. So coefficients above the margin
prove that g is positive. Guards and flows are those of `guard_cases`, with all kinds of spectra,
and chains of equal decays or oscillators that a tiny coupling closes.
"""

from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from flint import ctx
from mpmath import mpf

from engine import conditioning
from engine.guard_cases import GuardCase, augmented, draw_guards
from engine.guard_survey import guarded, parameter_values
from engine.native_shim import look
from engine.spectra import CLASSES, Case
from engine.test_nearly_defective import chain, two_oscillators
from nonsmooth.engine.lanes import allocate_segment
from nonsmooth.errors import ModelError
from nonsmooth.runs.runner import build_tables

DEGREE, LEVELS, ORDERS = 15, 7, 3
PLACES = (0.125, 0.375, 0.625, 1.0)
BITS, DIGITS = 320, 60
TRUTH = 1e-50  # part of its terms up to which the truth is known
FADED = 1e-280  # a motion below it, and its margin, are nothing
FEW, MANY = range(2 * len(CLASSES)), range(80 * len(CLASSES))
COUPLINGS = [0.0, 1e-20, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8]


class Worst(NamedTuple):
    """The largest error in margins, and where it is."""

    part: float
    where: object


def guard_at(case, row, time):
    """A guard after a time, right to 60 digits of its terms."""
    state = [mpf(float(x)) for x in case.start]
    if time > 0.0:
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
                t = (mpf(end) - mpf(time)) / mpf(
                    seen.step
                )  # the place, now that the end is rounded
                weights = weights_at(t)
                now, start = guard_at(case, row, end), guard_at(case, row, 0.0)
                slope = slope_at_start(case, row) * (mpf(end) - mpf(time))
                left_out = [mpf(0), start, start + slope][order]
                true = now - left_out
                found = mpmath.fdot(weights, [mpf(float(b)) for b in seen.coefficients])
                margin = (
                    mpf(seen.margin) + mpf(seen.fading) + TRUTH * (abs(now) + abs(left_out)) + FADED
                )
                part = float(abs(found - true) / (margin * sum(weights[order:])))
                if part > worst.part:
                    worst = Worst(part, (level, order, time, g, place))
    return worst


def holds_everywhere(case, rng, time):
    """Whether the case has looks by signs; its margins hold on every level, for every order."""
    for level in range(LEVELS):
        for order in range(ORDERS):
            for start in [0.0] if order else [0.0, float(rng.uniform(0.0, time))]:
                worst = worst_of(case, level, order, start)
                if worst is None:
                    return False
                assert worst.part <= 1.0, worst
    return True


def judge(seed):
    """Whether the case of a seed has looks by signs; one level and order of its margins hold."""
    case, rng = draw_guards(seed), np.random.default_rng([seed, 5])
    level, order = int(rng.integers(LEVELS)), int(rng.integers(ORDERS))
    time = 0.0 if order else float(rng.choice([0.0, rng.uniform(0.0, case.time)]))
    try:
        worst = worst_of(case, level, order, time)
    except ModelError:  # units that differ by more than a mode may have
        return False
    assert worst is None or worst.part <= 1.0, (case.name, worst)
    return worst is not None


def case_of(matrix, rng):
    """Two guards along a flow from a random start."""
    n, none = len(matrix), np.zeros((len(matrix), 0))
    flow = Case(matrix, 5.0, rng.normal(size=n), np.zeros(0), none, none)
    guards = np.zeros((2, n + 1))
    guards[0, 0], guards[1, :] = 1.0, rng.normal(size=n + 1)
    return GuardCase("nearly defective", 0, flow, *augmented(flow), guards, ())


@pytest.mark.slow
def test_margins_of_all_kinds_of_spectra():
    assert sum(judge(seed) for seed in FEW) > len(FEW) / 3


@pytest.mark.slow
def test_margins_of_many_spectra():
    assert sum(judge(seed) for seed in MANY) > len(MANY) / 3


@pytest.mark.slow
@pytest.mark.parametrize("eps", COUPLINGS)
@pytest.mark.parametrize("rate", [0.0, -0.3, -30.0])
def test_margins_of_nearly_defective_chains(rate, eps):
    rng = np.random.default_rng([int(-10 * rate), COUPLINGS.index(eps)])
    looked = [holds_everywhere(case_of(chain(n, rate, eps), rng), rng, 3.0) for n in (2, 4)]
    assert all(looked) or (rate, eps) != (0.0, 0.0)


@pytest.mark.parametrize("eps", COUPLINGS)
def test_margins_of_nearly_equal_oscillators(eps):
    rng = np.random.default_rng(COUPLINGS.index(eps))
    holds_everywhere(case_of(two_oscillators(eps), rng), rng, 20.0)


@pytest.mark.few(1)
@pytest.mark.parametrize("rate", [1e2, 1e4, 1e5])
def test_margins_of_a_stiff_mode(rate):
    """A slow oscillator and what relaxes towards it: on the way, and where it has faded."""
    rng = np.random.default_rng(int(rate))
    matrix = np.array([[0.0, 1.0, 0.0], [-2.0, -0.1, 0.0], [rate, 0.0, -rate]])
    assert holds_everywhere(case_of(matrix, rng), rng, 5.0)
