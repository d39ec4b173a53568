"""The point at which two branches cross, by Newton's method on equations that are regular there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import sparse

from nonsmooth.continuation.arrays import Array
from nonsmooth.continuation.equations import Equations, Linearised
from nonsmooth.continuation.refusals import NotConverged, SingularMatrix

__all__ = ["Crossing", "crossing_near"]

_ROUNDS = 12
_SETTLED = 1e-13  # scaled step at which the iteration ends
_ROUNDING = 1e-7  # the same for one that no longer shrinks
_SECOND_STEP = 1e-4  # differences of derivatives, where these are differences themselves


class Crossing(NamedTuple):
    """A point with derivatives [J_u J_p] of a rank one too low, in scaled terms.

    ``plane`` has two unit vectors across which the derivatives vanish, ``form`` the quadratic form
    in the plane that is zero along both branches, ``gap`` what is left of the residual: it is zero
    where the branches meet. All derivatives are by the largest singular value.
    """

    u: Array
    p: float
    plane: Array
    form: Array
    rank_left: float
    gap: float


def crossing_near(equations: Equations, u: Array, p: float) -> Crossing:
    """The point near a guess at which the derivatives lose their rank; `Refused` without one.

    With left and right null vectors w and v1, v2 of [J_u J_p], the equations are: the residual
    at right angles to w is zero, and so are w [J_u J_p] v1 and w [J_u J_p] v2.
    """
    scale, before = equations.scale, math.inf
    for _ in range(_ROUNDS):
        at = equations.linearised(u, p)
        left, values, right = np.linalg.svd(_wide(at, scale))
        w, plane = left[:, -1], right[-2:]
        curved = np.stack([w @ _curvature(equations, u, p, v) for v in plane])
        matrix = np.vstack([values[:-1, None] * right[:-2], curved])
        sides = np.concatenate([left[:, :-1].T @ at.r, values[-1] * (plane @ right[-2])])
        form = curved @ plane.T
        try:
            step = np.linalg.solve(matrix, sides)
        except np.linalg.LinAlgError:
            raise SingularMatrix("the branches touch there instead of crossing") from None
        u, p = u - step[:-1] * scale[:-1], p - float(step[-1] * scale[-1])
        length = math.sqrt(float(step @ step))
        size = 1.0 + math.sqrt(float(np.sum((u / scale[:-1]) ** 2)))
        if length <= _SETTLED * size or 0.25 * before < length <= _ROUNDING * size:
            largest = float(values[0]) if values[0] > 0.0 else 1.0
            if values.size == 1:  # one equation: all its derivatives vanish there
                largest = float(np.abs(form).max()) or 1.0
            gap = abs(float(w @ at.r)) / largest
            return Crossing(
                u, p, plane, 0.5 * (form + form.T) / largest, float(values[-1]) / largest, gap
            )
        before = length
    raise NotConverged("no point was found at which branches cross")


def _wide(at: Linearised, scale: Array) -> Array:
    J_u = at.J_u.toarray() if sparse.issparse(at.J_u) else at.J_u
    return np.column_stack([J_u, at.J_p]) * scale


def _curvature(equations: Equations, u: Array, p: float, v: Array) -> Array:
    """Derivative of the scaled [J_u J_p] along a scaled direction."""
    scale = equations.scale
    step = _SECOND_STEP if equations.by_differences else math.cbrt(np.finfo(float).eps)
    step *= 1.0 + math.sqrt(float(np.sum((u / scale[:-1]) ** 2)))
    du, dp = step * v[:-1] * scale[:-1], step * float(v[-1] * scale[-1])
    above = _wide(equations.linearised(u + du, p + dp), scale)
    below = _wide(equations.linearised(u - du, p - dp), scale)
    return (above - below) / (2.0 * step)
