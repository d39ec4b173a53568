"""Where branches cross, and their directions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from continuation.curves import lemniscate, pitchfork
from nonsmooth.continuation import branch_directions, follow


def slopes(found):
    """Angle of each direction in the plane of p and u[0], from 0 to pi."""
    return sorted(math.atan2(du[0], dp) % math.pi for du, dp in found.directions)


@pytest.mark.parametrize("derivatives", [True, False])
def test_pitchfork(derivatives):
    residual = pitchfork if derivatives else lambda u, p: pitchfork(u, p)[0]
    found = branch_directions(residual, 0.02, -0.03)
    assert [found.u[0], found.p] == pytest.approx([0, 0], abs=1e-13 if derivatives else 1e-9)
    angles = sorted(abs(angle - math.pi / 2) for angle in slopes(found))
    assert angles == pytest.approx([0, math.pi / 2], abs=1e-9 if derivatives else 1e-6)


@pytest.mark.slow
@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.1, 3.0), st.floats(-1, 1))
def test_transcritical(u0, p0, apart, bend):
    """Two curves that cross at any place and angle, and again at a distance of 1 or more."""
    first, second = 0.3, 0.3 + apart

    def crossing(u, p):
        x, y = u - u0, p - p0
        return (x - first * y - bend * apart * y * y) * (x - second * y)

    found = branch_directions(crossing, u0 + 0.01, p0 - 0.01)
    assert [found.u[0], found.p] == pytest.approx([u0, p0], abs=1e-7)
    assert slopes(found) == pytest.approx([math.atan(first), math.atan(second)], abs=1e-5)


def test_crossing_in_many_unknowns():
    """A pitchfork of the middle of three coupled unknowns, turned by a matrix of any units."""
    random = np.random.default_rng(4)
    turn, mix = np.linalg.qr(random.normal(size=(3, 3)))[0], random.normal(size=(3, 3))
    mix *= np.array([[1e4], [1.0], [1e-3]])

    def residual(u, p):
        x = turn @ u
        r = np.array([x[0] - p, x[1] * (p - 2 - x[1] ** 2), x[2] - x[1] ** 2])
        J = np.array([[1, 0, 0], [0, p - 2 - 3 * x[1] ** 2, 0], [0, -2 * x[1], 1]])
        return mix @ r, mix @ J @ turn, mix @ np.array([-1, x[1], 0])

    trivial = follow(residual, np.zeros(3), 0.0, bounds=(0, 4))
    point = next(point for point in trivial if point.special == "branch_point")
    assert point.p == pytest.approx(2, abs=1e-12)
    found = branch_directions(residual, point.u, point.p, along=(point.tangent_u, point.tangent_p))
    (along, dp), (across, still) = found.directions
    # The directions are zeros of a form of second derivatives. These are central differences of
    # rows of size 1 over eps**(1/3), so eps**(2/3) = 4e-11 is rounding in each of four entries.
    # Eigenvalues of the form are 0.3 or more, by which its errors are divided: 5e-10.
    digits = 1e-9
    assert turn @ along / dp == pytest.approx([1, 0, 0], abs=digits)
    middle = (turn @ across)[1]
    assert turn @ across / middle == pytest.approx([0, 1, 0], abs=digits)
    assert abs(still / middle) < digits
    for side in (1, -1):
        arm = follow(
            residual, found.u, found.p, direction=(side * across, side * still), bounds=(0, 4)
        )
        *_, last = arm
        assert last.p == 4 and arm.ended == "bound"
        assert abs((turn @ last.u)[1]) == pytest.approx(2**0.5, abs=1e-11)


def test_both_arms_of_a_pitchfork():
    found = branch_directions(pitchfork, 0.0, 0.0)
    du, dp = next(d for d in found.directions if abs(d[1]) < 0.5)
    ends = []
    for side in (1, -1):
        *_, last = follow(pitchfork, 0.0, 0.0, direction=(side * du, side * dp), bounds=(-1, 1))
        ends.append(last.u[0])
    assert sorted(ends) == pytest.approx([-1, 1], abs=1e-14)


def test_loop_from_a_crossing_comes_back():
    found = branch_directions(lemniscate, 0.01, 0.0)
    assert slopes(found) == pytest.approx([math.pi / 4, 3 * math.pi / 4], abs=1e-9)
    branch = follow(lemniscate, found.u, found.p, direction=found.directions[0])
    points = list(branch)
    assert branch.ended == "closed" and points[-1].special == "closed"


@pytest.mark.parametrize(
    ("residual", "status"),
    [
        (lambda u, p: (u**2 + p**2, 2 * u, 2 * p), "isolated"),
        (lambda u, p: (p**2 - u**2 - 1e-3, -2 * u, 2 * p), "imperfect"),
        (lambda u, p: (p - u**2, -2 * u, 1.0), "no_branch_point"),
        (lambda u, p: u - p, "no_branch_point"),
    ],
)
def test_no_crossing(residual, status):
    with pytest.raises(ns.RunError) as caught:
        branch_directions(residual, 0.01, 0.01)
    assert caught.value.status == status
