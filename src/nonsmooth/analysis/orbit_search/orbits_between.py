"""Orbits between the points of a branch, solved from the nearest one that is known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.orbit_search.best_options import WantedBest
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest
from nonsmooth.periodic_orbits.orbit_dataset import orbit_dataset, orbit_variables
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.search import fitted, solve_guess

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["OrbitsBetween", "orbit_of_point"]

_OF_BRANCH = ("arclength", "point")


def orbit_of_point(branch: xr.Dataset, point: int) -> xr.Dataset:
    """A point of a branch as `find_orbit` gives an orbit."""
    one = branch.drop_dims("special").isel(point=point)
    legs = np.flatnonzero(one["leg_mode"].values >= 0)
    kept = one.isel(leg=legs).drop_vars([*_OF_BRANCH], errors="ignore")
    kept.attrs = {name: branch.attrs[name] for name in ("system_name", "system",
                  "nonsmooth_version") if name in branch.attrs}  # fmt: skip
    return kept


class OrbitsBetween:
    """Orbits over the parameter, near some points of a branch."""

    def __init__(self, wanted: WantedBest, points: Sequence[int]) -> None:
        branch, system = wanted.branch, wanted.system
        self._best = wanted
        self._legs = Legs(system)
        self._values = dict(system.parameter_values)
        self._wanted = OrbitRequest(
            system, None, int(branch.attrs["period"]), float(branch.attrs["phase_of_period"]), 0,
            None, (), wanted.tolerance,
        )  # fmt: skip
        # where the equations are singular, as at a fold, Newton's method does not begin well
        special = {int(each) for each in branch["special_point"].values}
        chosen = [each for each in dict.fromkeys(points) if each not in special] or points[:1]
        values = branch[wanted.parameter].values
        self._known: dict[float, Guess] = {
            float(values[k]): guess_of_dataset(system, orbit_of_point(branch, k)) for k in chosen
        }
        self._orbits: dict[float, Orbit | None] = {}

    def quantity(self, p: float) -> float:
        """The quantity at a value of the parameter; nan where no orbit is allowed there."""
        orbit = self._orbit(p)
        if orbit is None:
            return float("nan")
        name = self._best.quantity
        if name == self._best.parameter:
            return p
        if isinstance(name, str):
            return float(orbit_variables(self._best.system, [orbit], ())[name][1])
        return name(self._dataset(orbit, p))

    def dataset(self, p: float) -> xr.Dataset | None:
        """The orbit at a value of the parameter."""
        orbit = self._orbit(p)
        return None if orbit is None else self._dataset(orbit, p)

    def _dataset(self, orbit: Orbit, p: float) -> xr.Dataset:
        changed = self._best.system.with_parameters(**{self._best.parameter: p})
        attrs: dict[str, Any] = {}
        found = orbit_dataset(changed, orbit, attrs)
        return found.assign({self._best.parameter: p})

    def _orbit(self, p: float) -> Orbit | None:
        if p not in self._orbits:
            self._orbits[p] = self._solved(p)
        return self._orbits[p]

    def _solved(self, p: float) -> Orbit | None:
        nearest = min(self._known, key=lambda each: abs(each - p))
        best = self._best
        try:
            self._legs.set_values(self._values | {best.parameter: p})
            guess = fitted(self._known[nearest], self._wanted, self._legs)
            orbit = solve_guess(self._wanted, self._legs, guess).orbit
        except LegError:
            return None
        if orbit is None:
            return None
        self._known[p] = Guess(orbit.word, orbit.turn)
        if not (orbit.stable or best.unstable):
            return None
        return orbit if orbit.admissibility.admissible or best.inadmissible else None
