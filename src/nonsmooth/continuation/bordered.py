"""The bordered matrix: derivatives of the residual above one more row.

It has an inverse at folds, where J_u has none. Its last row is the direction along which a step is
measured; the tangent solves it with a right-hand side of zeros and, last, a one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dgesv
from scipy.sparse.linalg import splu

from nonsmooth.continuation.equations import Linearised
from nonsmooth.continuation.point import Array, SingularMatrix

__all__ = ["Determinant", "Solved", "solve_bordered"]

_SMALL = 2.0**-13  # a power of two changes no digit
_LOG_SMALL = math.log(_SMALL)


class Determinant(NamedTuple):
    """Sign and logarithm of a determinant."""

    sign: float
    log: float


class Solved(NamedTuple):
    """Newton step and unit tangent in scaled unknowns; determinant with the tangent as last row."""

    step: Array
    tangent: Array
    determinant: Determinant


def solve_bordered(at: Linearised, border: Array, scale: Array) -> Solved:
    """Newton step across ``border``, and the tangent along it."""
    n = at.r.size
    if sparse.issparse(at.J_u):
        solution, (sign, log) = _sparse(at, border, scale)
    else:
        solution, (sign, log) = _dense(at, border, scale)
    length = math.sqrt(float(solution[:, 1] @ solution[:, 1]))
    if not math.isfinite(length) or not np.isfinite(solution[n, 0]):
        raise SingularMatrix("the bordered matrix is singular")
    tangent = solution[:, 1] / length
    # det [J; border] = (border . tangent) det [J; tangent], and border . tangent = 1/length
    return Solved(solution[:, 0], tangent, Determinant(sign, log + math.log(length)))


def _right_sides(at: Linearised, rows: Array) -> Array:
    n = at.r.size
    sides = np.zeros((n + 1, 2), order="F")
    sides[:n, 0] = at.r / rows
    sides[n, 1] = 1.0
    return sides


def _row_sizes(sizes: Array) -> Array:
    """Largest entry of each row, by which it is divided: equations may have any units."""
    if not sizes.all():
        raise SingularMatrix("an equation depends on no unknown")
    return sizes


def _dense(at: Linearised, border: Array, scale: Array) -> tuple[Array, tuple[float, float]]:
    n = at.r.size
    matrix = np.empty((n + 1, n + 1), order="F")
    np.multiply(at.J_u, scale[:n], out=matrix[:n, :n])
    np.multiply(at.J_p, scale[n], out=matrix[:n, n])
    rows = _row_sizes(np.abs(matrix[:n]).max(axis=1))
    matrix[:n] /= rows[:, None]
    matrix[n] = border
    factors, pivots, solution, fault = dgesv(
        matrix, _right_sides(at, rows), overwrite_a=1, overwrite_b=1
    )
    if fault:
        raise SingularMatrix("the bordered matrix is singular")
    diagonal = factors.diagonal()
    swaps = np.count_nonzero(pivots != np.arange(n + 1)) + np.count_nonzero(diagonal < 0.0)
    return solution, ((-1.0) ** swaps, _log_of(diagonal, rows))


def _sparse(at: Linearised, border: Array, scale: Array) -> tuple[Array, tuple[float, float]]:
    n = at.r.size
    J_u = sparse.csc_array(at.J_u)
    counts = np.diff(J_u.indptr)
    above = J_u.data * np.repeat(scale[:n], counts)
    beside = at.J_p * scale[n]
    rows = np.abs(beside)
    np.maximum.at(rows, J_u.indices, np.abs(above))
    _row_sizes(rows)
    # Each column gets one entry more, and the parameter's column is full. The last row is full
    # too: it is made small so that it is not taken as a pivot early, which would fill the rest.
    ends = J_u.indptr[1:].astype(np.intp)
    data = np.concatenate(
        [
            np.insert(above / rows[J_u.indices], ends, _SMALL * border[:n]),
            beside / rows,
            [_SMALL * border[n]],
        ]
    )
    indices = np.concatenate([np.insert(J_u.indices, ends, n), np.arange(n + 1)])
    starts = np.append(J_u.indptr + np.arange(n + 1), data.size)
    matrix = sparse.csc_array((data, indices, starts), shape=(n + 1, n + 1))
    try:
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A")
    except RuntimeError as error:  # "Factor is exactly singular"
        raise SingularMatrix(str(error)) from None
    diagonal = factors.U.diagonal()
    if not diagonal.all():
        raise SingularMatrix("the bordered matrix is singular")
    odd = _odd(factors.perm_r) ^ _odd(factors.perm_c) ^ bool(np.count_nonzero(diagonal < 0) % 2)
    sides = _right_sides(at, rows)
    sides[n, 1] = _SMALL
    return factors.solve(sides), (-1.0 if odd else 1.0, _log_of(diagonal, rows) - _LOG_SMALL)


def _log_of(diagonal: Array, rows: Array) -> float:
    """Logarithm of the determinant; rows count, for where branches cross one of them may vanish."""
    return float(np.log(np.abs(diagonal)).sum() + np.log(rows).sum())


def _odd(permutation: Array) -> bool:
    """Whether a permutation is odd: one swap less than numbers in each of its rings."""
    following, swaps = permutation.tolist(), 0
    for start in range(len(following)):
        while following[start] != start:
            there = following[start]
            following[start], following[there] = following[there], there
            swaps += 1
    return swaps % 2 == 1
