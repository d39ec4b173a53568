"""Branches in closed form: on them, through their folds, round them, and nowhere else."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from continuation.curves import (
    chebyshev_bratu,
    circle,
    cubic,
    lemniscate,
    reaction,
    reaction_folds,
)
from nonsmooth.continuation import follow


def named(points, name):
    return [point for point in points if point.special == name]


@pytest.mark.parametrize("direction", [1, -1])
def test_circle_closes(direction):
    branch = follow(circle, 1.0, 0.0, direction=direction)
    points = list(branch)
    assert branch.ended == "closed" and points[-1].special == "closed"
    assert points[-1].arclength == pytest.approx(2 * math.pi, abs=1e-13)
    assert [p.p for p in named(points, "fold")] == pytest.approx([direction, -direction], abs=1e-15)
    for point in points:
        angle = direction * point.arclength
        assert [point.u[0], point.p] == pytest.approx([math.cos(angle), math.sin(angle)], abs=1e-13)
        assert [point.tangent_u[0], point.tangent_p] == pytest.approx(
            [-direction * math.sin(angle), direction * math.cos(angle)], abs=1e-12
        )
        assert point.residual < 1e-5
    arclengths = [point.arclength for point in points]
    assert np.all(np.diff(arclengths) > 0)
    assert np.cumsum([point.step for point in points]) == pytest.approx(arclengths, abs=1e-12)


def test_without_derivatives_the_same():
    """Central differences cost digits of the tangent, not of the points."""
    points = list(follow(lambda u, p: u**2 + p**2 - 1, 1.0, 0.0))
    assert [p.p for p in named(points, "fold")] == pytest.approx([1, -1], abs=1e-15)
    assert max(abs(p.u[0] ** 2 + p.p**2 - 1) for p in points) < 1e-14


def test_folds_of_a_cubic():
    branch = follow(cubic, -1.5, 1.875, direction=-1, bounds=(-2.0, 2.0))
    folds = named(branch, "fold")
    assert branch.ended == "bound"
    assert [fold.p for fold in folds] == pytest.approx(np.array([-2, 2]) / 27**0.5, abs=1e-15)
    assert [fold.u[0] for fold in folds] == pytest.approx(np.array([-1, 1]) / 3**0.5, abs=1e-13)
    assert max(abs(fold.tangent_p) for fold in folds) < 1e-12


def test_bratu():
    """The fold of the continuous problem: p = 8 (t/cosh t)**2 at t tanh t = 1."""
    t = brentq(lambda t: t * math.tanh(t) - 1, 1.0, 1.5, xtol=1e-15)
    residual, n = chebyshev_bratu(30)
    (fold,) = named(follow(residual, np.zeros(n), 0.0, steps=60), "fold")
    assert 8 * (t / math.cosh(t)) ** 2 == pytest.approx(3.513830719125, abs=1e-12)
    assert fold.p == pytest.approx(8 * (t / math.cosh(t)) ** 2, abs=1e-11)
    middle = fold.u[n // 2]  # exp(u/2) = cosh t there
    assert middle == pytest.approx(2 * math.log(math.cosh(t)), abs=1e-9)


def test_reaction_in_a_stirred_tank():
    q, beta = 14.0, 2.0
    x, p = reaction_folds(q)

    def tests(point):
        return {"hopf": np.trace(reaction(point.u, point.p, q)[1])}

    branch = follow(
        lambda u, p: reaction(u, p, q)[:3], [0.0, 0.0], 0.0, bounds=(0, 0.3), tests=tests
    )
    points = list(branch)
    folds = named(points, "fold")
    assert [fold.p for fold in folds] == pytest.approx(p, abs=1e-14)
    assert [fold.u[0] for fold in folds] == pytest.approx(x, abs=1e-12)
    # on equilibria p exp(u[1]) = x/(1 - x), so the trace is q x - x/(1 - x) - 2 - beta
    at = np.roots([-q, q + 1 + beta, -(2 + beta) + 0.0])
    found = sorted(point.u[0] for point in named(points, "hopf"))
    trace = [q * x - x / (1 - x) - 2 - beta for x in found]
    assert len(found) == 2 and max(map(abs, trace)) < 1e-11
    assert found == pytest.approx(sorted(at), abs=1e-12)
    assert branch.ended == "bound" and points[-1].p == 0.3


def test_figure_of_eight():
    """Through its crossing, straight on, twice; the length is the lemniscate constant."""
    branch = follow(lemniscate, 0.0, 1.0, largest_step=0.05)
    points = list(branch)
    assert branch.ended == "closed"
    assert points[-1].arclength == pytest.approx(5.244115108584239, rel=1e-6)
    crossings = named(points, "branch_point")
    assert len(crossings) == 2
    assert max(max(abs(c.u[0]), abs(c.p)) for c in crossings) < 1e-13
    assert all(abs(abs(c.tangent_u[0] / c.tangent_p) - 1) < 1e-6 for c in crossings)


def test_more_or_fewer_equations_than_two():
    """Three numbers are a residual of three, with and without derivatives."""
    for residual in (
        lambda u, p: (u[0] - p, u[1] - p**2, u[2] - p**3),
        lambda u, p: (
            [u[0] - p, u[1] - p**2, u[2] - p**3],
            np.eye(3),
            [-1, -2 * p, -3 * p * p],
        ),
    ):
        *_, last = follow(residual, [0.0, 0.0, 0.0], 0.0, bounds=(0, 2))
        assert last.u == pytest.approx([2, 4, 8], abs=1e-12)


def test_start_is_corrected_at_its_parameter():
    first = next(follow(cubic, 1.6, -2.0))
    assert first.p == -2.0 and first.u[0] == pytest.approx(np.roots([1, 0, -1, -2])[0].real)


def test_start_at_a_fold():
    """There is no solution at exactly this p, or J_u is singular: the nearest point is taken."""
    for p in (1.0, 1.01):
        first = next(follow(circle, 0.0, p))
        assert first.u[0] ** 2 + first.p**2 == pytest.approx(1.0, abs=1e-14)
        assert abs(first.tangent_p) < 1e-6


_PLACES, _SIZES = st.floats(-3, 3), st.floats(0.1, 10)


@pytest.mark.slow
@given(_PLACES, _PLACES, _SIZES, _SIZES, st.sampled_from([1, -1]))
def test_any_ellipse(u0, p0, a, b, direction):
    def ellipse(u, p):
        x, y = (u - u0) / a, (p - p0) / b
        return x**2 + y**2 - 1, 2 * x / a, 2 * y / b

    branch = follow(ellipse, u0 + a, p0, direction=direction, scale=a, parameter_scale=b, steps=100)
    points = list(branch)
    folds = [point.p for point in named(points, "fold")]
    assert branch.ended == "closed"
    assert points[-1].arclength == pytest.approx(2 * math.pi, abs=1e-11)
    assert folds == pytest.approx([p0 + direction * b, p0 - direction * b], abs=1e-13 * (3 + b))


@pytest.mark.slow
@given(st.integers(0, 10**6), st.floats(-6, 6), st.floats(-6, 6))
def test_equations_may_be_mixed_and_have_any_units(seed, first, second):
    """Rows that are combined and multiplied say the same."""
    mix = np.random.default_rng(seed).normal(size=(2, 2)) + 3 * np.eye(2)
    mix = np.diag(10.0 ** np.array([first, second])) @ mix

    def mixed(u, p):
        r, J_u, J_p, _ = reaction(u, p, 14.0)
        return mix @ r, mix @ J_u, mix @ J_p

    branch = follow(mixed, [0.0, 0.0], 0.0, bounds=(0, 0.3))
    folds = [point.p for point in named(branch, "fold")]
    assert folds == pytest.approx(reaction_folds(14.0)[1], abs=1e-11)


def test_steps_that_are_not_accepted_are_halved():
    """Two zeros of a test lie within the first long step over them, and show no change of sign."""

    def two_zeros(point):
        return {"zero": (point.p - 0.5) * (point.p - 0.52)}

    options = {"bounds": (0.0, 1.0), "step": 0.2, "tests": two_zeros}

    def over_both(points):
        return points[0].p < 0.5 and points[-1].p > 0.52

    def accept(points):
        assert [point.arclength for point in points] == sorted(p.arclength for p in points)
        return not over_both(points) or sum(point.special == "zero" for point in points) == 2

    def zeros(branch):
        return [point.p for point in branch if point.special == "zero"]

    assert zeros(follow(lambda u, p: u - p**2, 0.0, 0.0, **options)) == []
    found = zeros(follow(lambda u, p: u - p**2, 0.0, 0.0, accept=accept, **options))
    assert found == pytest.approx([0.5, 0.52], abs=1e-12)


def test_a_branch_ends_where_no_step_is_accepted():
    branch = follow(lambda u, p: u - p, 0.0, 0.0, accept=lambda points: points[-1].p < 0.3)
    assert max(point.p for point in branch) == pytest.approx(0.3, abs=2e-8)
    assert branch.ended == "smallest_step"
