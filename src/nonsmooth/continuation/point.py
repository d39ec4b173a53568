"""`Point`: one solution on a branch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nonsmooth.continuation.arrays import Array

__all__ = ["Point"]


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A solution of ``residual(u, p) = 0`` on a branch, as `follow` gives them.

    Parameters
    ----------
    u : numpy.ndarray
        The unknowns.
    p : float
        The parameter.
    tangent_u, tangent_p : numpy.ndarray, float
        Their derivatives by the arclength.
    arclength : float
        Length of the branch from its start, in the scaled unknowns.
    step : float
        Length of the branch from the point before.
    iterations : int
        Newton steps that the point took.
    residual : float
        Largest residual where the last of these steps began; what is left behind it is smaller.
    tests : mapping of str to float
        What ``tests`` gave here; empty without.
    special : str, optional
        ``"fold"``, ``"branch_point"``, ``"bound"``, ``"closed"``, or the name of the test that is
        zero here; empty for the points between.

    See Also
    --------
    follow : what gives them.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> branch = ns.continuation.follow(lambda u, p: u**2 - p, 1.0, 1.0)
    >>> point = next(branch)
    >>> point.u, point.p, point.special
    (array([1.]), 1.0, '')
    >>> round(float(point.tangent_u[0] / point.tangent_p), 6)
    0.5
    """

    u: Array
    p: float
    tangent_u: Array
    tangent_p: float
    arclength: float
    step: float
    iterations: int
    residual: float
    tests: Mapping[str, float]
    special: str = ""
