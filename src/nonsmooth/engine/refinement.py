"""One Newton step on a block-diagonal form, with the residual in doubled precision.

An orthogonal similarity leaves errors of the size of a whole block in each of its
eigenvalues. Where a fast relaxation and a slow motion share a block, the slow one would
lose the digits between them: a rate of 30,000 beside a rate of one costs five. The
residual A V - V T, summed in twice the working precision, tells these errors exactly.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.doubled import add_product
from nonsmooth.engine.jit import allocating, kernel

__all__ = ["refine", "worth_refining"]

_SMALL = 1e-3  # a first-order step must be small, which it is not between equal eigenvalues
_WORTH = 100.0  # radians of error, in units of rounding, that a motion may carry unrefined


@kernel
def worth_refining(t, block, norm, horizon):
    """Whether an eigenvalue's error acts long enough to be felt.

    shapes: t (N, N) block-diagonal, block and norm (N,) as from triangular_form; blocks of
    up to two coordinates were solved in closed form
    """
    for j in range(block.size):
        members = 0
        for i in range(block.size):
            members += block[i] == block[j]
        acting = horizon
        if t[j, j].real < 0.0:
            acting = min(horizon, -1.0 / t[j, j].real)
        if members > 2 and norm[j] * acting > _WORTH:
            return True
    return False


@allocating
def refine(matrix, t, v, v_inverse, label):
    """Correct t, v and v_inverse in place so that matrix v = v t to more digits.

    shapes: matrix (N, N) real; t, v, v_inverse (N, N) complex as from decouple; label (N,)
    """
    n = matrix.shape[0]
    residual = np.zeros((n, n), np.complex128)
    error = np.zeros((n, n), np.complex128)
    x = np.zeros((n, n), np.complex128)
    _fill_residual(matrix, t, v, residual)
    for i in range(n):
        for j in range(n):
            for k in range(n):
                error[i, j] += v_inverse[i, k] * residual[k, j]
    for j in range(n):
        for i in range(n - 1, -1, -1):
            if label[i] == label[j]:
                continue
            total = error[i, j]
            for k in range(i + 1, n):
                if label[k] == label[i]:
                    total += t[i, k] * x[k, j]
            for k in range(j):
                if label[k] == label[j]:
                    total -= x[i, k] * t[k, j]
            gap = t[j, j] - t[i, i]
            if total != 0.0 and abs(total) <= _SMALL * abs(gap):
                x[i, j] = total / gap
    for i in range(n):
        for j in range(n):
            if label[i] == label[j]:
                t[i, j] += error[i, j]
    _apply(x, v, v_inverse, residual, error)


@kernel
def _fill_residual(matrix, t, v, residual):
    """residual := matrix v - v t, each entry summed in doubled precision."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(n):
            re, re_low, im, im_low = 0.0, 0.0, 0.0, 0.0
            for k in range(n):
                a = matrix[i, k]
                if a != 0.0:
                    re, re_low = add_product(re, re_low, a, v[k, j].real)
                    im, im_low = add_product(im, im_low, a, v[k, j].imag)
                b, c = v[i, k], t[k, j]
                if c != 0.0:
                    re, re_low = add_product(re, re_low, -b.real, c.real)
                    re, re_low = add_product(re, re_low, b.imag, c.imag)
                    im, im_low = add_product(im, im_low, -b.real, c.imag)
                    im, im_low = add_product(im, im_low, -b.imag, c.real)
            residual[i, j] = complex(re + re_low, im + im_low)


@kernel
def _apply(x, v, v_inverse, change, change_inverse):
    """v := v (1 + x), v_inverse := (1 - x) v_inverse; the changes are scratch."""
    n = x.shape[0]
    for i in range(n):
        for j in range(n):
            forward, backward = complex(0.0, 0.0), complex(0.0, 0.0)
            for k in range(n):
                forward += v[i, k] * x[k, j]
                backward += x[i, k] * v_inverse[k, j]
            change[i, j], change_inverse[i, j] = forward, backward
    for i in range(n):
        for j in range(n):
            v[i, j] += change[i, j]
            v_inverse[i, j] -= change_inverse[i, j]
