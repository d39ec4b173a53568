"""Attractors by recurrences: what lanes come back to, and which attractor each one comes to.

A lane that visits only cells of the state space in which it has been before, many times in a row,
has found an attractor (G. Datseris and A. Wagemakers, Chaos 32, 023104, 2022). Here the cells are
those of an exact map, cycles are refined by Newton's method and get a ball around each point in
which motions are seen to converge; a lane that enters these balls in their order, or stays in the
cells of a larger set, belongs to it. Lanes know nothing of each other but the attractors, so their
order changes no label.

The ball around a point of a cycle is only as sure as the trial starts that have shown it, and a
chaotic motion may pass through some balls in order. So a lane that has come to a cycle is run on
until a motion that converges must have come nearer, and belongs to the cycle if it has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.engine.attractors import Landmarks, Visits, cell_keys, fill_cells, visit

__all__ = ["Known", "KnownCycles", "Measure", "confirm_visits", "new_visits", "share_of_new"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_AS_NEAR = 1.5  # times the distances within a set: those between two parts of it
_SHRINKS = 0.01  # by which the slowest direction of a cycle shrinks in a run that confirms
_NEARER = 0.1  # of its distance from a point to which a lane must have come by then
_CLOSE = 1e-5  # beside the scale: cycles that are nearer to each other are one
_MOST = 2000  # iterates of such a run; a cycle that needs more is not confirmed

IN_CYCLE = 3  # visits in a row, in order: each ball is one of convergence already
IN_SET = 50  # a lane that only passes leaves the cells earlier; more cost time alone
_CELLS = 1 << 12  # places of the table of cells to begin with


@dataclass(frozen=True)
class KnownCycles:
    """Cycles that may be confirmed: their points, and the iterates that this takes."""

    columns: Integers  # states that are compared
    scale: Floats  # of them
    points: dict[int, Floats]  # (p, d) in these units, by the number of the attractor
    iterates: dict[int, int]  # 0 where it would take too many

    @classmethod
    def of(cls, attractors: Sequence[Attractor], measure: Any) -> KnownCycles:
        """The cycles among some attractors, numbered from 1 on."""
        cycles = {i + 1: one for i, one in enumerate(attractors) if one.is_cycle}
        return cls(
            measure.columns,
            measure.scale[measure.columns],
            {number: measure.scaled(one.points) for number, one in cycles.items()},
            {number: _iterates(one) for number, one in cycles.items()},
        )

    def unconfirmed(self, label: Integers) -> int:
        """How many labels rest on the balls of their cycles alone."""
        return sum(
            int(np.count_nonzero(label == number))
            for number, count in self.iterates.items()
            if count == 0
        )

    def distances(self, states: Floats, number: int) -> Floats:
        """Distances of states from the points of a cycle, (K, p)."""
        scaled = states[:, self.columns] / self.scale
        return np.asarray(np.linalg.norm(scaled[:, None] - self.points[number][None], axis=2))


def confirm_visits(
    runner: Any, lanes: Any, states: Floats, cycles: KnownCycles, visits: Visits
) -> None:
    """Take back the labels of lanes that do not come nearer to the cycle they were given.

    The lanes themselves stay where they are. shapes: states (L, n), in which they are
    """
    for number, count in cycles.iterates.items():
        arrived = np.flatnonzero(visits.label == number)
        if not count or not arrived.size:
            continue
        distances = cycles.distances(states[arrived], number)
        point = np.argmin(distances, axis=1)[:, None]
        ends, _ = runner.last(lanes.select(arrived), count)  # whole turns later
        before = np.take_along_axis(distances, point, axis=1)[:, 0]
        after = np.take_along_axis(cycles.distances(ends, number), point, axis=1)[:, 0]
        lost = arrived[~(after <= np.maximum(_NEARER * before, _CLOSE))]  # nan: it has ended
        visits.label[lost] = visits.candidate[lost] = visits.score[lost] = visits.needed[lost] = 0
        visits.point[lost] = -1


def _iterates(cycle: Attractor) -> int:
    """Iterates in which motions near a cycle come nearer, 0 where it takes too many."""
    rate = np.abs(cycle.multipliers).max(initial=0.0) if cycle.multipliers is not None else 1.0
    turns = 1 if rate <= _SHRINKS else np.log(_SHRINKS) / np.log(min(rate, 1.0 - 1e-12))
    count = int(np.ceil(turns)) * cycle.period
    return count if count <= _MOST else 0


@dataclass(frozen=True)
class Measure:
    """How states are compared: which, in what units, and the width of a cell in them."""

    columns: Integers  # (d,): states that do not drift
    scale: Floats  # (n,): unit of each state
    cell: float

    def keys(self, states: Floats) -> Integers:
        """Keys of the cells in which states lie; shapes: states (K, n), returns (K,)."""
        return cell_keys(states, self.columns, self.scale[self.columns], self.cell)

    def scaled(self, states: Floats) -> Floats:
        """Compared states in their units, (K, d)."""
        return states[:, self.columns] / self.scale[self.columns]


@dataclass
class Known:
    """The attractors that are known, and their points and cells as arrays for the kernel."""

    measure: Measure
    attractors: list[Attractor] = field(default_factory=list)
    _keys: Integers = field(default_factory=lambda: np.zeros(_CELLS, np.int64))
    _owner: Integers = field(default_factory=lambda: np.zeros(_CELLS, np.int64))
    _n_cells: int = 0
    _cycles: list[tuple[Floats, float, int]] = field(default_factory=list)

    @classmethod
    def of(
        cls, measure: Measure, attractors: list[Attractor], keys: Integers, owner: Integers
    ) -> Known:
        """Attractors that were known before, with their table of cells."""
        known = cls(measure)
        for attractor in attractors:
            known.add(attractor)
        known._keys, known._owner = keys, owner
        known._n_cells = int(np.count_nonzero(owner))
        return known

    @property
    def cells(self) -> tuple[Integers, Integers]:
        """The table of cells: a key and the number of its attractor, 0 where a place is empty."""
        return self._keys, self._owner

    def add(self, attractor: Attractor) -> int:
        """Add an attractor; returns its number, from 1 on."""
        self.attractors.append(attractor)
        number = len(self.attractors)
        if attractor.is_cycle:
            points = self.measure.scaled(attractor.points)
            self._cycles.append((points, attractor.radius, number))
        else:
            self.add_cells(self.measure.keys(attractor.points), number)
        return number

    def add_cells(self, keys: Integers, number: int) -> int:
        """Give cells to an attractor; returns how many are new."""
        while 2 * (self._n_cells + keys.size) > self._keys.size:
            old, owner = self._keys, self._owner
            self._keys = np.zeros(2 * old.size, np.int64)
            self._owner = np.zeros(2 * old.size, np.int64)
            for each in np.unique(owner[owner > 0]):
                fill_cells(old[owner == each], each, self._keys, self._owner)
        new = int(fill_cells(keys, number, self._keys, self._owner))
        self._n_cells += new
        return new

    def landmarks(self) -> Landmarks:
        """What the kernel needs; a copy that later attractors do not change."""
        d = self.measure.columns.size
        points = [np.zeros((0, d))]
        radius, label, following = [np.zeros(0)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        total = 0
        for cycle, size, number in self._cycles:
            p = len(cycle)
            points.append(cycle)
            radius.append(np.full(p, size))
            label.append(np.full(p, number, np.int64))
            following.append(total + (np.arange(p) + 1) % p)
            total += p
        return Landmarks(
            columns=self.measure.columns,
            scale=self.measure.scale[self.measure.columns],
            cell=self.measure.cell,
            points=np.concatenate(points),
            radius=np.concatenate(radius),
            label=np.concatenate(label),
            following=np.concatenate(following),
            keys=self._keys.copy(),
            owner=self._owner.copy(),
            in_cycle=IN_CYCLE,
            in_set=IN_SET,
        )

    def cycles(self) -> KnownCycles:
        """The cycles that are known, for runs that confirm them."""
        return KnownCycles.of(self.attractors, self.measure)

    def same_cycle(self, attractor: Attractor, close: float) -> int:
        """Number of the cycle that has the same points, 0 for none."""
        points = self.measure.scaled(attractor.points)
        for i, other in enumerate(self.attractors):
            if other.period != attractor.period:
                continue
            theirs = self.measure.scaled(other.points)
            distance = np.abs(points[:, None] - theirs[None]).max(axis=2)
            if np.all(distance.min(axis=1) <= close):
                return i + 1
        return 0

    def same_set(self, states: Floats) -> int:
        """Number of the set among whose points some states lie as its own points do, 0 for none.

        Where a set has more cells than points, two parts of it share few cells. The distance from
        each point to the nearest one of the other part does not depend on cells.
        """
        from scipy.spatial import cKDTree

        new = self.measure.scaled(states)
        for i, other in enumerate(self.attractors):
            if other.is_cycle:
                continue
            known = self.measure.scaled(other.points)
            count = min(len(new), len(known))
            early, late = known[: count // 2], known[count // 2 : count]
            within = np.median(cKDTree(early).query(late)[0])
            there = np.median(cKDTree(early).query(new[: count // 2])[0])
            back = np.median(cKDTree(new[: count // 2]).query(late)[0])
            if max(there, back) <= _AS_NEAR * within:
                return i + 1
        return 0

    def owners(self, states: Floats) -> Integers:
        """Set to which the cell of each state belongs, 0 for none; (K,)."""
        marks = self.landmarks().replace(
            points=np.zeros((0, self.measure.columns.size)), radius=np.zeros(0), in_set=1
        )
        visits = new_visits(len(states))
        visit(np.ascontiguousarray(states[:, None, :]), 1, marks, visits)
        return visits.label


def new_visits(count: int) -> Visits:
    """Lanes that have visited nothing yet."""
    return Visits(
        candidate=np.zeros(count, np.int64),
        point=np.full(count, -1, np.int64),
        score=np.zeros(count, np.int64),
        label=np.zeros(count, np.int64),
        needed=np.zeros(count, np.int64),
    )


def share_of_new(keys: Integers, last: int) -> float:
    """Part of the last images that lie in cells where the lane has not been before; keys (K,)."""
    _, first = np.unique(keys, return_index=True)
    return float(np.count_nonzero(first >= keys.size - last)) / last
