"""Sums of products in twice the working precision (Dekker 1971, Knuth 1969).

A product of two numbers is split into its rounded value and the exact rest; a sum carries
its rounding errors beside it. Contraction, which the kernels allow, leaves these exact.
"""

from __future__ import annotations

from nonsmooth.engine.jit import kernel

__all__ = ["add_product", "product_error", "sum_error"]

_SPLITTER = 134217729.0  # 2^27 + 1


@kernel
def add_product(high, low, a, b):
    """High and low part of high + low + a b."""
    p = a * b
    total = high + p
    return total, low + (sum_error(high, p, total) + product_error(a, b, p))


@kernel
def sum_error(a, b, total):
    """What a + b exceeds its rounded value by, exactly."""
    virtual = total - a
    return (a - (total - virtual)) + (b - virtual)


@kernel
def product_error(a, b, product):
    """What a b exceeds its rounded value by, exactly."""
    a_high, b_high = _leading_half(a), _leading_half(b)
    a_low, b_low = a - a_high, b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@kernel
def _leading_half(x):
    scaled = _SPLITTER * x
    return scaled - (scaled - x)
