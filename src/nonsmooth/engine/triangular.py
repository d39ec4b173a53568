"""Similarity of a generator to triangular form, block by block.

Blocks of coordinates that depend on each other are balanced and brought to Schur form;
couplings between blocks follow. Exact zeros stay exact: rigid-body motion and forcing keep
their eigenvalues to the last bit.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.blocks import balance_block, order_blocks
from nonsmooth.engine.jit import allocating
from nonsmooth.engine.schur import schur_block
from nonsmooth.engine.status import Status

__all__ = ["triangular_form"]

_OK = int(Status.COMPLETED)


@allocating
def triangular_form(matrix, t, v, v_inverse, block, norm):
    """Similarity of a real matrix to upper triangular form, exact zeros kept.

    shapes: matrix, t, v, v_inverse (N, N), the last three complex outputs with
    matrix = v t v_inverse; block (N,) number of the block to which each coordinate belongs,
    norm (N,) its largest entry
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
    for k in range(n_blocks):
        low, high = starts[k], starts[k + 1]
        balance_block(t, scale, low, high)
        largest = 0.0
        for i in range(low, high):
            for j in range(low, high):
                largest = max(largest, abs(t[i, j]))
        for i in range(low, high):
            block[i], norm[i] = k, largest
    for k in range(n_blocks):
        status = schur_block(t, q, starts[k], starts[k + 1])
        if status != _OK:
            return status
    for i in range(n):
        for j in range(n):
            v[order[i], j] = scale[i] * q[i, j]
            v_inverse[j, order[i]] = q[i, j].conjugate() / scale[i]
    return _OK
