"""The residual with its derivatives: those that it gives, else central differences."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from nonsmooth.continuation.point import Array, Matrix, OutsideDomain, PastBound
from nonsmooth.errors import OptionError, quote

__all__ = [
    "DENSE_BELOW",
    "RELATIVE_STEP",
    "Equations",
    "Linearised",
    "call",
    "difference",
    "difference_within",
    "has_derivatives",
]

RELATIVE_STEP = math.cbrt(np.finfo(float).eps)  # error of a central difference is least
DENSE_BELOW = 150  # unknowns, up to which a dense solver is faster than a sparse one
# What the module math says of arguments outside a function's domain, which is a ValueError there.
_MATH_DOMAIN = ("math domain error", "expected a")


class Linearised(NamedTuple):
    """Residual and its derivatives at one place."""

    r: Array
    J_u: Matrix
    J_p: Array


class Equations:
    """``residual(u, p)`` with checks, derivatives and its domain.

    ``sizes`` are those of the unknowns and, last, of the parameter. Arclength is measured in
    ``scale``, where the unknowns count by their mean square, so that a finer mesh of the same
    field is no longer branch. The parameter is never taken beyond ``bounds``, not for a difference
    either.
    """

    def __init__(
        self,
        residual: Callable[[Array, float], Any],
        sizes: Array,
        bounds: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        self.residual, self.sizes, self.bounds = residual, sizes, bounds
        self.n = sizes.size - 1
        self.scale = sizes.copy()
        self.scale[:-1] *= np.sqrt(self.n)
        self.evaluations = 0
        self.by_differences = False  # as the residual showed when it was asked last

    def linearised(self, u: Array, p: float) -> Linearised:
        """Residual and derivatives; `Refused` outside the domain and the bounds."""
        low, high = self.bounds
        if not low <= p <= high:
            raise PastBound
        r, J_u, J_p = self._parts(u, p)
        self.by_differences = J_u is None
        if J_u is None:
            J_u, J_p = self._differences(u, p, r)
        return Linearised(r, J_u, J_p)

    def value(self, u: Array, p: float) -> Array:
        """Residual alone."""
        return self._parts(u, p)[0]

    def _parts(self, u: Array, p: float) -> tuple[Array, Any, Any]:
        """What the residual returns, checked: numbers, their shapes, all finite."""
        self.evaluations += 1
        found = call(self.residual, u, p)
        n = self.n
        r, J_u, J_p = found if has_derivatives(found, n) else (found, None, None)
        r = _numbers("the residual", r, (n,))
        if J_u is not None:
            J_p = _numbers("the derivative J_p", J_p, (n,))
            J_u = _matrix(J_u, n)
        return r, J_u, J_p

    def _differences(self, u: Array, p: float, r: Array) -> tuple[Array, Array]:
        J_u = np.empty((self.n, self.n))
        for i in range(self.n):

            def moved(by: float, i: int = i) -> Array:
                at = u.copy()
                at[i] += by
                return self.value(at, p)

            J_u[:, i] = difference(moved, r, self._step(u[i], i))
        J_p = difference_within(lambda at: self.value(u, at), r, p, self._step(p, -1), self.bounds)
        return J_u, J_p

    def _step(self, value: float, place: int) -> float:
        return RELATIVE_STEP * max(abs(float(value)), float(self.sizes[place]))


def call(function: Callable[..., Any], *arguments: Any) -> Any:
    """A user's function; where it has no value is outside the domain."""
    try:
        with np.errstate(all="ignore"):
            return function(*arguments)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise OutsideDomain(str(error)) from None
    except ValueError as error:
        if str(error).startswith(_MATH_DOMAIN):
            raise OutsideDomain(str(error)) from None
        raise


def difference(moved: Callable[[float], Any], r: Any, step: float) -> Any:
    """Central difference, one-sided where the domain ends."""
    try:
        above = moved(step)
    except OutsideDomain:
        return (r - moved(-step)) / step
    try:
        below = moved(-step)
    except OutsideDomain:
        return (above - r) / step
    return (above - below) / (2.0 * step)


def difference_within(
    value: Callable[[float], Any], here: Any, at: float, step: float, bounds: tuple[float, float]
) -> Any:
    """Difference by a number that is never taken beyond its bounds: one-sided beside them."""
    low, high = bounds
    if low <= at - step and at + step <= high:
        return difference(lambda by: value(at + by), here, step)
    inward = step if at + 2 * step <= high else -step  # towards the middle
    return (4.0 * value(at + inward) - 3.0 * here - value(at + 2 * inward)) / (2.0 * inward)


def has_derivatives(found: Any, n: int, lengths: tuple[int, ...] = (3,)) -> bool:
    """Whether a residual of n numbers came with derivatives; three numbers may be one of three."""
    if not (isinstance(found, tuple) and len(found) in lengths):
        return False
    return len(found) != n or np.size(found[0]) == n


def _numbers(what: str, values: Any, shape: tuple[int, ...]) -> Array:
    try:
        numbers = np.asarray(values)
        if numbers.dtype.kind not in "fiu":
            raise TypeError(f"of kind {numbers.dtype}")
        numbers = numbers.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise OptionError(
            f"{what} is {quote(values)}, not real numbers ({error}); residual(u, p) returns an"
            " array r, or (r, J_u, J_p) with derivatives"
        ) from None
    if numbers.size != math.prod(shape):
        raise OptionError(
            f"{what} has the shape {numbers.shape} where u has {shape[0]} unknowns; residual(u, p)"
            f" returns as many equations as u has numbers, so {shape} here: the parameter's own"
            " equation is added by the continuation"
        )
    if not np.isfinite(numbers).all():
        raise OutsideDomain(f"{what} is not finite")
    return numbers.reshape(shape)


def _matrix(J_u: Any, n: int) -> Matrix:
    if not sparse.issparse(J_u):
        return _numbers("the derivative J_u", J_u, (n, n))
    if J_u.shape != (n, n):
        raise OptionError(f"the sparse J_u has the shape {J_u.shape}, not {(n, n)}")
    if n <= DENSE_BELOW:
        return _numbers("the derivative J_u", J_u.toarray(), (n, n))
    if not np.isfinite(J_u.data).all():
        raise OutsideDomain("the derivative J_u is not finite")
    return J_u
