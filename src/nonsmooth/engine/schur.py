"""Complex Schur form of a block-triangular matrix, block by block.

Only what small dense blocks need: closed form for two by two, shifted QR with Givens
rotations beyond. Every rotation is applied to the whole matrix, so that couplings
between blocks follow.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.doubled import product_error, sum_error
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.status import Status

__all__ = ["schur_block"]

_UNIT = 2.220446049250313e-16
_MOST_SWEEPS = 60  # per eigenvalue; ten are unusual
_OK = int(Status.COMPLETED)
_NOT_CONVERGED = int(Status.NOT_CONVERGED)


@kernel
def schur_block(t, q, low, high):
    """Make t[low:high, low:high] upper triangular by a unitary similarity.

    shapes: t, q (N, N) complex; q collects the similarity, t_old = q t_new q^H
    status: COMPLETED or NOT_CONVERGED
    """
    if high - low == 2:
        _triangular_pair(t, q, low)
        return _OK
    if high - low > 2:
        _hessenberg(t, q, low, high)
        return _iterate(t, q, low, high)
    return _OK


@kernel
def _triangular_pair(t, q, k):
    """Two by two in closed form; exact zeros and exact critical damping stay exact."""
    a, b, c, d = t[k, k].real, t[k, k + 1].real, t[k + 1, k].real, t[k + 1, k + 1].real
    half = 0.5 * (a - d)
    mean = 0.5 * (a + d)
    # close to critical damping even the rounding of the difference counts
    rest = 0.5 * sum_error(a, -d, a - d)
    discriminant = _sum_of_products(half, half, b, c) + 2.0 * half * rest
    if discriminant >= 0.0:
        root = np.sqrt(discriminant)
        first = complex(mean + root if mean >= 0.0 else mean - root, 0.0)
        # the smaller one from the determinant: the difference would lose its digits
        second = complex(2.0 * mean, 0.0) - first
        if first.real != 0.0:
            second = complex(_sum_of_products(a, d, -b, c) / first.real, 0.0)
    else:
        root = np.sqrt(-discriminant)
        first = complex(mean, root)
        second = complex(mean, -root)
    v1, v2 = complex(b, 0.0), first - a
    u1, u2 = first - d, complex(c, 0.0)
    if abs(u1) + abs(u2) > abs(v1) + abs(v2):
        v1, v2 = u1, u2
    length = np.sqrt(abs(v1) ** 2 + abs(v2) ** 2)
    if length == 0.0:
        return
    # columns (v, w) with w orthogonal to v; written as a Givens rotation of the columns
    v1, v2 = v1 / length, v2 / length
    _rotate_both(t, q, k, v1, v2)
    t[k + 1, k] = 0.0
    t[k, k] = first
    t[k + 1, k + 1] = second


@kernel
def _sum_of_products(a, b, c, d):
    """a b + c d with the rounding errors of the products added back (Dekker 1971).

    Two nearly equal products cancel close to critical damping, and where coordinates are
    far from the natural ones.
    """
    p, q = a * b, c * d
    return (p + q) + (product_error(a, b, p) + product_error(c, d, q))


@kernel
def _rotate_both(t, q, k, v1, v2):
    """Similarity with the unitary [[v1, -conj(v2)], [v2, conj(v1)]] in the plane (k, k+1)."""
    n = t.shape[0]
    for i in range(n):
        x, y = t[i, k], t[i, k + 1]
        t[i, k] = x * v1 + y * v2
        t[i, k + 1] = -x * v2.conjugate() + y * v1.conjugate()
        x, y = q[i, k], q[i, k + 1]
        q[i, k] = x * v1 + y * v2
        q[i, k + 1] = -x * v2.conjugate() + y * v1.conjugate()
    for j in range(n):
        x, y = t[k, j], t[k + 1, j]
        t[k, j] = v1.conjugate() * x + v2.conjugate() * y
        t[k + 1, j] = -v2 * x + v1 * y


@kernel
def _rotation(x, y):
    """First column of the unitary whose adjoint maps (x, y) to (r, 0)."""
    length = np.sqrt(abs(x) ** 2 + abs(y) ** 2)
    if length == 0.0:
        return complex(1.0, 0.0), complex(0.0, 0.0)
    return x / length, y / length


@kernel
def _hessenberg(t, q, low, high):
    for j in range(low, high - 2):
        for i in range(high - 1, j + 1, -1):
            if t[i, j] != 0.0:
                v1, v2 = _rotation(t[i - 1, j], t[i, j])
                _rotate_both(t, q, i - 1, v1, v2)
                t[i, j] = 0.0


@kernel
def _iterate(t, q, low, high):
    last = high - 1
    sweeps = 0
    while last > low:
        start = last
        while start > low:
            around = abs(t[start, start]) + abs(t[start - 1, start - 1])
            if abs(t[start, start - 1]) <= _UNIT * around:
                t[start, start - 1] = 0.0
                break
            start -= 1
        if start == last:
            last -= 1
            sweeps = 0
            continue
        sweeps += 1
        if sweeps > _MOST_SWEEPS:
            return _NOT_CONVERGED
        shift = _wilkinson(t, last)
        if sweeps % 11 == 10:
            shift = complex(abs(t[last, last - 1]) + abs(t[last, last].real), 0.0)
        _sweep(t, q, start, last, shift)
    return _OK


@kernel
def _wilkinson(t, last):
    """Eigenvalue of the trailing two by two that is nearer to its corner."""
    a, b = t[last - 1, last - 1], t[last - 1, last]
    c, d = t[last, last - 1], t[last, last]
    half = 0.5 * (a - d)
    root = np.sqrt(half * half + b * c)
    if (half.conjugate() * root).real < 0.0:
        root = -root
    below = half + root
    if abs(below) == 0.0:
        return d
    return d - b * c / below


@kernel
def _sweep(t, q, start, last, shift):
    x, y = t[start, start] - shift, t[start + 1, start]
    for k in range(start, last):
        v1, v2 = _rotation(x, y)
        _rotate_both(t, q, k, v1, v2)
        if k > start:
            t[k + 1, k - 1] = 0.0
        if k + 2 <= last:
            x, y = t[k + 1, k], t[k + 2, k]
