r"""The pencil :math:`P(\lambda) = \lambda^2 M + \lambda C + K` of a structure at one speed.

Matrices of finite elements are nearly empty, whether or not they come as sparse ones, and a
factorisation that knows it is a hundred times faster at 400 degrees of freedom. So the form in
which to compute is chosen here by the share of entries that are not zero.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.structures.matrices import MATRICES, dense, is_sparse
from nonsmooth.structures.structure import Structure

__all__ = ["Pencil", "computing_form", "regular_solver", "solver_of"]

Array = npt.NDArray[Any]
Solver = Callable[[Array], Array]

_FULL = 0.1  # share of entries above which a dense factorisation is faster
_SMALL = 40  # rows up to which it is so in any case
_SINGULAR = 1e-14  # reciprocal condition number, in the norm of sums of columns


def computing_form(structure: Structure) -> Structure:
    """The structure with sparse matrices where these are nearly empty, else with dense ones."""
    size = structure.size
    count = (lambda matrix: matrix.nnz) if structure.sparse else np.count_nonzero
    filled = max(count(getattr(structure, name)) for name in MATRICES)
    sparse = size > _SMALL and filled < _FULL * size**2
    if sparse == structure.sparse:
        return structure
    from scipy.sparse import csc_array

    kind = csc_array if sparse else dense
    matrices: dict[str, Any] = {name: kind(getattr(structure, name)) for name in MATRICES}
    return Structure(**matrices, coordinates=structure.coordinates, bearings=structure.bearings)


class Pencil:
    """M, C and K of a structure at one speed, bearings included."""

    def __init__(self, structure: Structure, speed: float) -> None:
        self.structure = structure
        self.M, self.C, self.K = structure.at_speed(speed)

    def at(self, value: complex) -> Any:
        """P at a value."""
        return value**2 * self.M + value * self.C + self.K

    def slope(self, value: complex) -> Any:
        """Derivative of P by its argument."""
        return 2.0 * value * self.M + self.C

    def solver(self, value: complex) -> Solver:
        """Solution of P(value) q = f as a function of f."""
        return solver_of(self.at(value))


def solver_of(matrix: Any) -> Solver:
    """Solution of a linear system by its right-hand side; a factorisation that is used again."""
    if not is_sparse(matrix):
        from scipy.linalg.lapack import get_lapack_funcs

        factorise, solve = get_lapack_funcs(("getrf", "getrs"), (matrix,))
        factors, pivots, fault = factorise(matrix)
        if fault > 0:
            raise np.linalg.LinAlgError
        return lambda right: solve(factors, pivots, right)[0]
    from scipy.sparse.linalg import splu

    try:
        factors = splu(matrix)
    except RuntimeError:  # exactly singular
        raise np.linalg.LinAlgError from None
    kind = matrix.dtype

    def solved(right: Array) -> Array:
        if np.iscomplexobj(right) and kind.kind != "c":
            return factors.solve(right.real.copy()) + 1j * factors.solve(right.imag.copy())
        return factors.solve(np.ascontiguousarray(right, dtype=kind))

    return solved


def regular_solver(matrix: Any, what: str, cure: str) -> Solver:
    """The same, of a matrix that has an inverse to working precision."""
    from scipy.sparse.linalg import LinearOperator, norm, onenormest

    size = matrix.shape[0]
    try:
        solve = solver_of(matrix)
        back = solver_of(matrix.T.tocsc() if is_sparse(matrix) else matrix.T)
    except np.linalg.LinAlgError:
        raise ModelError(f"{what} is singular: {cure}") from None
    inverse = LinearOperator(
        (size, size), dtype=float, matvec=solve, rmatvec=back, matmat=solve, rmatmat=back
    )
    one_norm = norm(matrix, 1) if is_sparse(matrix) else np.linalg.norm(matrix, 1)
    if not one_norm * onenormest(inverse) < 1.0 / _SINGULAR:
        raise ModelError(f"{what} is singular: {cure}")
    return solve
