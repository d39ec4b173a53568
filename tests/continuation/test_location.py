"""Zeros of tests along a branch."""

import math

import numpy as np
import pytest

from continuation.curves import circle, cubic
from nonsmooth.continuation import follow


def names_and_places(branch):
    return [(point.special, point.p) for point in branch if point.special]


def test_zeros_are_found_to_rounding_and_in_order():
    def tests(point):
        return {
            "third": point.p - 1 / 3,
            "cube": (point.u[0] - 0.5) ** 3,
            "wave": math.sin(9 * point.p),
        }

    found = names_and_places(
        follow(lambda u, p: (u - p, 1.0, -1.0), -0.1, -0.1, bounds=(-0.1, 0.6), tests=tests)
    )
    assert [name for name, _ in found] == ["wave", "third", "wave", "cube", "bound"]
    expected = [0.0, 1 / 3, math.pi / 9, 0.5, 0.6]
    assert [p for _, p in found][:3] == pytest.approx(expected[:3], abs=1e-14)
    assert found[3][1] == pytest.approx(0.5, abs=1e-5)  # a triple zero has a third of the digits


def test_tests_see_points_as_they_are_given():
    seen = {}

    def tests(point):
        seen[point.arclength] = (point.u.copy(), point.tangent_p)
        return {"height": point.u[0] - 0.25}

    points = list(follow(circle, 1.0, 0.0, tests=tests))
    for point in points:
        assert seen[point.arclength][1] == point.tangent_p
        assert point.tests["height"] == point.u[0] - 0.25
    marked = [point for point in points if point.special == "height"]
    assert [abs(point.tests["height"]) for point in marked] == pytest.approx([0, 0], abs=1e-14)


def test_poles_are_no_zeros_and_jumps_are_found():
    def tests(point):
        return {"pole": 1 / (point.p - 0.3), "jump": 1.0 if point.p > 0.6 else -1.0}

    found = names_and_places(follow(lambda u, p: u - p, 0.0, 0.0, bounds=(0, 1), tests=tests))
    assert [name for name, _ in found] == ["jump", "bound"]
    assert found[0][1] == pytest.approx(0.6, abs=1e-14)


@pytest.mark.parametrize("value", [math.nan, math.inf], ids=str)
def test_values_that_are_not_available(value):
    """No sign changes to or from them; the others are found all the same."""

    def tests(point):
        return {"some": value if point.p > 0.5 else 1.0, "p": point.p - 0.75}

    found = names_and_places(follow(lambda u, p: u - p, 0.0, 0.0, bounds=(0, 1), tests=tests))
    assert found == [("p", pytest.approx(0.75, abs=1e-15)), ("bound", 1.0)]


def test_tests_that_fail_are_not_available():
    def tests(point):
        if point.p > 0.5:
            raise np.linalg.LinAlgError
        return {"p": point.p - 0.25}

    found = names_and_places(follow(lambda u, p: u - p, 0.0, 0.0, bounds=(0, 1), tests=tests))
    assert [name for name, _ in found] == ["p", "bound"]


def test_zero_that_is_hit_by_a_point():
    """Reported once, not on both sides."""
    points = list(
        follow(
            lambda u, p: (u - 0.0 * p, 1.0, 0.0), 0.0, 0.0, bounds=(-4.0, 4.0), parameter_scale=1.0,
            step=0.125, largest_step=0.125, tests=lambda point: {"half": point.p - 0.5},
        )
    )  # fmt: skip
    assert [(point.special, point.p) for point in points if point.special] == [
        ("half", 0.5), ("bound", 4.0),
    ]  # fmt: skip
    assert sum(point.p == 0.5 for point in points) == 1


def test_fold_and_test_within_one_step():
    def tests(point):
        return {"before": point.u[0] - 0.02, "after": point.u[0] + 0.03}

    found = names_and_places(follow(circle, 1.0, 0.0, tests=tests, steps=40, bounds=(0, 2)))
    assert [name for name, _ in found][:3] == ["before", "fold", "after"]


def test_two_folds_about_a_test_within_one_step():
    """p = u^3 - w^2 u turns back at u = -w/sqrt(3) and w/sqrt(3), and rises at both ends."""
    width = 0.01

    def wiggle(u, p):
        return u**3 - width**2 * u - p, 3 * u**2 - width**2, -1.0

    branch = follow(
        wiggle, -0.5, -0.125 + 0.5 * width**2, bounds=(-0.2, 0.2), step=0.3, largest_step=0.3,
        tests=lambda point: {"middle": point.u[0] - 1e-4}, scale=1.0, parameter_scale=1.0,
    )  # fmt: skip
    points = list(branch)
    found = [(point.special, point.p) for point in points if point.special]
    assert [name for name, _ in found] == ["fold", "middle", "fold", "bound"]
    highest = 2 * width**3 / math.sqrt(27)
    assert [p for _, p in found][::2] == pytest.approx([highest, -highest], abs=1e-12)
    inside = [point for point in points if abs(point.u[0]) < width and not point.special]
    assert not inside  # the step has passed all of it


def test_identical_points_do_not_make_folds():
    """A branch on which p stands still has no folds, though rounding has signs."""
    branch = follow(lambda u, p: (p - 0.3 + 0.0 * u, 0.0, 1.0), 0.0, 0.3, steps=30)
    assert not [point for point in branch if point.special]


def test_cubic_again_from_the_other_side():
    one = names_and_places(follow(cubic, -1.6, 2.0, direction=-1, bounds=(-2.5, 2.5)))
    other = names_and_places(follow(cubic, 1.6, -2.0, direction=1, bounds=(-2.5, 2.5)))
    assert [p for _, p in one][:2] == pytest.approx([p for _, p in other][1::-1], abs=1e-15)
