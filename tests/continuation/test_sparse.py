"""A thousand unknowns with a sparse Jacobian, and what it has in common with dense ones."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from continuation.curves import sparse_bratu
from nonsmooth.continuation import follow
from nonsmooth.continuation.bordered import solve_bordered
from nonsmooth.continuation.equations import Linearised


def test_bratu_with_a_thousand_unknowns():
    """The second differences move the fold by a multiple of 1/n**2: two grids say how much."""
    folds = {}
    for n in (499, 999):
        branch = follow(sparse_bratu(n), np.zeros(n), 0.0, steps=40)
        folds[n] = next(point.p for point in branch if point.special == "fold")
    limit = (4 * folds[999] - folds[499]) / 3
    assert limit == pytest.approx(3.513830719125, abs=2e-9)
    assert 1e-7 < abs(folds[999] - limit) < 1e-5  # so that the line above has something to do


def test_steps_do_not_depend_on_the_mesh():
    """Arclength is that of the field, so a finer mesh takes no more steps."""
    steps = [
        len(list(follow(sparse_bratu(n), np.zeros(n), 0.0, bounds=(-1.0, 3.0)))) for n in (100, 400)
    ]
    assert abs(steps[0] - steps[1]) <= 1


def test_few_unknowns_sparse_or_not():
    n = 12
    thin = sparse_bratu(n)

    def full(u, p):
        r, J_u, J_p = thin(u, p)
        return r, J_u.toarray(), J_p

    one, other = (list(follow(each, np.zeros(n), 0.0, steps=30)) for each in (thin, full))
    assert [point.p for point in one] == [point.p for point in other]


@given(st.integers(0, 10**6), st.integers(2, 40), st.floats(0.05, 0.6))
def test_sparse_solution_and_determinant(seed, n, density):
    """Step, tangent and determinant are those of the dense matrix."""
    random = np.random.default_rng(seed)
    J_u = sparse.random_array((n, n), density=density, rng=random).tocsr()
    J_u = J_u + sparse.diags_array(random.normal(size=n))
    J_p, r, border = (random.normal(size=n), random.normal(size=n), random.normal(size=n + 1))
    border /= np.linalg.norm(border)
    scale = 10.0 ** random.uniform(-2, 2, size=n + 1)
    thin = solve_bordered(Linearised(r, J_u, J_p), border, scale)
    full = solve_bordered(Linearised(r, J_u.toarray(), J_p), border, scale)
    matrix = np.vstack([np.column_stack([J_u.toarray(), J_p]) * scale, thin.tangent])
    condition = np.linalg.cond(np.vstack([matrix[:-1], border]))
    if condition > 1e7:
        return
    np.testing.assert_allclose(thin.tangent, full.tangent, atol=1e-14 * condition)
    np.testing.assert_allclose(thin.step, full.step, rtol=1e-6, atol=1e-6)
    sign, log = np.linalg.slogdet(matrix)
    assert thin.determinant.sign == full.determinant.sign == sign
    assert [thin.determinant.log, full.determinant.log] == pytest.approx([log, log], abs=1e-6)


def test_second_differences_at_the_fold():
    """J_u is singular there, and the tangent is the null vector of its own symmetric matrix."""
    n = 300
    residual = sparse_bratu(n)
    fold = next(point for point in follow(residual, np.zeros(n), 0.0) if point.special == "fold")
    values, vectors = np.linalg.eigh(residual(fold.u, fold.p)[1].toarray())
    place = np.abs(values).argmin()
    assert abs(values[place]) < 1e-8 * np.abs(values).max()
    tangent = fold.tangent_u / np.linalg.norm(fold.tangent_u)
    assert abs(tangent @ vectors[:, place]) == pytest.approx(1.0, abs=1e-10)
    assert math.isfinite(fold.residual)
