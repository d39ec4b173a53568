"""Which attractor is the mirror image of which, under the declared symmetry of their system."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.engine.lanes import SAME
from nonsmooth.runs.strobe_runner import StrobeRunner
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["NO_IMAGE", "has_images", "with_images"]

Floats = npt.NDArray[np.float64]

NO_IMAGE = 0  # among the attractors that were found
_SAME = 1e-6  # of the size of each state: cycles are known to rounding, and attract what is near
_LOOKED_AT = 500  # points of a set that does not repeat
_NEAR = 3.0  # times the distance of the points of a set, in which the image of another one lies
_LATER = 1.5  # periods: half a period, and one in which nothing but a period goes by


def has_images(chosen: Any) -> bool:
    """Whether images of attractors are points of the same map: those of strobes of the forcing."""
    return bool(
        isinstance(chosen, StroboscopicMap) and chosen.period is None and chosen.system.symmetry
    )


def with_images(chosen: Any, attractors: list[Attractor], tolerance: float) -> list[Attractor]:
    """Attractors, numbered from 1, with the numbers of their mirror images."""
    if not has_images(chosen) or not attractors:
        return attractors
    system: System = chosen.system
    keep = np.array([name not in system.drift_states for name in system.states])
    sizes = np.abs(np.concatenate([one.points for one in attractors])).max(axis=0)
    scale = np.where(sizes > 0.0, sizes, 1.0)
    known = [(one.points / scale)[:, keep] for one in attractors]
    found = []
    for one in attractors:
        images = (_images(chosen, one, tolerance) / scale)[:, keep]
        gaps = [
            _gap(images, points, one.is_cycle) if other.period == one.period else np.inf
            for other, points in zip(attractors, known, strict=True)
        ]
        nearest = int(np.argmin(gaps))
        found.append(replace(one, image=nearest + 1 if gaps[nearest] <= 1.0 else NO_IMAGE))
    return found


def _images(chosen: StroboscopicMap, one: Attractor, tolerance: float) -> Floats:
    """Mirror images of points of an attractor, at the phase of the map; nan where motions end."""
    mirror, period = chosen.system.mirror, chosen.system.period_value
    assert mirror is not None and period is not None  # see `has_images`
    count = 1 if one.is_cycle else _LOOKED_AT
    points = one.points[:count]
    if mirror.half_period:
        length = _LATER * period
        runner = StrobeRunner(chosen.system, tolerance, phase=chosen.phase / _LATER, period=length)
        points, _ = runner.last(runner.start(points, SAME - one.modes[:count].astype(np.int64)), 1)
    return mirror.states(points)


def _gap(images: Floats, points: Floats, is_cycle: bool) -> float:
    """How far images lie from an attractor, beside what is near enough."""
    from scipy.spatial import KDTree

    tree = KDTree(points)
    if not np.all(np.isfinite(images)):
        return np.inf
    distances = tree.query(images)[0]
    if is_cycle:
        return float(distances.max()) / _SAME
    spacing = float(np.median(tree.query(points[:_LOOKED_AT], k=2)[0][:, 1]))
    return float(np.median(distances)) / max(_NEAR * spacing, _SAME)
