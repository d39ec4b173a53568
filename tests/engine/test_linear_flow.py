"""The exact flow against 50-digit matrix exponentials.

Unit of error: the sum of the sizes of the terms of exp(A t) x, which is what any method in
double precision can at best be measured by. Well-conditioned spectra must come out within
1e-13 of it (some hundred operations of 1e-16), clusters within 1e-12.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.linear_systems import computed, linear_system, truth

RNG = np.random.default_rng(5)


def error(matrix, time, start=None, forcing=None, frequency=None):
    start = RNG.normal(size=len(matrix)) if start is None else start
    found = computed(linear_system(matrix, forcing, frequency), start, time)
    expected, sizes = truth(matrix, start, time, forcing, frequency)
    return np.max(np.abs(found - expected) / np.maximum(sizes, 1e-300))


@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2])
def test_critical_damping_and_its_neighbours(distance):
    assert error([[0, 1], [-1, -2 * (1 + distance)]], 10.0) < 1e-12


@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2])
def test_undamped_resonance_and_its_neighbours(distance):
    found = error([[0, 1], [-1, 0]], 50.0, forcing=[0, 1.0], frequency=1 + distance)
    assert found < 1e-12


RIGID = {
    "falling mass": [[0, 1], [0, 0]],
    "chain of five integrators": np.diag(np.ones(4), 1),
    "two masses, spring, damper": [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-1, 1, -0.1, 0.1],
        [1, -1, 0.1, -0.1],
    ],
    "two masses, spring": [[0, 0, 1, 0], [0, 0, 0, 1], [-1, 1, 0, 0], [1, -1, 0, 0]],
    "nothing moves": np.zeros((3, 3)),
}


@pytest.mark.parametrize("name", RIGID)
def test_motion_at_eigenvalue_zero(name):
    assert error(np.array(RIGID[name], float), 20.0) < 1e-12


def test_identical_oscillators_apart_and_coupled():
    apart = np.kron(np.eye(2), [[0, 1], [-4, -0.1]])
    in_series = [[0, 1, 0, 0], [-1, -0.02, 1, 0], [0, 0, 0, 1], [0, 0, -1, -0.02]]
    assert error(apart, 20.0) < 1e-13
    assert error(np.array(in_series), 20.0) < 1e-12


def test_units_do_not_matter():
    # 1 kg on 1 GN/m, seconds and metres: entries a factor of 1e9 apart
    assert error([[0, 1], [-1e9, -2]], 1e-3) < 1e-13


@settings(max_examples=25)
@given(st.integers(1, 6), st.integers(0, 10**6))
def test_random_decaying_systems(size, seed):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(size, size))
    matrix -= np.eye(size) * (np.linalg.eigvals(matrix).real.max() + 0.1)
    # eigenvector condition of such matrices reaches 1e3 now and then
    condition = np.linalg.cond(np.linalg.eig(matrix)[1])
    assert error(matrix, 10.0, rng.normal(size=size)) < 1e-14 * max(10.0, condition)


def test_strongly_non_normal_mode():
    # eigenvalues -1 and -100, made of parts of size 3e6 that cancel
    a = 3e8
    matrix = np.array([[a, -(a + 1)], [a + 100, -(a + 101)]])
    # a change of the matrix by one rounding changes the answer by a hundred million of them
    assert error(matrix, 1.0, np.ones(2)) < 1e-16 * 4 * a
