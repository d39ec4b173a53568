"""Which coordinates depend on which: an order in which a matrix is block triangular.

Rigid-body motion, integrators and forcing are triangular parts of a generator. Treating
them as such keeps their eigenvalues exact: a zero stays exactly zero, which no general
eigenvalue routine would guarantee.
"""

from __future__ import annotations

from nonsmooth.engine.jit import kernel

__all__ = ["balance_block", "order_blocks"]


@kernel
def order_blocks(matrix, reach, order, starts):
    """Order the coordinates so that the matrix becomes block upper triangular.

    shapes: matrix (N, N), reach (N,) scratch, order (N,), starts (N + 1,)
    returns: number of blocks; block k holds order[starts[k]:starts[k + 1]]

    Coordinates that depend on each other, directly or not, share a block (a strongly
    connected component). A coordinate comes before those that it depends on.
    """
    n = matrix.shape[0]
    for i in range(n):
        reach[i] = 1 << i
        for j in range(n):
            if matrix[i, j] != 0.0:
                reach[i] |= 1 << j
    for k in range(n):
        for i in range(n):
            if (reach[i] >> k) & 1:
                reach[i] |= reach[k]
    for i in range(n):
        # a coordinate that reaches more comes first; equal reach means the same block or
        # unrelated ones, which the lowest member keeps apart
        key = _rank(reach, i, n)
        k = i
        while k > 0 and _rank(reach, order[k - 1], n) > key:
            order[k] = order[k - 1]
            k -= 1
        order[k] = i
    n_blocks = 0
    for k in range(n):
        if k == 0 or _lowest_member(reach, order[k], n) != _lowest_member(reach, order[k - 1], n):
            starts[n_blocks] = k
            n_blocks += 1
    starts[n_blocks] = n
    return n_blocks


@kernel
def _rank(reach, i, n):
    count = 0
    for j in range(n):
        count += (reach[i] >> j) & 1
    return (n - count) * n + _lowest_member(reach, i, n)


@kernel
def _lowest_member(reach, i, n):
    for j in range(n):
        if (reach[i] >> j) & 1 and (reach[j] >> i) & 1:
            return j
    return i


@kernel
def balance_block(t, scale, low, high):
    """Scale the coordinates of a block by powers of two so that rows and columns match.

    shapes: t (N, N) complex, changed in place to diag(scale)^-1 t diag(scale); scale (N,)

    Parlett and Reinsch (1969). Units such as newtons beside metres would otherwise spoil
    the small entries of a block; powers of two make the scaling itself exact.
    """
    n = t.shape[0]
    for _ in range(20):
        changed = False
        for i in range(low, high):
            column = 0.0
            row = 0.0
            for j in range(low, high):
                if j != i:
                    column += abs(t[j, i])
                    row += abs(t[i, j])
            if column == 0.0 or row == 0.0:
                continue
            factor = 1.0
            total = column + row
            while column * factor < 0.5 * row / factor and factor < 1e100:
                factor *= 2.0
            while column * factor > 2.0 * row / factor and factor > 1e-100:
                factor *= 0.5
            if column * factor + row / factor < 0.95 * total:
                changed = True
                scale[i] *= factor
                for j in range(n):
                    t[j, i] *= factor
                for j in range(n):
                    t[i, j] /= factor
        if not changed:
            return
