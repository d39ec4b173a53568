"""Which entry of a vector decides its sign: the largest, and the first of several that are equal.

A direction and its opposite are the same direction, so libraries of linear algebra return either.
Of entries that a symmetry makes equally large, rounding says which is the largest.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["leading_entry"]

ROUNDING = 1e-9  # of the largest entry of an eigenvector


def leading_entry(
    vectors: npt.NDArray[np.inexact[Any]], within: float = ROUNDING
) -> npt.NDArray[np.intp]:
    """Place of the first entry that is as large as the largest, but for so much of it.

    Of vectors as columns, the place in each.
    """
    size = np.abs(vectors)
    return np.asarray(np.argmax(size >= (1.0 - within) * size.max(axis=0), axis=0))
