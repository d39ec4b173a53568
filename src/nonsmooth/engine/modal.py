"""Splitting a generator into motions that do not influence each other.

From the triangular Schur form each coupling between different eigenvalues is eliminated
(Bavely and Stewart 1979). Eigenvalues too close to be told apart safely stay together in
a cluster whose motion is a polynomial times an exponential; rigid-body chains, critical
damping and resonance are such clusters.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.arrays import copy_matrix, set_identity
from nonsmooth.engine.blocks import balance_block, order_blocks
from nonsmooth.engine.jit import allocating, kernel
from nonsmooth.engine.schur import schur_block
from nonsmooth.engine.status import Status

__all__ = ["decouple", "triangular_form"]

# Eigenvalues are kept together when telling them apart would cost more than three digits.
# Eliminating across a relative gap costs about -log10(gap) digits, and once more for each
# further neighbour in a chain of couplings.
_LOST_DIGITS = 3.0
_NEIGHBOUR = 0.3
_OK = int(Status.COMPLETED)


@allocating
def triangular_form(matrix, t, v, v_inverse, norm):
    """Similarity of a real matrix to upper triangular form, exact zeros kept.

    shapes: matrix, t, v, v_inverse (N, N), the last three complex outputs with
    matrix = v t v_inverse; norm (N,) size of the block to which each coordinate belongs
    status: COMPLETED or NOT_CONVERGED
    """
    n = matrix.shape[0]
    reach = np.zeros(n, np.int64)
    order = np.zeros(n, np.int64)
    starts = np.zeros(n + 1, np.int64)
    scale = np.ones(n)
    q = np.zeros((n, n), np.complex128)
    n_blocks = order_blocks(matrix, reach, order, starts)
    for i in range(n):
        q[i, i] = 1.0
        for j in range(n):
            t[i, j] = matrix[order[i], order[j]]
    for block in range(n_blocks):
        low, high = starts[block], starts[block + 1]
        balance_block(t, scale, low, high)
        largest = 0.0
        for i in range(low, high):
            for j in range(low, high):
                largest = max(largest, abs(t[i, j]))
        for i in range(low, high):
            norm[i] = largest
    for block in range(n_blocks):
        status = schur_block(t, q, starts[block], starts[block + 1])
        if status != _OK:
            return status
    for i in range(n):
        for j in range(n):
            v[order[i], j] = scale[i] * q[i, j]
            v_inverse[j, order[i]] = q[i, j].conjugate() / scale[i]
    return _OK


@allocating
def decouple(t, v, v_inverse, label, norm, horizon):
    """Block-diagonal form: couplings between different clusters eliminated.

    shapes: t, v, v_inverse (N, N) complex, changed in place; label (N,) cluster of each
    coordinate, an output; norm (N,) as from triangular_form
    """
    n = t.shape[0]
    triangular = np.empty((n, n), np.complex128)
    copy_matrix(t, triangular)
    unit = np.zeros((n, n), np.complex128)
    unit_inverse = np.zeros((n, n), np.complex128)
    for i in range(n):
        label[i] = i
    while True:
        copy_matrix(triangular, t)
        set_identity(unit)
        set_identity(unit_inverse)
        first, second = _eliminate(t, unit, unit_inverse, label, horizon)
        if first < 0:
            break
        _merge(label, first, second)
        _merge(label, _conjugate_of(t, first, norm), _conjugate_of(t, second, norm))
    _multiply_right(v, unit)
    _multiply_left(unit_inverse, v_inverse)


@kernel
def _eliminate(t, unit, unit_inverse, label, horizon):
    """Eliminate column by column; stop at a pair that must be merged and return it."""
    n = t.shape[0]
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            if label[i] == label[j] or t[i, j] == 0.0:
                continue
            gap = t[j, j] - t[i, i]
            scale = max(abs(t[i, i]), abs(t[j, j]), 1.0 / horizon)
            if abs(gap) <= _NEIGHBOUR * scale and abs(gap) <= _close(t, i, scale) * scale:
                return i, j
            x = t[i, j] / gap
            for k in range(i):
                t[k, j] += x * t[k, i]
            for k in range(j + 1, n):
                t[i, k] -= x * t[j, k]
            t[i, j] = 0.0
            for k in range(n):
                unit[k, j] += x * unit[k, i]
                unit_inverse[i, k] -= x * unit_inverse[j, k]
    return -1, -1


@kernel
def _close(t, i, scale):
    """Relative gap below which the neighbours of an eigenvalue are kept together."""
    neighbours = -1  # it finds itself
    for k in range(t.shape[0]):
        if abs(t[k, k] - t[i, i]) <= _NEIGHBOUR * scale:
            neighbours += 1
    return 10.0 ** (-_LOST_DIGITS / max(1, neighbours))


@kernel
def _merge(label, first, second):
    keep, drop = label[first], label[second]
    for i in range(label.size):
        if label[i] == drop:
            label[i] = keep


@kernel
def _conjugate_of(t, i, norm):
    """Coordinate whose eigenvalue is the conjugate of that of i, within the same block."""
    best = i
    distance = abs(t[i, i].imag) * 2.0
    for j in range(t.shape[0]):
        if norm[j] == norm[i]:
            away = abs(t[j, j] - t[i, i].conjugate())
            if away < distance:
                best, distance = j, away
    return best


@kernel
def _multiply_right(a, b):
    """a := a b for upper triangular b with unit diagonal."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n - 1, -1, -1):
            total = a[i, j]
            for k in range(j):
                total += a[i, k] * b[k, j]
            a[i, j] = total


@kernel
def _multiply_left(a, b):
    """b := a b for upper triangular a with unit diagonal."""
    n = a.shape[0]
    for j in range(n):
        for i in range(n):
            total = b[i, j]
            for k in range(i + 1, n):
                total += a[i, k] * b[k, j]
            b[i, j] = total
