"""Natural motions of matrices that were made from motions that are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nonsmooth.system.model.motions import natural_motions, reached


def turned(matrix, seed: int = 0) -> np.ndarray:
    """The same motions in other coordinates, all of them coupled."""
    n = len(matrix)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0]
    return turn @ np.asarray(matrix, dtype=float) @ turn.T


def chain(*numbers: float) -> np.ndarray:
    """Numbers on the diagonal, ones above."""
    return np.diag(numbers) + np.diag(np.ones(len(numbers) - 1), 1)


def oscillator(frequency: float, damping: float) -> np.ndarray:
    return np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])


def blocks(*parts: np.ndarray) -> np.ndarray:
    n = sum(len(part) for part in parts)
    matrix, at = np.zeros((n, n)), 0
    for part in parts:
        matrix[at : at + len(part), at : at + len(part)] = part
        at += len(part)
    return matrix


@pytest.mark.parametrize("damping", [-0.2, 0.0, 1e-6, 0.05, 0.7])
def test_an_oscillator(damping):
    # balancing makes the sizes of the entries harmless; in turned coordinates it cannot, and
    # the rounding of entries 40^2 apart is what remains
    cases = [(np.asarray, f, 1e-12) for f in (1e-6, 0.3, 40.0, 1e9)]
    cases += [(turned, f, 1e-11) for f in (0.3, 40.0)]
    for turn, frequency, tolerance in cases:
        (motion,) = natural_motions(turn(oscillator(frequency, damping)))
        assert motion.count == 1
        assert motion.frequency == pytest.approx(frequency, rel=tolerance)
        assert motion.damping == pytest.approx(damping, abs=tolerance)


def test_no_damping_is_none():
    (motion,) = natural_motions(oscillator(math.pi, 0.0))
    assert motion.rate.real == 0.0


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_equal_decays_in_a_chain_are_one_line(size, seed):
    # eigenvalues that meet are off by eps^(1/size); here they must not appear as oscillations
    (motion,) = natural_motions(turned(chain(*[-3.0] * size), seed))
    assert motion.count == size
    assert motion.rate == pytest.approx(-3.0, rel=1e-4)
    assert motion.rate.imag == 0.0


def test_near_and_different_decays():
    """Less than 1e-3 apart they are shown as one, by their mean.

    Eigenvectors are at right angles, so eigenvalues are good to some eps.
    """
    motions = natural_motions(turned(np.diag([-1.0, -1.0001, -1.01])))
    assert [m.count for m in motions] == [2, 1]
    assert [m.rate for m in motions] == pytest.approx([-1.00005, -1.01], abs=1e-14)


def test_stiffness_does_not_hide_slow_motions():
    motions = natural_motions(np.array([[-1e7, 1e3], [1.0, -1.0]]))
    product, total = 1e7 - 1e3, -1e7 - 1.0  # of the two eigenvalues
    fast = total / 2.0 - math.sqrt(total**2 / 4.0 - product)
    assert motions[0].rate == pytest.approx(product / fast, rel=1e-8)
    assert motions[1].rate == pytest.approx(fast, rel=1e-12)


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        ([[0.0]], [(1, 1)]),
        (np.zeros((3, 3)), [(1, 1)] * 3),  # uncoupled: each on its own line
        (chain(0.0, 0.0), [(2, 1)]),
        (turned(chain(0.0, 0.0)), [(2, 1)]),
        (blocks(chain(0.0, 0.0), np.zeros((1, 1))), [(2, 1), (1, 1)]),
        (turned(blocks(chain(0.0, 0.0), np.zeros((1, 1)))), [(3, 2)]),
        ([[0.0, 1.0], [0.0, -2.0]], [(1, 1)]),  # a speed that decays leaves a place
        ([[0, 1, 0], [0, -1, 1], [0, 0, 0.0]], [(2, 1)]),  # through a state that decays
        (np.diag([1.0, 2.0, 0.0]), [(1, 1)]),
    ],
)
def test_constants_and_rigid_bodies(matrix, expected):
    zeros = [m for m in natural_motions(np.asarray(matrix, float)) if m.rate == 0.0]
    assert [(m.count, m.chains) for m in zeros] == expected


def test_two_masses_on_a_spring():
    """Free in space: rigid-body motion and one oscillation of sqrt(k (1/m + 1/M))."""
    k, m, big = 3.0, 2.0, 5.0
    stiffness = np.array([[-k / m, k / m], [k / big, -k / big]])
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [stiffness, np.zeros((2, 2))]])
    rigid, swing = natural_motions(matrix)
    assert (rigid.rate, rigid.count, rigid.chains) == (0.0, 2, 1)
    assert swing.rate == pytest.approx(1j * math.sqrt(k * (1 / m + 1 / big)), rel=1e-12)


def test_states_of_a_motion_are_those_that_share_it():
    matrix = blocks(oscillator(2.0, 0.1), np.array([[-5.0]]), np.array([[0.0]]))
    matrix[0, 2] = 1.0  # drives the oscillator and keeps its own motion
    assert [m.states for m in natural_motions(matrix)] == [(3,), (0, 1), (2,)]
    assert reached(matrix, [2]) == {0, 1, 2}
    assert reached(matrix, [0]) == {0, 1}
    assert reached(matrix, []) == set()


entries = st.one_of(
    st.sampled_from([0.0, 1.0, -1.0]), st.floats(-1e308, 1e308), st.floats(-10.0, 10.0)
)


@given(st.integers(0, 5).flatmap(lambda n: arrays(float, (n, n), elements=entries)))
def test_any_matrix_has_as_many_motions_as_states(matrix):
    motions = natural_motions(matrix)
    assert sum(m.count * (2 if m.rate.imag else 1) for m in motions) == len(matrix)
    assert all(1 <= m.chains <= m.count for m in motions)
