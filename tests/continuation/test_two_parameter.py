"""Curves over two parameters against their closed forms."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from continuation.curves import henon, henon_fixed_point, reaction, reaction_folds
from nonsmooth.continuation import follow, two_parameter


def without(count):
    """The reaction with some of its derivatives left out."""

    def residual(u, p, q):
        found = reaction(u, p, q)
        return found[0] if count == 3 else found[: 4 - count]

    return residual


@pytest.mark.parametrize("left_out", [0, 1, 3])
def test_folds_of_a_reaction(left_out):
    """Both curves of folds, which meet in a cusp at k = 4, u = 1/2."""
    q, beta = 14.0, 2.0
    x, p = reaction_folds(q)
    curve = two_parameter(
        without(left_out), "fold", [x[0], q * x[0] / (1 + beta)], p[0], q, direction=-1,
        second_bounds=(10.0, 14.0), second_scale=1.0, parameter_scale=0.1,
    )  # fmt: skip
    points = list(curve)
    (cusp,) = [point for point in points if point.special == "cusp"]
    digits = 1e-9 if left_out < 3 else 1e-5
    assert [cusp.p, *cusp.u] == pytest.approx([12, 0.5, 2, math.exp(-2)], abs=digits)
    assert curve.ended == "bound" and points[-1].p == 14.0
    assert points[-1].u[[0, 2]] == pytest.approx([x[1], p[1]], abs=digits)
    for point in points:
        k = point.p / (1 + beta)
        x1 = point.u[0]
        assert point.u[2] == pytest.approx(x1 / (1 - x1) * math.exp(-k * x1), abs=digits)
        assert k * x1 * (1 - x1) == pytest.approx(1, abs=digits)


@pytest.mark.few(1)
@pytest.mark.parametrize("left_out", [0, 1, 3])
def test_cusps_however_the_numbers_round(left_out):
    """Each start makes its own points, steps and rounding; all curves have the same cusp.

    A slope vanishes where second derivatives say: differences over 1e-5, which are good to 1e-10,
    or differences of differences over 1e-4, to 1e-6. The slope of u[0] by arclength is 0.6, and
    the curve turns by 1 and more in a unit of it: ten of these errors are more than the result's.
    """
    for q in np.linspace(12.3, 13.9, 9):
        x, p = reaction_folds(q)
        curve = two_parameter(
            without(left_out), "fold", [x[1], q * x[1] / 3.0], p[1], q, direction=-1,
            second_bounds=(11.0, q), second_scale=1.0, parameter_scale=0.1,
        )  # fmt: skip
        (cusp,) = [point for point in curve if point.special in ("cusp", "fold")]
        assert cusp.special == "cusp"
        assert cusp.u[0] == pytest.approx(0.5, abs=1e-9 if left_out < 3 else 1e-5)


@pytest.mark.parametrize("test", ["fold", lambda u, p, q: 1 - 2 * p * u[0] - q])
@pytest.mark.parametrize("parts", [1, 3])
def test_the_second_parameter_stays_within_its_bounds(test, parts):
    """Not for a difference either: a residual may have no value there."""
    low, high = 0.0, 0.5

    def residual(u, a, b):
        assert low <= b <= high
        found = henon(u, a, b)
        return found[0] if parts == 1 else found[:parts]

    a = -0.25 if test == "fold" else 0.75
    start = [2.0, 0.0] if test == "fold" else [2 / 3, 0.0]
    curve = two_parameter(residual, test, start, a, low, second_bounds=(low, high))
    *_, last = curve
    assert curve.ended == "bound" and last.p == high
    assert last.u[2] == pytest.approx(a * (1 - high) ** 2, abs=1e-12)


def flip_test(u, a, b):
    """det(M + 1) of the map at a fixed point."""
    jacobian = np.array([[-2 * a * u[0], 1.0], [b, 0.0]])
    return np.linalg.det(jacobian + np.eye(2))


def flip_test_with_derivatives(u, a, b):
    """The same: (1 - 2 a x) - b."""
    return 1 - 2 * a * u[0] - b, np.array([-2 * a, 0.0]), -2 * u[0], -1.0


@pytest.mark.parametrize("test", [flip_test, flip_test_with_derivatives])
@pytest.mark.parametrize("parts", [1, 3, 4])
def test_flips_of_a_map(test, parts):
    """The fixed point of the map of Henon doubles its period at a = 3 (1 - b)**2/4."""

    def residual(u, a, b):
        found = henon(u, a, b)
        return found[0] if parts == 1 else found[:parts]

    at_one = follow(
        lambda u, a: henon(u, a, 0.3)[:3], henon_fixed_point(0.1, 0.3), 0.1, bounds=(0.1, 2.0),
        tests=lambda point: {"flip": flip_test(point.u, point.p, 0.3)},
    )  # fmt: skip
    start = next(point for point in at_one if point.special == "flip")
    assert start.p == pytest.approx(0.75 * 0.7**2, abs=1e-13)
    curve = two_parameter(residual, test, start.u, start.p, 0.3, second_bounds=(-0.9, 0.9))
    points = list(curve)
    assert curve.ended == "bound" and points[-1].p == 0.9
    for point in points:
        assert point.u[2] == pytest.approx(0.75 * (1 - point.p) ** 2, abs=1e-12)


def test_folds_of_a_map_and_bounds_of_the_first_parameter():
    """a = -(1 - b)**2/4; the curve ends where a reaches its bound exactly."""
    b = 0.3
    curve = two_parameter(
        henon, "fold", [2 / (1 - b), 2 * b / (1 - b)], -((1 - b) ** 2) / 4, b,
        bounds=(-1.0, -0.04), second_bounds=(-0.9, 0.9), scale=3.0,
    )  # fmt: skip
    points = list(curve)
    assert curve.ended == "bound" and points[-1].special == "bound"
    assert "the first parameter reached its bound -0.04" in curve.message
    assert points[-1].u[2] == -0.04 and points[-1].p == pytest.approx(0.6, abs=1e-12)
    for point in points:
        assert point.u[2] == pytest.approx(-((1 - point.p) ** 2) / 4, abs=1e-12)


@pytest.mark.parametrize("gap", [0.0, 1e-16])
def test_a_start_on_a_bound_of_the_first_parameter(gap):
    """The folds of u**3 - q u + p lie on 27 p**2 = 4 q**3; p grows with q."""

    def cubic(u, p, q):
        return u**3 - q * u + p, 3 * u**2 - q, 1.0, -u

    u = (1 / 3) ** 0.5
    p = u - u**3
    for direction in (1, -1):
        curve = two_parameter(
            cubic, "fold", u, p, 1.0, direction=direction, bounds=(0.1, p + gap),
            second_bounds=(-1.0, 4.0),
        )  # fmt: skip
        *_, last = curve
        assert curve.ended == "bound"
        assert float(last.u[-1]) == (p + gap if direction > 0 else 0.1)


def test_closed_curve_in_two_parameters():
    """u = sin-like residual with folds on a circle of (p, q)."""

    def residual(u, p, q):
        s = p * p + q * q - 1
        return u**2 - s, 2 * u, -2 * p, -2 * q

    curve = two_parameter(residual, "fold", 0.0, 1.0, 0.0)
    points = list(curve)
    assert curve.ended == "closed"
    assert max(abs(point.u[1] ** 2 + point.p**2 - 1) for point in points) < 1e-12
    assert max(abs(point.u[0]) for point in points) < 1e-12


def test_nan_of_a_test_ends_the_curve():
    def test(u, p, q):
        return u[0] - 0.5 if q < 0.3 else math.nan

    curve = two_parameter(lambda u, p, q: u - p - q, test, 0.5, 0.5, 0.0)
    *_, last = curve
    assert curve.ended == "domain" and last.p == pytest.approx(0.3, abs=1e-5)


def test_a_matrix_as_the_test():
    """The map u -> p - u**2 + q u doubles the period of fixed points where q - 2 u = -1."""

    def residual(u, p, q):
        return p - u**2 + (q - 1) * u, q - 1 - 2 * u, np.ones(1), u

    flips = two_parameter(
        residual, 2.0 * np.eye(1), [0.5], 0.75, 0.0, second_bounds=(-1.0, 1.0), steps=200
    )
    for point in flips:
        u, p = point.u
        assert 2 * u == pytest.approx(1 + point.p, abs=1e-10)
        assert p == pytest.approx(u**2 - (point.p - 1) * u, abs=1e-10)


def test_a_matrix_of_another_size():
    with pytest.raises(ns.OptionError, match="a matrix of 1 rows"):
        two_parameter(lambda u, p, q: u - p, np.eye(2), 0.0, 0.0, 0.0)
