"""`branch_directions`: where branches cross, and where they go from there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.continuation.crossing import Crossing, crossing_near, zero_directions
from nonsmooth.continuation.equations import Equations
from nonsmooth.continuation.options import sizes_of, start_of
from nonsmooth.continuation.point import Array, Refused
from nonsmooth.continuation.start import scaled_direction
from nonsmooth.errors import OptionError, RunError, quote

__all__ = ["BranchPoint", "branch_directions"]

_RANK = 1e-5  # singular value, by the largest, that counts as zero
_GAP = 1e-8  # residual, by the largest singular value, that counts as none


@dataclass(frozen=True, slots=True, eq=False)
class BranchPoint:
    """A point at which two branches cross.

    Parameters
    ----------
    u : numpy.ndarray
        The unknowns there.
    p : float
        The parameter there.
    directions : tuple of (numpy.ndarray, float)
        Direction (du, dp) of either branch, of unit arclength. Its opposite leads the other way.

    See Also
    --------
    branch_directions : what gives it.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.continuation.branch_directions(lambda u, p: u * (p - u**2), 0.01, 0.01)
    >>> [bool(abs(value) < 1e-8) for value in (found.p, found.u[0])]
    [True, True]
    """

    u: Array
    p: float
    directions: tuple[tuple[Array, float], ...]


def branch_directions(
    residual: Callable[[Array, float], Any],
    u: Any,
    p: float,
    *,
    along: tuple[Any, float] | None = None,
    scale: Any = None,
    parameter_scale: float | None = None,
) -> BranchPoint:
    """The point near (u, p) at which two branches of a residual cross, and their directions.

    For simple branch points: the derivatives by u and p together lose one of their rank, as in a
    transcritical or pitchfork bifurcation, where symmetry breaks for instance. The directions are
    the zeros of the quadratic form that the second derivatives leave in the null space.

    Parameters
    ----------
    residual : callable
        As for `follow`. With derivatives of its own the result is good to rounding.
    u, p : array_like, float
        A guess: a point that `follow` gave with the name ``"branch_point"``.

    Other Parameters
    ----------------
    along : (array_like, float), optional
        Direction (du, dp) of a branch that is known, such as ``(point.tangent_u,
        point.tangent_p)``. That of the result which is closest to it comes first.
    scale, parameter_scale : optional
        As for `follow`.

    Returns
    -------
    BranchPoint
        ``u``, ``p`` and ``directions``, of which each starts a branch:
        ``follow(residual, found.u, found.p, direction=found.directions[1])``.

    Raises
    ------
    OptionError
        For bad options.
    RunError
        Where no such point is near, where branches pass without meeting, or where the point is
        isolated.

    Examples
    --------
    A pitchfork: the branch u = 0 is left at p = 1 by one with u**2 = p - 1.

    >>> import nonsmooth as ns
    >>> def pitchfork(u, p):
    ...     return u * (p - 1 - u**2), p - 1 - 3 * u**2, u
    >>> trivial = ns.continuation.follow(pitchfork, 0.0, 0.1, bounds=(0.0, 2.0))
    >>> point = next(point for point in trivial if point.special == "branch_point")
    >>> found = ns.continuation.branch_directions(
    ...     pitchfork, point.u, point.p, along=(point.tangent_u, point.tangent_p)
    ... )
    >>> arm = ns.continuation.follow(
    ...     pitchfork, found.u, found.p, direction=found.directions[1], bounds=(0.0, 2.0)
    ... )
    >>> *_, last = arm
    >>> last.p, round(abs(float(last.u[0])), 12)
    (2.0, 1.0)
    """
    if not callable(residual):
        raise OptionError(f"residual = {quote(residual)} is no function; give residual(u, p)")
    unknowns, parameter = start_of(u, p)
    sizes = sizes_of(unknowns, parameter, scale, parameter_scale, (-math.inf, math.inf))
    equations = Equations(residual, sizes)
    known = None
    if along is not None:
        known, _ = scaled_direction(along, unknowns.size, equations.scale)
    try:
        found = crossing_near(equations, unknowns, parameter)
    except Refused as refusal:
        raise RunError(
            f"no branches cross near p = {parameter:g}: {refusal}; give a point that follow calls"
            " 'branch_point'",
            status="no_branch_point",
        ) from None
    _check(found)
    vectors = _directions(found)
    if known is not None:
        vectors.sort(key=lambda vector: -abs(float(vector @ known)))
        vectors = [v if float(v @ known) >= 0.0 else -v for v in vectors]
    unscaled = [vector * equations.scale for vector in vectors]
    return BranchPoint(found.u, found.p, tuple((v[:-1], float(v[-1])) for v in unscaled))


def _check(found: Crossing) -> None:
    if found.rank_left > _RANK:
        raise RunError(
            f"no branches cross near p = {found.p:.10g}: the smallest singular value of the"
            f" derivatives is {found.rank_left:.2g} of the largest there; give a point that follow"
            " calls 'branch_point'",
            status="no_branch_point",
        )
    if found.gap > _GAP:
        raise RunError(
            f"branches pass each other near p = {found.p:.10g} without meeting: the residual is"
            f" {found.gap:.2g} of the largest singular value between them, as where a symmetry is"
            " not exact; follow each of them from a start of its own",
            status="imperfect",
        )


def _directions(found: Crossing) -> list[Array]:
    low, high = np.linalg.eigvalsh(found.form)
    directions = zero_directions(found)
    if directions:
        return directions
    if low * high > 0.0:
        raise RunError(
            f"the point at p = {found.p:.10g} is isolated: no branch goes through it, as where a"
            " closed curve appears; start from another one",
            status="isolated",
        )
    raise RunError(
        f"the branches at p = {found.p:.10g} touch instead of crossing: their directions are the"
        " same to second order; follow each of them from a start of its own",
        status="tangent",
    )
