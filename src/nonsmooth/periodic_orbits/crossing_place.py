"""Where branches cross, from orbits beside the place.

At the place itself the equations of an orbit are singular, and rounding moves the orbit by its root
along the branches that cross. Equal machines in step would part by that much, and several branches
that cross at once leave no equation that is regular there. Beside the place the orbit is known to
rounding, and so is the multiplier that is 1 there: both are smooth along the branch.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.stretch import BranchStretch

__all__ = ["at_crossing"]

Floats = npt.NDArray[np.float64]

# of the way on which the multiplier changes by `_CHANGE`
_BESIDE = np.array([-1.5, -1.0, -0.5, 0.5, 1.0, 1.5])
_CHANGE = 2e-3  # of the multiplier: rounding over that is 1e-13 of the orbit
_AWAY = 1.5  # times that way, within which the place is
_APART = 1e-6  # of multipliers, below which they are one several times


def at_crossing(stretch: BranchStretch, near: Point, before: Point) -> Point | None:
    """The point where branches cross, near one and from another one of the same branch.

    The parameter as a polynomial in the multiplier, and the orbit as one in the parameter, of
    degree 5. None where the orbits beside it are not found or do not come to it.
    """
    apart = before.p - near.p
    change = _from_one(stretch, before)
    if apart == 0.0 or not abs(change) > 0.0:
        return None
    way = apart / change * _CHANGE if abs(change) > _CHANGE else 0.5 * apart
    values, unknowns, changes = near.p + way * _BESIDE, [], []
    for value in values:
        try:
            stretch.set_parameter(float(value))
            guess = near.u + (value - near.p) / apart * (before.u - near.u)
            found = solve_orbit(stretch.equations, guess)
            if found.status != "completed":
                return None
            unknowns.append(found.unknowns)
            changes.append(_from_one(stretch, replace(near, u=found.unknowns, p=float(value))))
        except LegError:
            return None
    steps = np.diff(changes)
    if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        return None
    place = float(_interpolated(np.array(changes), values, 0.0))
    if not abs(place - near.p) <= _AWAY * abs(way):
        return None
    orbit = _interpolated(values, np.array(unknowns), place)
    return replace(near, u=np.asarray(orbit), p=place)


def _from_one(stretch: BranchStretch, point: Point) -> float:
    """How far the multiplier nearest to 1 is from it, as a mean of those that are the same."""
    away = stretch.look(point).multipliers.multipliers - 1.0
    nearest = away[np.argmin(np.abs(away))] if away.size else np.nan
    same = np.abs(away - nearest) <= _APART
    return float(away[same].mean().real) if away.size else np.nan


def _interpolated(places: Floats, values: Floats, at: float) -> Floats:
    """Value of the polynomial through values (k, ...) at places (k,)."""
    weights = [
        np.prod([(at - other) / (place - other) for other in places if other != place])
        for place in places
    ]
    return np.asarray(np.tensordot(np.array(weights), values, 1))
