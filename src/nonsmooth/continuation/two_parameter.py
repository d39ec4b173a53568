"""`two_parameter`: curves of special points over two parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.equations import (
    RELATIVE_STEP,
    Equations,
    call,
    difference_within,
    has_derivatives,
)
from nonsmooth.continuation.options import (
    checked_bounds,
    checked_options,
    number,
    sizes_of,
    start_of,
)
from nonsmooth.continuation.point import Array, OutsideDomain, Point, SingularMatrix
from nonsmooth.continuation.start import begin
from nonsmooth.errors import OptionError

__all__ = ["two_parameter"]

_Scalar = Callable[[Array, float, float], Any]

_Residual = Callable[[Array, float, float], Any]
_UNBOUNDED = (-math.inf, math.inf)
_STEP = 1e-5  # differences of derivatives
_STEP_OF_DIFFERENCES = 1e-4  # the same where these are differences themselves
_TILTED = 0.5  # cosine between border and null vector below which the border is taken anew
# Slope of p by the arclength that counts as none where q turns: second derivatives of the residual
# are differences with a step of 1e-5, good to 1e-10. Differences of differences have a step of
# 1e-4 and are good to 1e-6. Slopes are as good, times the bend of the curve.
_TURNS = 1e-6
_TURNS_BY_DIFFERENCES = 1e-4


class _Extended:
    """``(r, g)`` of ``((u, p), q)``, with derivatives where the residual has them.

    ``sizes`` are those of u, p and q, ``bounds`` those of q; ``at(q)`` gives the equations in u
    and p.
    """

    def __init__(
        self, residual: _Residual, scalar: _Scalar, at: Callable[[float], Equations], sizes: Array,
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


class _FoldScalar:
    """A number that is zero at folds, the last unknown of the bordered J_u, and its gradient.

    After Griewank and Reddien, SIAM Journal on Numerical Analysis 21, 176-185 (1984): with
    [J_u b; c 0] (v, g) = (0, 1) the number g is zero where J_u is singular, and regular there.

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


def two_parameter(
    residual: _Residual,
    test: _Scalar | str,
    u: Any,
    p: float,
    q: float,
    *,
    direction: Any = 1,
    step: float = 0.05,
    smallest_step: float = 1e-8,
    largest_step: float = 0.2,
    bounds: tuple[float, float] = (-np.inf, np.inf),
    second_bounds: tuple[float, float] = (-np.inf, np.inf),
    steps: int = 500,
    tests: Callable[[Point], Mapping[str, float]] | None = None,
    tolerance: float = 1e-11,
    scale: Any = None,
    parameter_scale: float | None = None,
    second_scale: float | None = None,
    max_newton: int = 8,
) -> Branch:
    """Follow the places where ``residual(u, p, q) = 0`` and ``test(u, p, q) = 0`` together.

    A curve in the plane of two parameters: of folds, or of any special points that a number
    vanishes at, such as det(M + 1) where periodic orbits double, or the distance from a grazing.
    It is what `follow` does with the unknowns (u, p) over q.

    Parameters
    ----------
    residual : callable
        ``residual(u, p, q)`` returns r, or ``(r, J_u, J_p)``, or ``(r, J_u, J_p, J_q)``.
    test : callable or {"fold"}
        ``test(u, p, q)`` returns a number, or ``(g, g_u, g_p, g_q)`` with its derivatives; without
        them central differences are taken. ``"fold"``: J_u is singular.
    u, p, q : array_like, float, float
        A point near the curve, such as one with ``special == "fold"`` of a branch at this q.

    Other Parameters
    ----------------
    direction : {1, -1} or (array_like, float), optional
        Whether q grows or falls at first; or (d(u, p), dq).
    step, smallest_step, largest_step : float, optional
        As for `follow`.
    bounds, second_bounds : (float, float), optional
        Lowest and highest p and q. q is never taken beyond its bounds; p may be by a step, while
        its bound is looked for.
    steps, tests, tolerance, max_newton : optional
        As for `follow`; ``tests`` gets the points described below.
    scale, parameter_scale, second_scale : optional
        Usual sizes of u, p and q; defaults as for `follow`.

    Returns
    -------
    Branch
        Iterator of `Point`, whose ``u`` is u with p behind it, and whose ``p`` is q. The special
        point ``"fold"`` is one where q turns back, and ``"cusp"`` one where p does there too.

    Raises
    ------
    OptionError
        For bad options.
    RunError
        Where no point of the curve is found near the start.

    See Also
    --------
    follow : branches over one parameter.

    Examples
    --------
    The folds of x**3 - q x + p lie on the cusp 27 p**2 = 4 q**3.

    >>> import nonsmooth as ns
    >>> def cubic(u, p, q):
    ...     return u**3 - q * u + p, 3 * u**2 - q, 1.0, -u
    >>> folds = ns.continuation.two_parameter(
    ...     cubic, "fold", 0.6, 0.4, 1.0, direction=-1, second_bounds=(-1.0, 1.0)
    ... )
    >>> for point in folds:
    ...     if point.special:
    ...         print(point.special, round(abs(float(point.u[1])), 6), round(point.p, 6))
    cusp 0.0 0.0
    bound 0.3849 1.0
    """
    for name, function in {"residual": residual, "test": test}.items():
        if not callable(function) and function != "fold":
            raise OptionError(
                f"{name} = {function!r:.60} is no function; give {name}(u, p, q)"
                + (", or the word 'fold'" if name == "test" else "")
            )
    unknowns, first = start_of(u, p)
    second = number("q", q)
    sizes = sizes_of(unknowns, first, scale, parameter_scale, bounds)
    options = checked_options(
        second,
        step,
        smallest_step,
        largest_step,
        second_bounds,
        steps,
        tests,
        tolerance,
        max_newton,
    )
    cusps = 0.0 if callable(test) else _slope_at_cusps(residual, unknowns, first, second)
    options = replace(options, unknown_bounds=checked_bounds(first, bounds), cusps=cusps)
    at = _at(residual, sizes)
    scalar = test if callable(test) else _FoldScalar(at, options.bounds)
    sizes = np.append(sizes, sizes_of(unknowns[:1], second, None, second_scale, second_bounds)[-1])
    together = _Extended(residual, scalar, at, sizes, options.bounds)
    return begin(together, np.append(unknowns, first), second, direction, sizes, options)


def _slope_at_cusps(residual: _Residual, u: Array, p: float, q: float) -> float:
    try:
        found = call(residual, u, p, q)
    except OutsideDomain:  # which the start is refused for
        return _TURNS
    return _TURNS if has_derivatives(found, u.size, (3, 4)) else _TURNS_BY_DIFFERENCES


def _at(residual: _Residual, sizes: Array) -> Callable[[float], Equations]:
    """The equations in u and p at a value of q."""

    def at(q: float) -> Equations:
        def frozen(u: Array, p: float) -> Any:
            found = residual(u, p, q)
            return found[:3] if has_derivatives(found, u.size, (4,)) else found

        return Equations(frozen, sizes)

    return at
