"""What the parts share: arrays, a point of a branch, and why a trial point is refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = [
    "Array",
    "Jump",
    "Matrix",
    "NotConverged",
    "OutsideDomain",
    "PastBound",
    "Point",
    "Refused",
    "SingularMatrix",
]

Array = npt.NDArray[np.float64]
Matrix = Any  # a numpy array of two dimensions, or a sparse one of scipy


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


class Refused(Exception):
    """A trial point that cannot be had or cannot be believed."""

    ending = "smallest_step"


class OutsideDomain(Refused):
    """The residual has no finite value there."""

    ending = "domain"


class PastBound(Refused):
    """The parameter left its bounds; it is never evaluated there."""

    ending = "bound"


class SingularMatrix(Refused):
    """The bordered matrix has no inverse: no single curve goes through the point."""

    ending = "singular"


class NotConverged(Refused):
    """Newton's method did not settle."""


class Jump(Refused):
    """The step turned or bent too much: the point may lie on another branch."""
