"""Orbits that are not alone: where nothing fixes the amplitude, one of each size closes.

Their equations are singular, so Newton's method leads away along the family, often to the point at
rest in its middle. The step of least length that leaves out the direction of the family leads onto
it instead, to the member nearest to the guess.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import Solution, null_vector, row_scale, scale_of, size_of

__all__ = ["member_of_family"]

Floats = npt.NDArray[np.float64]

_MOST_STEPS = 12  # each doubles the digits
_CLOSED = 1e-12  # residual, beside the states, of a member
_NEAR = 0.1  # farthest from the guess, beside the unknowns
_NEXT = 1e-2  # to another member, likewise
_NOT_LEFT = 0.5  # part of that way which must remain
_SINGULAR = 1e-4  # singular values beside the largest one, of directions that are left out too


def member_of_family(equations: OrbitEquations, guess: Floats) -> Solution | None:
    """The nearest orbit of a family; None where there is none, or the orbit is alone.

    At a fold the equations are singular too, but beside it along their direction there is no orbit.
    """
    scale = scale_of(equations, guess)
    found = _nearest(equations, guess, scale)
    if found is None or np.abs((found.unknowns - guess) / scale).max() > _NEAR:
        return None
    try:
        along = null_vector(equations, found.unknowns)
    except (LegError, np.linalg.LinAlgError):
        return None
    along *= _NEXT / np.abs(along / scale).max()
    other = _nearest(equations, found.unknowns + along, scale)
    if other is None:
        return None
    way = float(np.abs((other.unknowns - found.unknowns) / scale).max())
    if not _NOT_LEFT * _NEXT <= way <= _NEXT / _NOT_LEFT:
        return None
    equations.evaluate(found.unknowns)
    return found


def _nearest(equations: OrbitEquations, unknowns: Floats, scale: Floats) -> Solution | None:
    """Where steps lead that are as short as possible; None where they do not come to an orbit."""
    size = np.inf
    for iteration in range(_MOST_STEPS):
        try:
            residual, jacobian, _ = equations.evaluate(unknowns)
        except LegError:
            return None
        rows = row_scale(equations, scale, jacobian)
        before, size = size, size_of(residual, rows)
        if not np.isfinite(size):
            return None
        if size <= _CLOSED and size >= 0.5 * before:
            return Solution(unknowns, size, iteration, "completed")
        unknowns = unknowns + scale * _shortest(jacobian * scale / rows[:, None], -residual / rows)
    return Solution(unknowns, size, _MOST_STEPS, "completed") if size <= _CLOSED else None


def _shortest(matrix: Floats, right: Floats) -> Floats:
    """Solution of singular equations without a part along the direction that they leave open."""
    left, values, ways = np.linalg.svd(matrix)
    kept = values > _SINGULAR * values[0]
    kept[-1] = False
    weights = np.where(kept, left.T @ right / np.where(kept, values, 1.0), 0.0)
    return np.asarray(weights @ ways)
