"""The first point of a branch: corrected, with a direction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.continuation.bordered import Determinant, solve_bordered
from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.corrector import Corrector, Node, turn
from nonsmooth.continuation.equations import Equations, Linearised
from nonsmooth.continuation.options import Options
from nonsmooth.continuation.point import Array, PastBound, Refused
from nonsmooth.errors import OptionError, RunError, quote

__all__ = ["begin", "scaled_direction"]


_SMALLEST_RANK = 1e-6  # singular values below this part of the largest count as zero at a start
_FAR = 0.1  # scaled distance, from the given start, of one that is still meant by it
_STILL = 1e-10  # of a unit tangent: rounding
_STRAIGHT = 0.2  # angle up to which a given direction is taken for that of the branch


def scaled_direction(direction: Any, n: int, scale: Array) -> tuple[Array, bool]:
    """Unit vector of a direction in scaled unknowns; whether it was given as one."""
    if isinstance(direction, (int, float, np.integer, np.floating)):
        if direction not in (1, -1):
            raise OptionError(
                f"direction = {direction!r}: 1 for a parameter that grows at first, -1 for one that"
                " falls, or (du, dp) for a direction"
            )
        ahead = np.zeros(n + 1)
        ahead[-1] = float(direction)
        return ahead, False
    try:
        du, dp = direction
        ahead = np.append(np.asarray(du, dtype=float).reshape(n), float(dp)) / scale
    except (TypeError, ValueError, OverflowError):
        raise OptionError(
            f"direction = {quote(direction)}: 1, -1, or (du, dp) with {n} numbers and one"
        ) from None
    length = float(np.linalg.norm(ahead))
    if not (np.isfinite(length) and length > 0.0):
        raise OptionError(f"direction = {quote(direction)} has no finite length above zero")
    return ahead / length, True


def _first_node(corrector: Corrector, u: Array, p: float, ahead: Array, given: bool) -> Node:
    """The start on the branch, at its own parameter where there is such a point."""
    at = _at(corrector, u, p)
    if given:
        return corrector.onto_bound(_with_direction(corrector, u, p, ahead))
    try:
        found = corrector.at_parameter(u, p)
    except Refused:
        found = _nearest(corrector, u, p, at)
    return corrector.onto_bound(found.turned(_told_way(found.tangent, ahead)))


def _told_way(tangent: Array, ahead: Array) -> Array:
    """The way ahead, by the unknown that changes most where the parameter only does by rounding.

    So both ways of such a branch are opposite ones.
    """
    if abs(float(tangent[-1])) > _STILL:
        return ahead
    way = np.zeros_like(ahead)
    way[int(np.argmax(np.abs(tangent)))] = ahead[-1]
    return way


def _at(corrector: Corrector, u: Array, p: float) -> Linearised:
    try:
        return corrector.equations.linearised(u, p)
    except Refused as refusal:
        raise RunError(
            f"the residual has no finite value at the start, p = {p:g}: {refusal}; start inside its"
            " domain",
            status="domain",
        ) from None


def _with_direction(corrector: Corrector, u: Array, p: float, ahead: Array) -> Node:
    """A start from which a direction is given: two branches may cross there."""
    try:
        try:
            found = corrector.across(u, p, ahead, _FAR)
        except PastBound:  # by rounding, where the start is on a bound
            found = corrector.at_parameter(u, p, _FAR).turned(ahead)
        if turn(found.tangent, ahead) < _STRAIGHT:
            return found
    except Refused:
        pass
    found = _nearest(corrector, u, p, _at(corrector, u, p))
    found.tangent, found.determinant = ahead, Determinant(0.0, 0.0)
    return found


def _nearest(corrector: Corrector, u: Array, p: float, at: Linearised) -> Node:
    """The nearest solution, its parameter free: for starts at folds and where branches cross."""
    equations, scale = corrector.equations, corrector.equations.scale
    size = 1.0 + corrector.length(u, p)
    start, given = corrector.scaled(u, p), p
    for iteration in range(1, 4 * corrector.max_newton):
        wide = np.column_stack([_dense(at), at.J_p]) * scale
        step = np.linalg.lstsq(wide, at.r, rcond=_SMALLEST_RANK)[0]
        u, p = u - step[:-1] * scale[:-1], p - float(step[-1] * scale[-1])
        if float(np.linalg.norm(corrector.scaled(u, p) - start)) > _FAR * size:
            break
        if float(np.linalg.norm(step)) <= corrector.tolerance * size:
            tangent, determinant = _null_direction(at, wide, scale)
            residual = float(np.abs(at.r).max())
            return Node(u, p, tangent, determinant, iteration, residual, 0.0)
        try:
            at = equations.linearised(u, p)
        except Refused:
            break
    raise RunError(
        f"no solution was found from the start at p = {given:g}: Newton's method does not settle;"
        " give a better u, another p, more max_newton=, a larger tolerance= where the residual is"
        " not good to 1e-9, and check the derivatives if you give them",
        status="no_convergence",
    )


def _null_direction(at: Linearised, wide: Array, scale: Array) -> tuple[Array, Determinant]:
    """The direction that the derivatives annul, and the determinant with it as last row."""
    last = np.linalg.svd(wide)[2][-1]
    try:
        solved = solve_bordered(at, last, scale)
    except Refused:
        return last, Determinant(0.0, 0.0)
    return solved.tangent, solved.determinant


def _dense(at: Linearised) -> Array:
    found = at.J_u if isinstance(at.J_u, np.ndarray) else at.J_u.toarray()
    return np.asarray(found, dtype=float)


def begin(
    residual: Callable[[Array, float], Any],
    u: Array,
    p: float,
    direction: Any,
    sizes: Array,
    options: Options,
) -> Branch:
    """The branch through a start, which is corrected here."""
    equations = Equations(residual, sizes, options.bounds)
    corrector = Corrector(equations, options.tolerance, options.max_newton)
    ahead, given = scaled_direction(direction, u.size, equations.scale)
    return Branch(corrector, options, _first_node(corrector, u, p, ahead, given))
