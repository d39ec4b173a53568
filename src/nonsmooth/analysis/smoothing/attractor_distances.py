"""Attractors of two systems held against each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["far_from_all", "point_sets", "spread_of"]

_MOST = 1000  # points of one attractor that are compared

Floats = npt.NDArray[np.float64]


def point_sets(system: System, found: xr.Dataset) -> list[Floats]:
    """Points of each attractor, without drifting states."""
    kept = [i for i, name in enumerate(system.states) if name not in system.drift_states]
    sets = []
    for points in found["points"].values:
        finite = points[np.isfinite(points).all(axis=1)][:, kept]
        sets.append(finite[:: -(-len(finite) // _MOST) or 1])
    return sets


def spread_of(sets: list[Floats], system: System, region: dict[str, tuple[float, float]]) -> Floats:
    """Size of each state: the larger of its range in the region and over the attractors."""
    names = [name for name in system.states if name not in system.drift_states]
    wide = np.array([abs(np.diff(region.get(name, (0.0, 0.0)))[0]) for name in names])
    if sets:
        wide = np.maximum(wide, np.ptp(np.concatenate(sets), axis=0))
    return np.where(wide > 0.0, wide, 1.0)


def far_from_all(sets: list[Floats], others: list[Floats], spread: Floats, near: float) -> int:
    """Number of sets with a point that is farther than ``near`` from each of the others."""
    from scipy.spatial import cKDTree

    trees = [cKDTree(other / spread) for other in others]
    return sum(
        all(tree.query(points / spread)[0].max() > near for tree in trees) for points in sets
    )
