"""Newton's method for cycles, on the Henon map whose cycles are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.basins.attractor import refine


class Henon:
    """x' = 1 - a x**2 + y, y' = b x, with a third state that drifts by x."""

    def __init__(self, a: float, b: float) -> None:
        self.a, self.b = a, b

    def images(self, state, mode, count):
        derivative, images = np.eye(3), []
        for _ in range(count):
            x, y, z = state
            step = np.array([[-2 * self.a * x, 1, 0], [self.b, 0, 0], [1, 0, 1]])
            derivative = step @ derivative
            state = np.array([1 - self.a * x * x + y, self.b * x, z + x])
            images.append(state)
        return np.array(images), np.zeros(count, np.int64), derivative


FREE = np.array([True, True, False])


def _fixed_point(a: float, b: float) -> float:
    return (b - 1 + np.sqrt((1 - b) ** 2 + 4 * a)) / (2 * a)


def test_a_fixed_point_with_its_drift_and_multipliers() -> None:
    a, b = 0.2, 0.3
    x = _fixed_point(a, b)
    found = refine(Henon(a, b), np.array([x + 0.02, b * x, 5.0]), 0, 1, FREE, np.ones(3))
    assert found is not None
    assert found.points[0, :2] == pytest.approx([x, b * x], abs=1e-14)
    assert found.drift[2] == pytest.approx(x, abs=1e-13)
    # roots of m**2 + 2 a x m - b
    expected = np.roots([1, 2 * a * x, -b])
    assert sorted(found.multipliers.real) == pytest.approx(sorted(expected), abs=1e-13)
    assert found.stable
    assert found.step < 1e-12


def test_a_cycle_of_two() -> None:
    """a x**2 - (1 - b) x + (1 - b)**2/a - 1 = 0 for its points."""
    a, b = 0.5, 0.3
    points = np.roots([a, b - 1, (1 - b) ** 2 / a - 1]).real
    start = np.array([points[0] + 0.01, b * points[1], 0.0])
    found = refine(Henon(a, b), start, 0, 2, FREE, np.ones(3))
    assert found is not None
    assert sorted(found.points[:, 0]) == pytest.approx(sorted(points), abs=1e-13)
    trace = 4 * a * a * points[0] * points[1] + 2 * b
    assert np.sum(found.multipliers).real == pytest.approx(trace, abs=1e-12)
    assert np.prod(found.multipliers).real == pytest.approx(b * b, abs=1e-13)


def test_an_unstable_cycle_is_found_and_told() -> None:
    a, b = 1.4, 0.3
    x = _fixed_point(a, b)
    found = refine(Henon(a, b), np.array([x + 0.01, b * x, 0.0]), 0, 1, FREE, np.ones(3))
    assert found is not None
    assert found.points[0, 0] == pytest.approx(x, abs=1e-13)
    assert not found.stable


def test_what_is_far_from_a_cycle_keeps_its_residual() -> None:
    found = refine(Henon(1.4, 0.3), np.array([0.0, 0.0, 0.0]), 0, 1, FREE, np.ones(3))
    assert found is not None
    assert found.residual > 0.1
    assert found.step > 0.05
