import numpy as np
import pytest

from nonsmooth.analysis.statistics.periodicity import primitive_period, scales

NONE = np.zeros(2, bool)


def cycle(p, count, drift=0.0):
    """Points of a cycle with p different ones, the second coordinate drifting."""
    rng = np.random.default_rng(p)
    one = rng.normal(size=(p, 2))
    points = one[np.arange(count) % p]
    points[:, 1] += drift * (np.arange(count) // p)
    return points


@pytest.mark.parametrize("p", [1, 2, 3, 7, 12])
def test_the_period_of_a_cycle(p):
    points = cycle(p, 40)
    assert primitive_period(points, NONE, scales(points, NONE), 1e-9) == p


@pytest.mark.parametrize("p", [1, 2, 5])
def test_a_drift_repeats_its_steps(p):
    drifting = np.array([False, True])
    points = cycle(p, 40, drift=1.7)
    assert primitive_period(points, drifting, scales(points, drifting), 1e-9) == p
    assert primitive_period(points, NONE, scales(points, NONE), 1e-9) == 0


def test_a_period_is_seen_twice_or_not_believed():
    points = cycle(6, 12)  # one and eleven twelfths of a cycle repeated
    assert primitive_period(points, NONE, scales(points, NONE), 1e-9) == 0
    points = cycle(6, 13)
    assert primitive_period(points, NONE, scales(points, NONE), 1e-9) == 6


def test_nearly_the_same_is_as_given():
    points = cycle(2, 40)
    points[::2] += 1e-5 * np.random.default_rng(1).normal(size=(20, 2))
    scale = scales(points, NONE)
    assert primitive_period(points, NONE, scale, 1e-3) == 2
    assert primitive_period(points, NONE, scale, 1e-7) == 0


def test_points_that_are_no_numbers_have_no_period():
    points = np.full((9, 2), np.nan)
    assert primitive_period(points, NONE, np.ones(2), 1e-6) == 0
