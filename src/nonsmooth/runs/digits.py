"""Digits that a run still has where errors of rounding grow, told by its derivatives."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["digits_left"]

Floats = npt.NDArray[np.float64]

_EPSILON = float(np.finfo(float).eps)


def digits_left(states: Floats, tangent: Floats) -> Floats:
    """Estimate of the correct digits of the states, beside their largest size, at each sample.

    An error of one rounding, made at any sample, has grown since by as much as the derivatives
    have; the largest of them counts, in the state that has it. Where derivatives are lost, or
    beyond the range of numbers, no digit is left.

    shapes: states (n, K), tangent (K, n, n); returns (K,)
    """
    size = np.abs(states).max(axis=1, initial=0.0)
    unit = np.where(size > 0.0, size, 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        growth = ((np.abs(tangent) @ size) / unit).max(axis=1, initial=0.0)
    growth = np.where(np.isfinite(growth), growth, np.inf)
    least = np.minimum.accumulate(growth)  # an error made there has grown most since
    since = np.divide(growth, least, out=np.ones_like(growth), where=least > 0.0)
    digits: Floats = np.maximum(-np.log10(_EPSILON * since), 0.0)
    return digits
