"""Curves of solutions of any equations ``residual(u, p) = 0``, through folds.

Knows nothing of systems and their motions; numpy arrays in and out.
"""

from __future__ import annotations

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.branch_directions import BranchPoint, branch_directions
from nonsmooth.continuation.follow import follow
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.two_parameter import two_parameter

__all__ = ["Branch", "BranchPoint", "Point", "branch_directions", "follow", "two_parameter"]


def __dir__() -> list[str]:
    return sorted(__all__)
