"""Where branches end, and what they say."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from continuation.curves import circle, cubic
from nonsmooth.continuation import follow


def test_bounds_are_hit_exactly_and_never_passed():
    asked = []

    def residual(u, p):
        asked.append(p)
        return u - math.sin(3 * p)

    for direction, bound in ((1, 0.7), (-1, -0.1)):
        branch = follow(residual, 0.0, 0.0, direction=direction, bounds=(-0.1, 0.7))
        *_, last = branch
        assert last.p == bound and last.special == "bound" and branch.ended == "bound"
        assert last.u[0] == pytest.approx(math.sin(3 * bound), abs=1e-14)
    assert min(asked) == -0.1 and max(asked) == 0.7


def test_bound_between_two_points_of_an_arc():
    """The circle is beyond p = 0.999 for less than a step."""
    branch = follow(circle, 1.0, 0.0, bounds=(-2, 0.999), largest_step=0.2, parameter_scale=1.0)
    *_, last = branch
    assert branch.ended == "bound" and last.p == 0.999
    assert last.u[0] == pytest.approx(math.sqrt(1 - 0.999**2), abs=1e-14)


def test_fold_just_inside_a_bound_is_no_end():
    points = list(follow(circle, 1.0, 0.0, bounds=(-2.0, 1.0 + 1e-9), parameter_scale=1.0))
    assert points[-1].special == "closed"
    assert [p.p for p in points if p.special == "fold"] == pytest.approx([1, -1], abs=1e-14)


def test_start_on_a_bound():
    outward = follow(cubic, 1.6, -2.0, direction=-1, bounds=(-2, 2))
    assert [point.special for point in outward] == ["bound"] and outward.ended == "bound"
    inward = follow(cubic, 1.6, -2.0, direction=1, bounds=(-2, 2))
    assert len(list(inward)) > 5


def slope(u, p):
    return u - math.sin(3 * p), np.array([[1.0]]), np.array([-3 * math.cos(3 * p)])


@pytest.mark.parametrize("gap", [0.0, 1e-16, -1e-16, 1e-13, 1e-11, 1e-9])
@pytest.mark.parametrize("given", [True, False])
def test_start_within_rounding_of_a_bound(gap, given):
    """With a direction the parameter is corrected too, and comes off the bound by rounding."""
    away = (np.array([3 * math.cos(3.9)]), 1.0) if given else 1
    branch = follow(slope, math.sin(3.9), 1.3, direction=away, bounds=(0, max(1.3, 1.3 + gap)))
    *_, last = branch
    assert branch.ended == "bound" and last.p == max(1.3, 1.3 + gap) and last.special == "bound"


@pytest.mark.parametrize("gap", [1e-16, 1e-14, 1e-12, 1e-10, 1e-8])
def test_a_bound_just_behind_a_point(gap):
    """Points are as before where the bound is farther away; each is tried."""
    before = [point.p for point in follow(slope, 0.0, 0.0, bounds=(0, 9), parameter_scale=1.0)]
    for p in before[1:8]:
        branch = follow(slope, 0.0, 0.0, bounds=(0, p + gap), parameter_scale=1.0)
        *_, last = branch
        assert branch.ended == "bound" and last.p == p + gap
        assert last.u[0] == pytest.approx(math.sin(3 * last.p), abs=1e-14)


def test_start_at_a_fold_on_a_bound():
    for residual in (lambda u, p: (u**2 - p, 2 * u, -1.0), lambda u, p: u**2 - p):
        *_, last = follow(residual, 0.0, 0.0, bounds=(0, 3))
        assert last.p == 3 and abs(last.u[0]) == pytest.approx(3**0.5, abs=1e-14)


@pytest.mark.parametrize("noise", [1e-10, 1e-8])
def test_residuals_with_some_noise(noise):
    random = np.random.default_rng(0)

    def noisy(u, p):
        r, J_u, J_p = cubic(u, p)
        return r + noise * random.uniform(-1, 1), J_u, J_p

    points = list(follow(noisy, 1.6, -2.5, bounds=(-2.5, 2.5)))
    folds = [point.p for point in points if point.special == "fold"]
    assert folds == pytest.approx([2 / 27**0.5, -2 / 27**0.5], abs=3 * noise)
    assert points[-1].special == "bound"


def test_more_noise_needs_a_larger_tolerance():
    random = np.random.default_rng(0)

    def noisy(u, p):
        return cubic(u, p)[0] + 1e-6 * random.uniform(-1, 1), *cubic(u, p)[1:]

    with pytest.raises(ns.RunError, match=r"from the start at p = -2.5.*larger tolerance="):
        follow(noisy, 1.6, -2.5, bounds=(-2.5, 2.5))
    branch = follow(noisy, 1.6, -2.5, bounds=(-2.5, 2.5), tolerance=1e-5)
    assert sum(point.special == "fold" for point in branch) == 2 and branch.ended == "bound"


def nan_beyond(u, p):
    return u - p if p <= 1 else np.nan * u


def raises_beyond(u, p):
    if p > 1:
        raise ZeroDivisionError
    return u - p


def singular_beyond(u, p):
    if p > 1:
        raise np.linalg.LinAlgError("no")
    return u - p, 1.0, -1.0


def square_root(u, p):
    return u - p + 0.0 * math.sqrt(1 - p)


@pytest.mark.parametrize("residual", [nan_beyond, raises_beyond, singular_beyond, square_root])
def test_end_of_the_domain(residual):
    """Reached to the smallest step."""
    branch = follow(residual, 0.0, 0.0, smallest_step=1e-9)
    *_, last = branch
    assert branch.ended == "domain" and 1 - 1e-8 < last.p <= 1
    assert "no finite value beyond p = 1" in branch.message or "0.99999" in branch.message


def test_other_errors_of_a_residual_are_not_hidden():
    def residual(u, p):
        if p > 0.5:
            raise ValueError("a mistake of its own")
        return u - p

    with pytest.raises(ValueError, match="mistake"):
        list(follow(residual, 0.0, 0.0))


def test_steps_run_out():
    branch = follow(cubic, 1.6, -2.0, steps=3)
    assert len(list(branch)) == 4 and branch.ended == "steps"
    assert "steps=" in branch.message


def test_corner_of_a_curve():
    """Two half lines that meet at a right angle: no tangent turns from one into the other."""

    def bent(u, p):
        return u - abs(p), 1.0, 1.0 if p < 0 else -1.0

    branch = follow(bent, 1.0, -1.0, bounds=(-2, 2))
    *_, last = branch
    assert branch.ended == "smallest_step" and -1e-7 < last.p <= 0
    assert "corner" in branch.message and "smallest_step=" in branch.message


def test_gentle_corner_is_passed():
    *_, last = follow(lambda u, p: u - p - 0.1 * abs(p), 0.0, -1.0, bounds=(-2, 2))
    assert last.special == "bound" and last.u[0] == pytest.approx(2.2, abs=1e-13)


def test_stopped():
    branch = follow(cubic, 1.6, -2.0)
    seen = 0
    for point in branch:
        seen += 1
        if point.p > -1.0:
            branch.stop("far enough")
    assert branch.ended == "stopped" and branch.message == "far enough"
    assert seen < 30 and list(branch) == []


def test_wrong_derivatives_are_named_as_a_cause():
    branch = follow(lambda u, p: (u**3 - u + p, -(3 * u**2 - 1), 1.0), 1.5213797068, -2.0)
    list(branch)
    assert branch.ended == "smallest_step" and "derivatives" in branch.message
