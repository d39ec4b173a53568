r"""Eigenvalues of a pencil that are nearest to zero, with their vectors.

The eigenvalue problem is :math:`(\lambda^2 M + \lambda C + K) \phi = 0`. Where the pencil is small,
all of them come from one dense decomposition. Else shift and invert: Arnoldi's method with one
factorisation, and one more run of it on what is left over when the space of the eigenvectors found
is taken out, which would show an eigenvalue that was passed over. This is needed where two are
equal, as those of a shaft in both planes.

Rounding of an eigenvalue is relative to its modulus, or worse: to the largest one of the pencil.
Damping that is little beside it would drown, and a structure without any would have some of either
sign. The power that the motion loses tells it to nearly all digits, see `_balanced`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, RunError
from nonsmooth.structures.matrices import check_definite, dense, is_sparse
from nonsmooth.structures.pencil import Pencil, solver_of

__all__ = ["Eigenpairs", "check_mass", "is_small", "nearest_to_zero", "refined"]

Array = npt.NDArray[Any]

_DENSE = 80  # degrees of freedom up to which a dense decomposition is as fast
_LARGEST_DENSE = 3000  # beyond which it takes too long, and too much memory
_GUARD = 8  # eigenvalues beyond those asked for
_SHIFT = 1e-3  # of the size of a frequency: K itself has no inverse where the structure floats
_CLOSE = 1e-6
_NEAR_ZERO = 1e-4  # of the size of a frequency: where eigenvalues may be those of rigid motions
_NO_FORCE = 1e-14  # of the sum of the sizes of its terms
_SAME_DIRECTION = 1e-3  # between vectors of such eigenvalues
_MOST_STEPS = 12  # of a refinement, which doubles the digits with each
_LITTLE = 1e-3  # damping ratio below which the balance of power is more exact than the eigenvalue
_OUTWEIGHS = 1e-3  # of its terms: a sum that is not their rounding
_ROUNDING = 64.0 * float(np.finfo(float).eps)


class Eigenpairs(NamedTuple):
    """Eigenvalues with imaginary parts not below zero, by growing size, and vectors as columns."""

    values: npt.NDArray[np.complex128]
    vectors: npt.NDArray[np.complex128]


def check_mass(pencil: Pencil) -> None:
    """Refuse a mass matrix that is not positive definite; its eigenvalues would be infinite."""
    names = pencil.structure.coordinates
    empty = [name for name, m in zip(names, pencil.M.diagonal(), strict=True) if m == 0.0]
    if empty:
        raise ModelError(
            f"mass: coordinates without inertia, {', '.join(empty[:5])}; condense them, or give"
            " them the inertia that they have"
        )
    check_definite(pencil.M)


def is_small(size: int, count: int = 0) -> bool:
    """Whether all eigenvalues of so many coordinates cost no more than a number of them."""
    return size <= _DENSE or (count > 0 and (2 * count + _GUARD) * 4 > size)


def nearest_to_zero(pencil: Pencil, count: int | None) -> Eigenpairs:
    """So many modes, or all: pairs of conjugate eigenvalues count once, real ones each."""
    check_mass(pencil)
    size = pencil.structure.size
    wanted = size if count is None else min(count, 2 * size)
    if is_small(size, wanted):
        if size > _LARGEST_DENSE:
            raise ModelError(
                f"count = {count}: of {size} degrees of freedom at most {size // 8 - _GUARD} modes"
                " can be computed; ask for fewer"
            )
        found = _by_decomposition(pencil)
    else:
        found = _by_arnoldi(pencil, wanted)
    some = slice(None if count is None else wanted)
    values, vectors = found.values[some], found.vectors[:, some]
    return Eigenpairs(_balanced(pencil, values, vectors), vectors)


def _balanced(pencil: Pencil, values: Array, vectors: Array) -> Array:
    r"""Eigenvalues of little damping, whose real part is that of the balance of power.

    With :math:`m = \phi^* M \phi`, and c and k alike, an eigenpair has
    :math:`\lambda^2 m + \lambda c + k = 0`, of which the product with the conjugate of lambda
    has the real part
    :math:`\mathrm{Re}\lambda\,(|\lambda|^2 \mathrm{Re}\,m + \mathrm{Re}\,k) +
    |\lambda|^2 \mathrm{Re}\,c + \mathrm{Im}\lambda\,(\mathrm{Im}\,k -
    |\lambda|^2 \mathrm{Im}\,m) = 0`. What feeds or drains the motion, the symmetric part of C and
    the skew parts of K and M, are taken as matrices of their own, so that they are zero to the last
    digit where there are none, and else have the relative error of the vector.
    """
    size = np.abs(values)
    some = (np.abs(values.real) < _LITTLE * size) & (values.imag > 0.0)
    if not some.any():
        return values
    shapes, square, turn = vectors[:, some], size[some] ** 2, values.imag[some]

    def form(matrix: Any) -> Array:
        return np.asarray(np.einsum("ij,ij->j", shapes.conj(), matrix @ shapes))

    inertia, stiffness = square * form(pencil.M).real, form(pencil.K).real
    drained = square * form(0.5 * (pencil.C + pencil.C.T)).real
    fed = [form(0.5 * (each - each.T)).imag for each in (pencil.K, pencil.M)]
    loss, energy = drained + turn * (fed[0] - square * fed[1]), inertia + stiffness
    told = energy > _OUTWEIGHS * (inertia + np.abs(stiffness))
    real = np.where(told, (0.0 - loss) / np.where(told, energy, 1.0), values.real[some])
    found = values.copy()
    found[some] = real + 1j * turn
    return found


def _sorted(values: Array, vectors: Array, pencil: Pencil) -> Eigenpairs:
    """One of each conjugate pair, by size; rigid motions first, with the eigenvalue zero."""
    upper = values.imag >= 0.0
    order = np.argsort(np.abs(values[upper]), kind="stable")
    values, vectors = values[upper][order], vectors[:, upper][:, order]
    vectors = vectors / np.linalg.norm(vectors, axis=0)
    rigid, basis = _rigid_motions(values, vectors, pencil)
    values = np.concatenate([np.zeros(basis.shape[1]), values[~rigid]])
    vectors = np.hstack([basis, vectors[:, ~rigid]])
    return Eigenpairs(values.astype(complex), vectors.astype(complex))


def _rigid_motions(values: Array, vectors: Array, pencil: Pencil) -> tuple[Array, Array]:
    """Which vectors are motions without a restoring force, and a basis of these.

    Each is twice an eigenvalue zero with one vector, or two, so that half of the digits of the
    eigenvalue are lost and it cannot be told from that of a soft support. The force that the motion
    asks for can: it is rounding, once what the vector has of other modes is taken from it by a step
    of inverse iteration.
    """
    rigid = np.zeros(len(values), dtype=bool)
    unit = _frequency(pencil)
    near = np.flatnonzero(np.abs(values) < _NEAR_ZERO * unit)
    if not near.size:
        return rigid, vectors[:, :0]
    # at rest: gyroscopic moments of a rigid motion would bend the structure
    solve = solver_of((_SHIFT * unit) ** 2 * pencil.M + pencil.K)
    parts = np.stack([vectors[:, near].real, vectors[:, near].imag])
    seen = np.linalg.norm(parts, axis=1) > _SAME_DIRECTION
    shapes = np.array([solve(np.ascontiguousarray(pencil.M @ part)) for part in parts])
    forces = np.array([abs(pencil.K @ each).max(axis=0) for each in shapes])
    sizes = np.array([(abs(pencil.K) @ abs(each)).max(axis=0) for each in shapes])
    rigid[near] = ((forces <= _NO_FORCE * sizes) | ~seen).all(axis=0)
    if not rigid.any():
        return rigid, vectors[:, :0]
    both = np.concatenate([vectors[:, rigid].real, vectors[:, rigid].imag], axis=1)
    basis, lengths, _ = np.linalg.svd(both, full_matrices=False)
    return rigid, basis[:, lengths > _SAME_DIRECTION * lengths[0]]


def _by_decomposition(pencil: Pencil) -> Eigenpairs:
    from scipy.linalg import eig

    m, c, k = dense(pencil.M), dense(pencil.C), dense(pencil.K)
    size = len(m)
    # time in units of a typical period: displacements and velocities of one size
    unit = _frequency(pencil)
    lower = np.linalg.solve(m, np.hstack([k / unit**2, c / unit]))
    block = np.block([[np.zeros((size, size)), np.eye(size)], [-lower]])
    values, vectors = eig(block)
    return _sorted(values * unit, vectors[:size], pencil)


def _frequency(pencil: Pencil) -> float:
    """A frequency of the structure's own size."""
    ratio = pencil.K.diagonal() / pencil.M.diagonal()
    held = ratio[ratio > 0.0]
    return float(np.sqrt(held.min())) if held.size else 1.0


def _by_arnoldi(pencil: Pencil, wanted: int) -> Eigenpairs:
    from scipy.sparse.linalg import ArpackNoConvergence, eigs

    inverse, unit, shift = _inverse(pencil)
    size = pencil.structure.size
    number = 2 * wanted + _GUARD
    start = np.random.default_rng(0).normal(size=2 * size)  # the same in every run
    while 4 * number < 2 * size:
        try:
            ritz, spaces = eigs(inverse, number, v0=start, ncv=3 * number, tol=0)
        except ArpackNoConvergence as error:
            raise RunError(
                f"only {len(error.eigenvalues)} of {number} eigenvalues were found; ask for fewer"
            ) from None
        passed_over = _left_over(inverse, spaces, start)
        found = _sorted((1.0 / ritz + shift) * unit, spaces[:size], pencil)
        complete = np.abs(ritz).min() * (1.0 + _CLOSE) >= passed_over
        if complete and len(found.values) >= wanted:
            return found
        if not complete:  # begin nearer to what was passed over
            start = np.random.default_rng(number).normal(size=2 * size)
        number += number // 2
    if size > _LARGEST_DENSE:
        raise RunError(f"{wanted} modes could not be told from others beside them; ask for fewer")
    return _by_decomposition(pencil)


def _inverse(pencil: Pencil) -> tuple[Any, float, float]:
    """(A - shift)^-1 of the first-order form, whose unit of time is also returned."""
    from scipy.sparse.linalg import LinearOperator

    unit, shift = _frequency(pencil), _SHIFT
    size = pencil.structure.size
    m, c = pencil.M, pencil.C / unit
    stiff = pencil.K / unit**2
    solve = solver_of(shift**2 * m + shift * c + stiff)

    def apply(both: Array) -> Array:
        a, b = both[:size], both[size:]
        displacement = -solve(m @ b + c @ a + shift * (m @ a))
        return np.concatenate([displacement, a + shift * displacement])

    return LinearOperator((2 * size, 2 * size), matvec=apply, dtype=float), unit, shift


def _left_over(inverse: Any, spaces: Array, start: Array) -> float:
    """Size of the largest eigenvalue of the inverse beside a space that it maps into itself."""
    from scipy.sparse.linalg import LinearOperator, eigs

    real, sizes, _ = np.linalg.svd(np.hstack([spaces.real, spaces.imag]), full_matrices=False)
    basis = real[:, sizes > _CLOSE**2 * sizes[0]]

    def beside(vector: Array) -> Array:
        kept = vector - basis @ (basis.T @ vector)
        image = inverse @ kept
        return image - basis @ (basis.T @ image)

    operator = LinearOperator(inverse.shape, matvec=beside, dtype=float)
    largest = eigs(operator, 2, v0=start, tol=1e-3, return_eigenvectors=False)
    return float(np.abs(largest).max())


def refined(pencil: Pencil, value: complex, vector: Array) -> tuple[complex, Array]:
    """Eigenpair near a guess, by Newton's method.

    Equations: P(value) vector = 0, and the part of the vector along the guess stays one.
    """
    along = vector.conj() / np.linalg.norm(vector) ** 2
    last = np.inf
    for _ in range(_MOST_STEPS):
        try:
            solve = solver_of(_complex(pencil.at(value)))
        except np.linalg.LinAlgError:  # an eigenvalue to the last digit
            break
        towards = solve(pencil.slope(value) @ vector)
        if not np.isfinite(towards).all() or not np.any(towards):
            break
        step = (along @ vector) / (along @ towards)
        vector = towards * step
        value = value - step
        # where steps no longer get smaller, they are rounding
        if abs(step) <= _ROUNDING * abs(value) or last <= min(abs(step), _CLOSE * abs(value)):
            break
        last = abs(step)
    vector = vector / np.linalg.norm(vector)
    return complex(_balanced(pencil, np.array([value], complex), vector[:, None])[0]), vector


def _complex(matrix: Any) -> Any:
    return matrix.astype(complex) if is_sparse(matrix) else np.asarray(matrix, dtype=complex)
