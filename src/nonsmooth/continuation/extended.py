"""The equations of a curve over two parameters: those of its points, and one number more."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from nonsmooth.continuation.equations import (
    RELATIVE_STEP,
    Equations,
    call,
    difference_within,
    has_derivatives,
)
from nonsmooth.continuation.point import Array, OutsideDomain, SingularMatrix
from nonsmooth.errors import OptionError

__all__ = ["Extended", "Held", "Residual", "Scalar", "extended", "point_of_curve"]

Scalar = Callable[[Array, float, float], Any]
Residual = Callable[[Array, float, float], Any]

_UNBOUNDED = (-math.inf, math.inf)
_STEP = 1e-5  # differences of derivatives
_STEP_OF_DIFFERENCES = 1e-4  # the same where these are differences themselves
_TILTED = 0.5  # cosine between border and null vector below which the border is taken anew
_NEWTON = 20
_SETTLED = 1e-9  # scaled step: a test whose derivatives are differences allows no less


class Extended:
    """``(r, g)`` of ``((u, p), q)``, with derivatives where the residual has them.

    ``sizes`` are those of u, p and q, ``bounds`` those of q; ``at(q)`` gives the equations in u
    and p.
    """

    def __init__(
        self, residual: Residual, scalar: Scalar, at: Callable[[float], Equations], sizes: Array,
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


class _SingularScalar:
    """A number that is zero where J_u plus a constant matrix is singular, and its gradient.

    It is the last unknown of a bordered system, after Griewank and Reddien, SIAM Journal on
    Numerical Analysis 21, 176-185 (1984): with A = J_u + ``added`` and [A b; c 0] (v, g) = (0, 1)
    the number g is zero where A is singular, and regular there.

    ``at(q)`` gives the equations in u and p at a value of q, which is never beyond its bounds.
    """

    def __init__(
        self,
        at: Callable[[float], Equations],
        bounds: tuple[float, float],
        added: Array | None = None,
    ) -> None:
        self.at, self.bounds, self.added = at, bounds, added
        self.b: Array | None = None
        self.c: Array | None = None

    def __call__(self, u: Array, p: float, q: float) -> tuple[float, Array, float, float]:
        """``(g, g_u, g_p, g_q)``."""
        equations = self.at(q)
        J_u = equations.linearised(u, p).J_u
        J_u = J_u if isinstance(J_u, np.ndarray) else J_u.toarray()
        g, v, w = self._null_vectors(J_u if self.added is None else J_u + self.added)
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

    def _null_vectors(self, A: Array) -> tuple[float, Array, Array]:
        if self.b is None or self.c is None:
            left, _, right = np.linalg.svd(A)
            self.b, self.c = left[:, -1], right[-1]
        n = A.shape[0]
        matrix, last = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
        matrix[:n, :n], matrix[:n, n], matrix[n, :n], last[n] = A, self.b, self.c, 1.0
        try:
            right, left = np.linalg.solve(matrix, last), np.linalg.solve(matrix.T, last)
        except np.linalg.LinAlgError:
            raise SingularMatrix("two eigenvalues vanish") from None
        g, v, w = float(right[n]), right[:n], left[:n]
        sizes = math.sqrt(float(v @ v)), math.sqrt(float(w @ w))
        if min(1.0 / sizes[0], 1.0 / sizes[1]) < _TILTED:  # c v = 1 and b w = 1
            self.c, self.b = v / sizes[0], w / sizes[1]
        return g, v, w


def extended(
    residual: Residual, test: Scalar | str | Array, sizes: Array, bounds: tuple[float, float]
) -> Extended:
    """Residual and test together; ``sizes`` are those of u, p and q, ``bounds`` those of q."""

    def at(q: float) -> Equations:
        def frozen(u: Array, p: float) -> Any:
            found = residual(u, p, q)
            return found[:3] if has_derivatives(found, u.size, (4,)) else found

        return Equations(frozen, sizes[:-1])

    added = test if isinstance(test, np.ndarray) else None
    scalar = test if callable(test) else _SingularScalar(at, bounds, added)
    return Extended(residual, scalar, at, sizes, bounds)


class Held(NamedTuple):
    """A point of a curve, and the direction in which the coordinate grows that was held there."""

    u: Array
    p: float
    q: float
    direction: tuple[Array, float]  # of (u, p) and q, as `two_parameter` takes it


def point_of_curve(together: Extended, u: Array, p: float, q: float, held: Array) -> Held | None:
    """The point of a curve near a guess at which ``held`` times (u, p, q) is what it is there.

    A coordinate other than q leads past a place where q tells nothing, such as one that the curve
    touches. Newton's method solves the residual alone at first, from where the test means what it
    says, and then both; None where it does not settle.
    """
    z, sizes = np.concatenate([u, [p, q]]), together.sizes
    kept, row = float(held @ z), held * sizes
    off = float(np.abs(row).max())
    for without in (1, 0):  # rows at the end
        for _ in range(_NEWTON):
            try:
                values, matrix, of_q = together(z[:-1], float(z[-1]))
            except (OutsideDomain, SingularMatrix, ArithmeticError):
                return None
            wide = np.column_stack([matrix, of_q]) * sizes
            if not (np.all(np.isfinite(wide)) and np.all(np.isfinite(values))):
                return None
            count = len(values) - without
            rows = np.maximum(np.abs(wide[:count]).max(axis=1), 1e-300)
            above = np.vstack([wide[:count] / rows[:, None], row / off])
            right = np.append(values[:count] / rows, (float(held @ z) - kept) / off)
            step = np.linalg.lstsq(above, -right, rcond=None)[0]
            z = z + step * sizes
            if float(np.abs(step).max()) <= _SETTLED:
                break
        else:
            return None
    along = np.linalg.lstsq(above, np.append(np.zeros(count), 1.0), rcond=None)[0] * sizes
    return Held(z[:-2], float(z[-2]), float(z[-1]), (along[:-1], float(along[-1])))
