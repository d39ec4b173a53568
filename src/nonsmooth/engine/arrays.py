"""Copying and filling by plain loops.

numba's slice assignment may allocate, which kernels may not, and takes seconds to compile.
"""

from __future__ import annotations

from nonsmooth.engine.jit import kernel

__all__ = ["copy_matrix", "copy_vector", "set_identity", "set_zero"]


@kernel
def copy_vector(source, target, count):
    """target[:count] = source[:count].

    shapes: source, target (count,) or longer
    """
    for i in range(count):
        target[i] = source[i]


@kernel
def copy_matrix(source, target):
    """target[:, :] = source.

    shapes: source, target (r, c)
    """
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@kernel
def set_zero(target):
    """target[:, :] = 0.

    shapes: target (r, c)
    """
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] = 0.0


@kernel
def set_identity(target):
    """target = identity.

    shapes: target (n, n)
    """
    set_zero(target)
    for i in range(target.shape[0]):
        target[i, i] = 1.0
