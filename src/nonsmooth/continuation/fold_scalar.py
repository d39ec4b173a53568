"""A number that is zero at folds: the last unknown of the bordered J_u.

After Griewank and Reddien, SIAM Journal on Numerical Analysis 21, 176-185 (1984): with
[J_u b; c 0] (v, g) = (0, 1) the number g is zero where J_u is singular, and regular there.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.equations import Equations, difference_within
from nonsmooth.continuation.refusals import SingularMatrix

__all__ = ["FoldScalar"]

_STEP = 1e-5  # differences of derivatives
_STEP_OF_DIFFERENCES = 1e-4  # the same where these are differences themselves
_TILTED = 0.5  # cosine between border and null vector below which the border is taken anew


class FoldScalar:
    """The number and its gradient.

    ``at(q)`` gives the equations in u and p at a value of q, which is never beyond its bounds.
    """

    def __init__(self, at: Callable[[float], Equations], bounds: tuple[float, float]) -> None:
        self.at, self.bounds = at, bounds
        self.b: Array | None = None
        self.c: Array | None = None

    def __call__(self, u: Array, p: float, q: float) -> tuple[float, Array, float, float]:
        """``(g, g_u, g_p, g_q)``."""
        equations = self.at(q)
        J_u = equations.linearised(u, p).J_u
        J_u = J_u if isinstance(J_u, np.ndarray) else J_u.toarray()
        g, v, w = self._null_vectors(J_u)
        step = _STEP_OF_DIFFERENCES if equations.by_differences else _STEP
        step *= (1.0 + float(np.abs(u).max())) / float(np.abs(v).max())
        above, below = (equations.linearised(u + s * step * v, p) for s in (1.0, -1.0))
        # J_u v changes with u, p as [J_u J_p] does along v
        g_u = -(w @ (above.J_u - below.J_u)) / (2.0 * step)
        g_p = -float(w @ (above.J_p - below.J_p)) / (2.0 * step)
        by_q = step * max(1.0, abs(q))
        change = difference_within(
            lambda to: self.at(to).linearised(u, p).J_u @ v, J_u @ v, q, by_q, self.bounds
        )
        return g, np.ravel(g_u), g_p, -float(w @ change)

    def _null_vectors(self, J_u: Array) -> tuple[float, Array, Array]:
        if self.b is None or self.c is None:
            left, _, right = np.linalg.svd(J_u)
            self.b, self.c = left[:, -1], right[-1]
        n = J_u.shape[0]
        matrix, last = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
        matrix[:n, :n], matrix[:n, n], matrix[n, :n], last[n] = J_u, self.b, self.c, 1.0
        try:
            right, left = np.linalg.solve(matrix, last), np.linalg.solve(matrix.T, last)
        except np.linalg.LinAlgError:
            raise SingularMatrix("two eigenvalues of J_u vanish") from None
        g, v, w = float(right[n]), right[:n], left[:n]
        sizes = math.sqrt(float(v @ v)), math.sqrt(float(w @ w))
        if min(1.0 / sizes[0], 1.0 / sizes[1]) < _TILTED:  # c v = 1 and b w = 1
            self.c, self.b = v / sizes[0], w / sizes[1]
        return g, v, w
