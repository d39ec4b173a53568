"""`two_parameter`: curves of special points over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.equations import call, has_derivatives
from nonsmooth.continuation.extended import Residual, Scalar, extended
from nonsmooth.continuation.options import (
    checked_bounds,
    checked_options,
    number,
    sizes_of,
    start_of,
)
from nonsmooth.continuation.point import Array, OutsideDomain, Point
from nonsmooth.continuation.start import begin
from nonsmooth.errors import OptionError, quote

__all__ = ["two_parameter"]

# Slope of p by the arclength that counts as none where q turns: second derivatives of the residual
# are differences with a step of 1e-5, good to 1e-10. Differences of differences have a step of
# 1e-4 and are good to 1e-6. Slopes are as good, times the bend of the curve.
_TURNS = 1e-6
_TURNS_BY_DIFFERENCES = 1e-4


def two_parameter(
    residual: Residual,
    test: Scalar | str | Array,
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
    test : callable, {"fold"}, or array of shape (n, n)
        ``test(u, p, q)`` returns a number, or ``(g, g_u, g_p, g_q)`` with its derivatives; without
        them central differences are taken. ``"fold"``: J_u is singular. A matrix: J_u plus that
        matrix is singular, as 2 I for a map u -> f(u) with the residual f(u) - u where it doubles
        the period of a fixed point.
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
    if not callable(residual):
        raise OptionError(f"residual = {quote(residual)} is no function; give residual(u, p, q)")
    unknowns, first = start_of(u, p)
    test = _checked_test(test, unknowns.size)
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
    cusps = 0.0 if not isinstance(test, str) else _slope_at_cusps(residual, unknowns, first, second)
    options = replace(options, unknown_bounds=checked_bounds(first, bounds), cusps=cusps)
    sizes = np.append(sizes, sizes_of(unknowns[:1], second, None, second_scale, second_bounds)[-1])
    together = extended(residual, test, sizes, options.bounds)
    return begin(together, np.append(unknowns, first), second, direction, sizes, options)


def _slope_at_cusps(residual: Residual, u: Array, p: float, q: float) -> float:
    try:
        found = call(residual, u, p, q)
    except OutsideDomain:  # which the start is refused for
        return _TURNS
    return _TURNS if has_derivatives(found, u.size, (3, 4)) else _TURNS_BY_DIFFERENCES


def _checked_test(test: Any, n: int) -> Scalar | str | Array:
    if callable(test):
        found: Scalar = test
        return found
    if isinstance(test, str) and test == "fold":
        return "fold"
    if isinstance(test, np.ndarray) and test.shape == (n, n) and np.isrealobj(test):
        return np.asarray(test, dtype=float)
    raise OptionError(
        f"test = {quote(test)} is no function; give test(u, p, q), or the word 'fold', or a matrix"
        f" of {n} rows and columns that is added to J_u"
    )
