"""Copying without slices: numba's slice assignment may allocate, kernels may not."""

from __future__ import annotations

from nonsmooth.engine.jit import kernel

__all__ = ["copy_vector"]


@kernel
def copy_vector(source, target, count):
    """target[:count] = source[:count].

    shapes: source, target (count,) or longer
    """
    for i in range(count):
        target[i] = source[i]
