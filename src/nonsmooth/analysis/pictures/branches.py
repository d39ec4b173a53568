"""All branches of orbits up to a period, each once: from cycles, and out of special points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.continue_orbit import continue_orbit
from nonsmooth.analysis.find_orbit import find_orbit
from nonsmooth.analysis.pictures.chunks import Chunks
from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import OptionError
from nonsmooth.runs.packed_datasets import pack_dataset, unpack_dataset
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BranchCollector", "OrbitPoints"]

Floats = npt.NDArray[np.float64]

_MAY_BE = 0.2  # of the spread of each state: how near a branch passes on which the orbit may be
_NEAR = 1e-3  # likewise: points that are one
_SAME = 1e-6  # likewise, of the orbit of the branch at the very value
_AT = 1e-7  # of the range of the parameter, within which two values are one
_MOST = 200  # branches
_FAILURE = "failure"  # name of an array: why there is no branch
_LEAVING = ("flip", "symmetry_breaking", "branch_point")  # where other branches begin


@dataclass(frozen=True)
class OrbitPoints:
    """An orbit at one value of the parameter, by its points on the map."""

    value: float
    points: Floats  # (K, n) for a period of K
    anchor: Any = None  # the orbit itself, where it is known

    @property
    def period(self) -> int:
        """Number of points."""
        return len(self.points)


@dataclass
class BranchCollector:
    """Branches over a range of a parameter; a cycle that lies on one of them begins none.

    ``scale`` (n,) is the spread of each state, infinite for one that drifts.
    """

    chosen: StroboscopicMap
    parameter: str
    between: tuple[float, float]
    longest: int
    scale: Floats
    steps: int
    tolerance: float
    chunks: Chunks
    branches: list[xr.Dataset] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)  # of cycles that began no branch
    complete: bool = True

    @property
    def is_full(self) -> bool:
        """Whether there are as many branches as are followed at most."""
        return len(self.branches) >= _MOST

    def add_all(self, cycles: Iterator[OrbitPoints]) -> None:
        """Follow each cycle that lies on no branch, and what leaves the branches."""
        for cycle in cycles:
            if not self.complete or self.is_full:
                return
            if cycle.period <= self.longest and not self.holds(cycle):
                self._follow(cycle.value, initial=self._start(cycle), period=cycle.period)

    def holds(self, cycle: OrbitPoints) -> bool:
        """Whether a cycle lies on a branch that is known: the nearest places are tried first.

        A straight line between two points of a branch only tells where to look, and the orbit at
        the value itself decides: where impacts pass the phase of the map, states on the way are
        far from that line.
        """
        known = [branch for branch in self.branches if _period(branch) == cycle.period]
        places = [(*place, branch) for branch in known for place in self._places(branch, cycle)]
        for gap, place, branch in sorted(places, key=lambda each: each[0]):
            if gap > _MAY_BE:
                return False
            found = self._orbit_at(branch, place, cycle)
            if found is not None and self._gap(found, cycle.points) <= _SAME:
                return True
        return False

    def _places(self, branch: xr.Dataset, cycle: OrbitPoints) -> Iterator[tuple[float, int]]:
        """Points of a branch beside the value of a cycle, and how far it passes from the cycle."""
        values, states = branch[self.parameter].values, self._states(branch)
        before, after = values[:-1] - cycle.value, values[1:] - cycle.value
        for i in np.flatnonzero(before * after <= 0.0):
            step = values[i + 1] - values[i]
            share = 0.0 if step == 0.0 else (cycle.value - values[i]) / step
            guess = states[i] + share * (states[i + 1] - states[i])
            reach = self._gap(states[i], states[i + 1][None])
            yield self._gap(guess, cycle.points) - reach, int(i if share < 0.5 else i + 1)

    def _orbit_at(self, branch: xr.Dataset, place: int, cycle: OrbitPoints) -> Floats | None:
        """State of the orbit of a branch at the value of a cycle, from a point of the branch."""
        try:
            found = find_orbit(
                self.chosen, branch.isel(point=place), period=cycle.period,
                parameters={self.parameter: cycle.value}, tolerance=self.tolerance,
            )  # fmt: skip
        except OptionError:
            return None
        return np.array([float(found[name]) for name in self.chosen.system.states])

    def _start(self, cycle: OrbitPoints) -> Any:
        if cycle.anchor is not None:
            return cycle.anchor
        return dict(zip(self.chosen.system.states, cycle.points[0].tolist(), strict=True))

    def _follow(self, value: float, **beginning: Any) -> None:
        """One branch, and those that leave it."""
        found = self.chunks.take(
            partial(self._branch, value, **beginning), _packed, _unpacked, whole=_is_whole
        )
        if isinstance(found, str):
            self.failures.append(f"{self.parameter} = {value:.6g}: {found}")
            return
        self.branches.append(found)
        if not _is_whole(found):
            self.complete = False
            return
        self._leave(found)

    def _branch(self, value: float, **beginning: Any) -> xr.Dataset | str:
        """A branch, or why there is none."""
        try:
            found = continue_orbit(
                self.chosen, self.parameter, self.between, **beginning, steps=self.steps,
                tolerance=self.tolerance,
                parameters={self.parameter: value} if "special" not in beginning else None,
            )  # fmt: skip
        except OptionError as fault:
            return str(fault)
        if found.sizes["point"] < 2:
            if not _is_whole(found):
                raise KeyboardInterrupt
            return str(found.attrs["message"])
        return self._with_strobes(found)

    def _leave(self, branch: xr.Dataset) -> None:
        """Branches that begin at the special points of one."""
        for k, kind in enumerate(branch["special_kind"].values.tolist()):
            period = _period(branch) * (2 if kind == "flip" else 1)
            full = self.is_full or not self.complete
            if full or kind not in _LEAVING or period > self.longest:
                continue
            place = int(branch["special_point"].values[k])
            point = branch.isel(point=place)
            others = [each for each in self.branches if each is not branch]
            if not any(_period(each) == period and self._touches(each, point) for each in others):
                self._follow(float(point[self.parameter]), initial=branch, special=k)

    def _touches(self, branch: xr.Dataset, point: xr.Dataset) -> bool:
        """Whether a branch begins, ends or turns at a point of another one."""
        low, high = self.between
        value, values = float(point[self.parameter]), branch[self.parameter].values
        near = np.flatnonzero(np.abs(values - value) <= _AT * (high - low))
        state = np.array([float(point[name]) for name in self.chosen.system.states])
        strobes = self._strobes(state, value, _period(branch))
        return any(self._gap(self._states(branch)[i], strobes) <= _NEAR for i in near)

    def _strobes(self, state: Floats, value: float, period: int) -> Floats:
        """Points of a cycle on the map, from one of them."""
        there = self.chosen.with_parameters(**{self.parameter: value})
        return strobes_of(there, state, period, self.tolerance)

    def _with_strobes(self, branch: xr.Dataset) -> xr.Dataset:
        """The branch with all points of its orbits on the map, as settled motions have them."""
        width = self.longest - branch.sizes.get("strobe_of_turn", 0)
        return branch.pad(strobe_of_turn=(0, width)) if width else branch

    def _states(self, branch: xr.Dataset) -> Floats:
        return np.column_stack([branch[name].values for name in self.chosen.system.states])

    def _gap(self, state: Floats, points: Floats) -> float:
        """Distance of a state from the nearest of some points, beside the spread.

        Whole turns of angles count as none.
        """
        away = points - state
        away -= whole_turns(away, periods_of_states(self.chosen.system))
        return float((np.abs(away) / self.scale).max(axis=1).min())


def strobes_of(chosen: StroboscopicMap, state: Floats, period: int, tolerance: float) -> Floats:
    """Points of a cycle on a map, from one of them."""
    if period == 1:
        return state[None]
    found = chosen.runner(tolerance).images(state, ANY, period - 1)
    if found is None:
        return np.concatenate([state[None], np.full((period - 1, len(state)), np.nan)])
    return np.concatenate([state[None], found[0]])


def _is_whole(found: xr.Dataset | str) -> bool:
    """Whether a branch was not interrupted."""
    return isinstance(found, str) or found.attrs["status"] != "interrupted"


def _packed(found: xr.Dataset | str) -> dict[str, npt.NDArray[Any]]:
    return {_FAILURE: np.array(found)} if isinstance(found, str) else pack_dataset(found)


def _unpacked(arrays: dict[str, npt.NDArray[Any]]) -> xr.Dataset | str:
    return str(arrays[_FAILURE].item()) if _FAILURE in arrays else unpack_dataset(arrays)


def _period(branch: xr.Dataset) -> int:
    return int(branch.attrs["period"])
