"""The point at which two branches cross, by Newton's method on equations that are regular there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import sparse

from nonsmooth.continuation.equations import Equations, Linearised
from nonsmooth.continuation.point import Array, NotConverged, Refused, SingularMatrix

__all__ = ["Crossing", "crossing_near", "zero_directions"]

_ROUNDS = 12
_SETTLED = 1e-13  # scaled step at which the iteration ends
_ROUNDING = 1e-7  # the same for one that no longer shrinks
_AWAY = 1e6  # scaled step that leads to no place nearby
_DEGENERATE = 1e-4  # part of the other eigenvalue of the form, below which one may be zero
_BESIDE = 0.01  # scaled distance from a crossing at which its equations have their usual sizes
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
    scale, before, rows = equations.scale, math.inf, _row_sizes(equations, u, p)
    for _ in range(_ROUNDS):
        at = equations.linearised(u, p)
        left, values, right = np.linalg.svd(_wide(at, scale) / rows)
        w, plane = left[:, -1], right[-2:]
        curved = np.stack([w @ (_curvature(equations, u, p, v) / rows) for v in plane])
        r = at.r / rows[:, 0]
        matrix = np.vstack([values[:-1, None] * right[:-2], curved])
        sides = np.concatenate([left[:, :-1].T @ r, values[-1] * (plane @ right[-2])])
        form = curved @ plane.T
        try:
            step = np.linalg.solve(matrix, sides)
        except np.linalg.LinAlgError:
            raise SingularMatrix("no second derivatives fix it, as at a fold") from None
        largest = float(np.abs(step).max())
        if not largest <= _AWAY:
            raise SingularMatrix("Newton's method leaves the place")
        u, p = u - step[:-1] * scale[:-1], p - float(step[-1] * scale[-1])
        length = math.sqrt(float(step @ step))
        size = 1.0 + math.sqrt(float(np.sum((u / scale[:-1]) ** 2)))
        if length <= _SETTLED * size or 0.25 * before < length <= _ROUNDING * size:
            largest = float(values[0]) if values[0] > 0.0 else 1.0
            if values.size == 1:  # one equation: all its derivatives vanish there
                largest = float(np.abs(form).max()) or 1.0
            gap = abs(float(w @ r)) / largest
            return Crossing(
                u, p, plane, 0.5 * (form + form.T) / largest, float(values[-1]) / largest, gap
            )
        before = length
    raise NotConverged("no point was found at which branches cross")


def zero_directions(found: Crossing) -> list[Array]:
    """Scaled unit vectors along both branches; none where the form is definite or degenerate."""
    values, vectors = np.linalg.eigh(found.form)
    low, high = float(values[0]), float(values[1])
    if not low * high < 0.0 or min(-low, high) <= _DEGENERATE * max(-low, high):
        return []
    across = np.array([math.sqrt(high), math.sqrt(-low)]) / math.sqrt(high - low)
    return [vectors @ across @ found.plane, vectors @ (across * [1.0, -1.0]) @ found.plane]


def _wide(at: Linearised, scale: Array) -> Array:
    J_u = at.J_u.toarray() if sparse.issparse(at.J_u) else at.J_u
    return np.column_stack([J_u, at.J_p]) * scale


def _row_sizes(equations: Equations, u: Array, p: float) -> Array:
    """Sizes of the equations as a column, beside the point too: one may vanish on it."""
    scale = equations.scale
    size = 1.0 + math.sqrt(float(np.sum((u / scale[:-1]) ** 2)))
    rows = np.abs(_wide(equations.linearised(u, p), scale)).max(axis=1)
    for step in (_BESIDE * size, -_BESIDE * size):
        try:
            beside = equations.linearised(u + step * scale[:-1], p + step * float(scale[-1]))
        except Refused:
            continue
        rows = np.maximum(rows, np.abs(_wide(beside, scale)).max(axis=1))
    return np.where(rows > 0.0, rows, 1.0)[:, None]


def _curvature(equations: Equations, u: Array, p: float, v: Array) -> Array:
    """Derivative of the scaled [J_u J_p] along a scaled direction."""
    scale = equations.scale
    step = _SECOND_STEP if equations.by_differences else math.cbrt(np.finfo(float).eps)
    step *= 1.0 + math.sqrt(float(np.sum((u / scale[:-1]) ** 2)))
    du, dp = step * v[:-1] * scale[:-1], step * float(v[-1] * scale[-1])
    above = _wide(equations.linearised(u + du, p + dp), scale)
    below = _wide(equations.linearised(u - du, p - dp), scale)
    return (above - below) / (2.0 * step)
