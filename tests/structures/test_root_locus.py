"""`root_locus` against closed forms and against all eigenvalues by numpy."""

import numpy as np
import pytest
import scipy.sparse as sp

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, eigenpairs, natural_modes, root_locus, shaft

RNG = np.random.default_rng(8)


def first_order(structure, speed=0.0):
    """All eigenvalues of the dense first-order form."""
    m, c, k = (sp.csr_array(each).toarray() for each in structure.at_speed(speed))
    n, inverse = len(m), np.linalg.inv(m)
    return np.linalg.eigvals(
        np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ c]])
    )


LOADS = np.linspace(0.0, 150.0, 31)


@pytest.mark.parametrize("damping", [15.0, 25.0])  # it oscillates at the first load, or does not
def test_a_column_that_buckles_is_unstable(damping):
    """x'' + c x' + (100 - p) x = 0 grows for p > 100, and does not decay at 100."""
    found = root_locus(lambda p: ns.Structure([[1.0]], [[100.0 - p]], damping=[[damping]]), LOADS)
    assert found["stable"].values.tolist() == (LOADS < 100.0).tolist()
    for row, load in zip(found["eigenvalue"].values, LOADS, strict=True):
        exact = np.sort_complex(np.roots([1.0, damping, 100.0 - load]))
        ours = np.sort_complex(row[~np.isnan(row)])
        # a pair counts once
        np.testing.assert_allclose(ours, exact[exact.imag >= 0.0], rtol=1e-12, atol=1e-13)
    # each path is one curve: no step is longer than those of the square root at a double root
    steps = np.abs(np.diff(found["eigenvalue"].values, axis=0))
    assert np.nanmax(steps) < 2.0 * np.sqrt(LOADS[1])


def test_a_column_that_buckles_beside_a_mode_that_oscillates():
    found = root_locus(
        lambda p: ns.Structure(
            np.eye(2), np.diag([100.0 - p, 400.0]), damping=np.diag([25.0, 0.4])
        ),
        LOADS,
        count=1,
    )
    assert found["stable"].values.tolist() == (LOADS < 100.0).tolist()
    assert found["eigenvalue"].values[0, 0] == pytest.approx(-0.2 + 1j * np.sqrt(399.96))
    largest = np.nanmax(found["eigenvalue"].values.real, axis=1)
    exact = [max(np.roots([1.0, 25.0, 100.0 - load]).real.max(), -0.2) for load in LOADS]
    np.testing.assert_allclose(largest, exact, rtol=1e-12, atol=1e-13)


def test_all_eigenvalues_are_followed_through_overdamped_motions():
    """Of a structure whose damping grows: pairs become real ones, and real ones pairs."""
    a, b, c, g = RNG.normal(size=(4, 4, 4))
    mass, stiffness = a @ a.T + np.eye(4), 100.0 * (b @ b.T + np.eye(4))

    def damped(p):
        return ns.Structure(mass, stiffness, damping=p * (c @ c.T) + (20.0 - p) * (g - g.T))

    values = np.linspace(0.0, 40.0, 41)
    found = root_locus(damped, values)
    seen = set()
    for row, value in zip(found["eigenvalue"].values, values, strict=True):
        every = first_order(damped(value))
        every = every[every.imag >= 0.0]
        row = row[~np.isnan(row)]
        assert len(row) == len(every)
        assert all(np.abs(row - each).min() < 1e-9 * abs(each) for each in every)
        seen.add(int((row.imag == 0.0).sum()))
    assert len(seen) > 1


def test_what_is_unstable_is_seen_beyond_the_modes_that_are_followed():
    """Damping a - p K drives the fastest mode first, of 120 masses between springs."""
    n, least = 120, 0.05
    stiffness = sp.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)],
                               offsets=[-1, 0, 1]).tocsc()  # fmt: skip
    onset = least / (4.0 * np.cos(np.pi / (2 * n + 2)) ** 2)

    def driven(p):
        damping = least * sp.eye_array(n) - p * stiffness
        return ns.Structure(sp.eye_array(n).tocsc(), stiffness, damping=damping.tocsc())

    found = root_locus(driven, onset * np.array([0.5, 0.99, 1.01]), count=2)
    assert found["stable"].values.tolist() == [True, True, False]
    assert (found["eigenvalue"].values.real < 0.0).all()


def whirling(q):
    """A shaft of 164 coordinates in oil."""
    held = [Bearing([f"{i}x", f"{i}y"], [[2e7, q], [-q, 1.5e7]], 6e3) for i in (0, 40)]
    return shaft([Beam(0.025, 0.05)] * 40, damping=(0.0, 1e-6), bearings=held, sparse=True)


def test_few_eigenvalues_tell_of_a_large_structure(monkeypatch):
    """By a bound of those that the cross-coupling could drive; numpy has all of them."""
    values = [0.0, 2e6, 4e6, 8e6]
    exact = [first_order(whirling(q)).real.max() < 0.0 for q in values]

    def refused(pencil):
        raise AssertionError("all eigenvalues are asked for")

    monkeypatch.setattr(eigenpairs, "_by_decomposition", refused)
    found = root_locus(whirling, values, count=3)["stable"].values.tolist()
    assert found == exact and True in found and False in found


def test_where_the_eigenvalues_are_too_many_there_is_a_word(monkeypatch):
    n = 160
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    driven = ns.Structure(np.eye(n), stiffness, damping=0.05 * np.eye(n) - 0.02 * stiffness)
    monkeypatch.setattr(eigenpairs, "_LARGEST_DENSE", 80)
    with pytest.warns(
        ns.ResultWarning, match="stable: of 160 degrees of freedom only the 16 eigen"
    ):
        assert root_locus(driven, [0.0, 1.0], count=2)["stable"].all()


def test_rigid_motions_are_left_aside():
    """Two discs on a floating shaft turn together without a force; their twist decays, or grows."""
    shape = np.array([[1.0, -1.0], [-1.0, 1.0]])
    found = root_locus(
        lambda c: ns.Structure(np.eye(2), shape, damping=c * shape), [0.5, 0.1, -0.1]
    )
    assert found["stable"].values.tolist() == [True, True, False]
    assert found.sizes["mode"] == 1


def test_the_sense_of_whirl_is_that_of_natural_modes():
    found = root_locus(whirling, [0.0, 2e6], count=2, speed=300.0)
    modes = natural_modes(whirling(2e6), 300.0, count=8)
    for mode in (0, 1):
        value = found["eigenvalue"].values[1, mode]
        same = int(np.argmin(np.abs(modes["eigenvalue"].values - value)))
        assert found["direction"].values[1, mode] == modes["direction"].values[same]
        assert found["whirl"].values[1, mode] == pytest.approx(modes["whirl"].values[same])
