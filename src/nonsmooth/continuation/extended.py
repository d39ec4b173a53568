"""Residual and one scalar as one residual, whose unknowns are those of the residual and p."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.equations import (
    RELATIVE_STEP,
    Equations,
    call,
    difference_within,
    has_derivatives,
)
from nonsmooth.continuation.refusals import OutsideDomain
from nonsmooth.errors import OptionError

__all__ = ["Extended", "Residual2", "Scalar"]

Residual2 = Callable[[Array, float, float], Any]
Scalar = Callable[[Array, float, float], Any]
_UNBOUNDED = (-math.inf, math.inf)


class Extended:
    """``(r, g)`` of ``((u, p), q)``, with derivatives where the residual has them.

    ``sizes`` are those of u, p and q, ``bounds`` those of q; ``at(q)`` gives the equations in u
    and p.
    """

    def __init__(
        self, residual: Residual2, scalar: Scalar, at: Callable[[float], Equations], sizes: Array,
        bounds: tuple[float, float],
    ) -> None:  # fmt: skip
        self.residual, self.scalar, self.at = residual, scalar, at
        self.sizes, self.bounds = sizes, bounds

    def __call__(self, x: Array, q: float) -> Any:
        """``(r, g)``, with derivatives by (u, p) and by q where one of both has some."""
        u, p = x[:-1], float(x[-1])
        found = self.residual(u, p, q)
        g = self.scalar(u, p, q)
        if not has_derivatives(found, u.size, (3, 4)):
            if not isinstance(g, tuple):
                return np.append(np.ravel(found), g)
            # a difference of g, which may be one itself, would lose what its gradient is good to
            found = self.at(q).linearised(u, p)
        r, J_u, J_p, *rest = found
        J_q = rest[0] if rest else self._of_q(u, p, q, np.ravel(r))
        value, gradient = self._gradient(g, u, p, q)
        above = np.column_stack([_dense(J_u), np.ravel(J_p)])
        matrix = np.vstack([above, gradient[:-1]])
        return np.append(np.ravel(r), value), matrix, np.append(np.ravel(J_q), gradient[-1])

    def _gradient(self, g: Any, u: Array, p: float, q: float) -> tuple[float, Array]:
        """The scalar and its derivatives by u, p and q."""
        if isinstance(g, tuple):
            if len(g) != 4:
                raise OptionError(
                    f"the test returned {len(g)} values; it returns one number, or (g, g_u, g_p,"
                    " g_q) with its derivatives"
                )
            parts = [np.ravel(np.asarray(part, dtype=float)) for part in g]
            return float(parts[0][0]), np.concatenate(parts[1:])
        value = float(g)
        if not math.isfinite(value):
            raise OutsideDomain("the test is not finite")
        z = np.concatenate([u, [p, q]])
        gradient = np.empty(z.size)
        for i in range(z.size):

            def along(to: float, i: int = i) -> float:
                moved = z.copy()
                moved[i] = to
                there = call(self.scalar, moved[:-2], float(moved[-2]), float(moved[-1]))
                if not math.isfinite(there):
                    raise OutsideDomain("the test is not finite")
                return float(there)

            gradient[i] = self._difference(along, float(z[i]), i, value)
        return value, gradient

    def _of_q(self, u: Array, p: float, q: float, r: Array) -> Array:
        """Derivative of the residual by q, which it did not give."""
        found: Array = self._difference(lambda to: self.at(to).value(u, p), q, u.size + 1, r)
        return found

    def _difference(self, value: Callable[[float], Any], at: float, place: int, here: Any) -> Any:
        step = RELATIVE_STEP * max(abs(at), float(self.sizes[place]))
        last = place == self.sizes.size - 1
        return difference_within(value, here, at, step, self.bounds if last else _UNBOUNDED)


def _dense(matrix: Any) -> Array:
    if sparse.issparse(matrix):
        matrix = matrix.toarray()
    return np.atleast_2d(np.asarray(matrix, dtype=float))
