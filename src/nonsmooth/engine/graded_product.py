"""The product of many matrices with its small eigenvalues beside the large ones.

With B_k Q_k = Q_(k+1) R_k for each factor, R_k triangular, a product is Q_L R_(L-1) ... R_0 Q_0^T.
Triangular matrices multiply without cancellation on the diagonal, and after some turns through the
same factors the frame Q has found the directions in order of growth (the idea of the periodic Schur
form: A. Bojanczyk, G. Golub and P. Van Dooren, The periodic Schur decomposition, 1992).
"""

from __future__ import annotations

import math

from nonsmooth.engine.arrays import copy_matrix
from nonsmooth.engine.jit import entry, kernel

__all__ = ["multiply_graded"]

_TWICE = 2  # passes of the Gram-Schmidt process, after which nothing is left to orthogonalise


@entry
def multiply_graded(factors, turns, frame, start, triangle, spare):
    """Turn a frame through factors, and multiply what it leaves over the last turn.

    shapes: factors (L, n, n), the first one applied first; frame (n, k) orthonormal columns at the
    start, and those at the end; start (n, k) the frame before the last turn, triangle (k, k), both
    outputs, with factors @ start = frame @ triangle * exp(exponent); spare (n, k)
    returns: exponent, nan where the product vanishes or overflows
    """
    n, size = frame.shape
    exponent = 0.0
    for _ in range(turns):
        copy_matrix(frame, start)
        exponent = 0.0
        for i in range(size):
            for j in range(size):
                triangle[i, j] = 1.0 if i == j else 0.0
        for k in range(factors.shape[0]):
            for i in range(n):
                for j in range(size):
                    total = 0.0
                    for c in range(n):
                        total += factors[k, i, c] * frame[c, j]
                    spare[i, j] = total
            _orthogonalise(spare, frame, triangle)
            largest = 0.0
            for i in range(size):
                for j in range(size):
                    largest = max(largest, abs(triangle[i, j]))
            if not (largest > 0.0 and math.isfinite(largest)):
                return math.nan
            for i in range(size):
                for j in range(size):
                    triangle[i, j] /= largest
            exponent += math.log(largest)
    return exponent


@kernel
def _orthogonalise(columns, frame, triangle):
    """Make columns = frame R with an orthonormal frame, and triangle = R triangle.

    A column that depends on those before it leaves a zero column of the frame. The rows of R act
    from above, row i reading only rows from i on, so triangle is multiplied in place.
    """
    n, size = columns.shape
    for j in range(size):
        for i in range(n):
            frame[i, j] = columns[i, j]
        before = _norm(frame, j)
        for _ in range(_TWICE):
            for i in range(j):
                share = 0.0
                for c in range(n):
                    share += frame[c, i] * frame[c, j]
                for c in range(n):
                    frame[c, j] -= share * frame[c, i]
        after = _norm(frame, j)
        vanishes = not after > 1e-15 * before
        for c in range(n):
            frame[c, j] = 0.0 if vanishes else frame[c, j] / after
    for i in range(size):
        for j in range(i, size):
            total = 0.0
            for k in range(i, size):
                entry_of_r = 0.0
                for c in range(n):
                    entry_of_r += frame[c, i] * columns[c, k]
                total += entry_of_r * triangle[k, j]
            triangle[i, j] = total


@kernel
def _norm(matrix, j):
    total = 0.0
    for i in range(matrix.shape[0]):
        total += matrix[i, j] * matrix[i, j]
    return math.sqrt(total)
