"""Curves of solutions of any equations ``residual(u, p) = 0``, through folds.

Knows nothing of systems and their motions; numpy arrays in and out.
"""

from __future__ import annotations

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.follow import follow
from nonsmooth.continuation.point import Point

__all__ = ["Branch", "Point", "follow"]
