"""Basins by shares: which part of a cell goes to each other cell, and to each attractor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    AttractorSearch,
    SearchOptions,
    SettledStarts,
)
from nonsmooth.analysis.basins.by_cell_mapping import (
    DOUBLINGS,
    ENDS,
    NOWHERE,
    REFUSED,
    SETTLED,
    CellImages,
    Changes,
    cycles_of,
    map_points,
)
from nonsmooth.analysis.basins.by_recurrences import Basins, search_from
from nonsmooth.analysis.basins.folded_runner import runner_within_turns
from nonsmooth.analysis.basins.recurrences import Known, new_visits
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.engine.attractors import visit
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.progress import Progress

__all__ = ["by_cell_shares", "closed_classes", "end_shares", "transitions"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_SIDE = 3  # points along each state of a cell

_MEMBERS = 16  # cells of a class, or that go nowhere, that are followed by the exact map
_ROUNDS = 4  # of looking for attractors where points have come to, after each doubling
_FIRST_CHAIN = 4  # iterates of a cell; chains of fewer are only looked at for attractors
_AT_ONCE = 256  # starts that are followed together


def transitions(source: Integers, image: Integers, count: int) -> sparse.csr_array:
    """Matrix of the shares of each cell's points that go to each cell, (count, count).

    shapes: source, image (K,), a pair for each point
    """
    points = np.bincount(source, minlength=count).astype(float)
    share = 1.0 / points[source]
    return sparse.csr_array(sparse.coo_array((share, (source, image)), shape=(count, count)))


def closed_classes(matrix: sparse.csr_array) -> Integers:
    """Number of the closed class in which each cell lies, -1 where it is left for good.

    A class is closed where no point of it leaves it; a cell without points is in none.
    """
    count, number = connected_components(matrix, directed=True, connection="strong")
    rows, columns = matrix.nonzero()
    leaves = np.zeros(count, bool)
    leaves[number[rows[number[rows] != number[columns]]]] = True
    leaves[number[np.diff(matrix.indptr) == 0]] = True
    kept = np.cumsum(~leaves) - 1
    return np.where(leaves[number], -1, kept[number]).astype(np.int64)


def end_shares(matrix: sparse.csr_array, ends: Floats) -> Floats:
    """Probability of each end for every cell.

    ``ends`` (N, E) has it for the cells of closed classes, and zero elsewhere: (I - Q) X = R with Q
    the chain among the other cells. What goes nowhere is missing from the sum.
    """
    passing = np.flatnonzero(ends.sum(axis=1) == 0.0)
    shares = ends.copy()
    if passing.size:
        rows = matrix[passing]
        inner = sparse.eye_array(passing.size) - rows[:, passing]
        shares[passing] = splu(sparse.csc_array(inner)).solve(rows @ ends)
    return shares


class CellPoints:
    """Points of every cell and where they are after some iterates, which may be doubled.

    A cell none of whose points is admissible has the first image that lies in it as its point.
    """

    def __init__(self, grid: Grid, make_runner: Callable[[], Any], threads: int) -> None:
        self.grid, self.iterates = grid, 0
        self.states = grid.states(np.arange(grid.size))  # that stand for the cells
        self.centre = np.full(grid.size, -1, np.int64)  # number of the point that does
        self.source = np.zeros(0, np.int64)  # cell of each point
        self.image = np.zeros(0, np.int64)  # cell in which it lies now
        self.ending = np.zeros(0, np.int64)  # status of its motion where that ended, else 0
        self.owner = np.zeros(0, np.int64)  # attractor at which it is now, 0 for none
        self._seen = np.zeros(0, np.int64)  # at which it was before
        self._points = np.zeros((0, self.states.shape[1]))
        self._modes = np.zeros(0, np.int64)
        self._make_runner, self._threads = make_runner, threads

    def double(self) -> bool:
        """Map on for as many iterates again, once at first; False after an interruption."""
        if self.iterates == 0:
            return self._begin()
        # what is at an attractor for the second time stays there
        here = (self.owner > 0) & (self.owner == self._seen)
        self._seen = self.owner.copy()
        moving = np.flatnonzero((self._modes >= 0) & ~here)
        count, self.iterates = self.iterates, 2 * self.iterates
        points, modes = self._points[moving], SAME - self._modes[moving]
        part, complete = self._mapped(points, modes, count)
        self._points[moving], self._modes[moving] = part.points, part.modes
        self.image[moving], self.ending[moving] = part.image, part.ending
        return complete

    def recognise(self, known: Known) -> None:
        """See which points are at an attractor: in a ball of convergence, or a cell of a set."""
        marks = known.landmarks().replace(in_cycle=1, in_set=1)
        visits = new_visits(len(self._points))
        visit(np.ascontiguousarray(self._points[:, None, :]), 1, marks, visits)
        self.owner = np.where(self._modes >= 0, visits.label, 0)

    def lost(self) -> tuple[Integers, Integers]:
        """Numbers of points at no known attractor, outside the grid and in it."""
        left, outside = (self._modes >= 0) & (self.owner == 0), self.image == NOWHERE
        return np.flatnonzero(left & outside), np.flatnonzero(left & ~outside)

    def come_to(self, some: Integers) -> tuple[Floats, Integers]:
        """Where some points are now, and the modes from which they go on."""
        return self._points[some], SAME - self._modes[some]

    def _begin(self) -> bool:
        self.iterates, count = 1, self.grid.size
        inner = self.grid.inner_states(np.arange(count), _SIDE)
        points, source = (
            inner.reshape(-1, inner.shape[2]),
            np.repeat(np.arange(count), inner.shape[1]),
        )
        middle = np.tile(np.arange(inner.shape[1]) == inner.shape[1] // 2, count)
        complete = True
        while len(points) and complete:
            part, complete = self._mapped(points, np.full(len(points), ANY), 1)
            admitted = np.flatnonzero(part.image != REFUSED)
            # the middle one stands for the cell where a mode admits it
            order = admitted[np.argsort(~middle[admitted], kind="stable")]
            cells, first = np.unique(source[order], return_index=True)
            self.states[cells] = points[order[first]]
            place = np.full(len(points), -1, np.int64)
            place[admitted] = len(self.source) + np.arange(admitted.size)
            self.centre[cells] = place[order[first]]
            self.source = np.concatenate([self.source, source[admitted]])
            self.image = np.concatenate([self.image, part.image[admitted]])
            self.ending = np.concatenate([self.ending, part.ending[admitted]])
            self._points = np.concatenate([self._points, part.points[admitted]])
            self._modes = np.concatenate([self._modes, part.modes[admitted]])
            to = np.flatnonzero(part.image >= 0)
            entered, which = np.unique(part.image[to], return_index=True)
            new = self.centre[entered] < 0
            points, source = part.points[to[which[new]]], entered[new]
            middle = np.ones(len(points), bool)
        self.owner = np.zeros(len(self.source), np.int64)
        self._seen = self.owner.copy()
        return complete

    def _mapped(self, points: Floats, modes: Integers, count: int) -> tuple[CellImages, bool]:
        total = len(points)
        whole = CellImages(
            points.copy(), np.full(total, ANY), np.full(total, NOWHERE, np.int64), points.copy(),
            np.zeros(total, np.int64),
        )  # fmt: skip

        def keep(places: Integers, part: CellImages) -> None:
            for mine, theirs in zip(vars(whole).values(), vars(part).values(), strict=True):
                mine[places] = theirs

        # points outside the grid are mapped on with the others, and so need not be followed
        complete = map_points(
            self.grid, points, modes, count, self._make_runner, self._threads, keep,
            f"points of cells, {self.iterates} iterates", outside=0,
        )  # fmt: skip
        return whole, complete


def by_cell_shares(
    chosen: Any,
    grid: Grid,
    how: SearchOptions,
    threads: int,
) -> Basins:
    """Map points of every cell, and follow the chain of cells that this makes."""
    cells = CellPoints(grid, lambda: runner_within_turns(chosen, how.tolerance, grid), threads)
    shared: _Shares | None = None
    try:
        for _ in range(DOUBLINGS):
            if not cells.double():
                raise KeyboardInterrupt
            if shared is None:
                search = search_from(chosen, cells.states[cells.centre >= 0], how)
                shared = _Shares(cells, search)
            shared.update()
            if shared.is_settled:
                break
        assert shared is not None
        shared.look_closer()
    except KeyboardInterrupt:
        if shared is None:
            nothing = np.full(grid.size, NOT_COMPUTED)
            return Basins([], SettledStarts.of(nothing), False)
        return shared.basins(complete=False)
    return shared.basins(complete=True)


class _Shares:
    """Share of each cell that goes to each attractor, and the labels that follow."""

    def __init__(self, cells: CellPoints, search: AttractorSearch) -> None:
        self.cells, self.search, count = cells, search, cells.grid.size
        self.label = np.full(count, NOT_COMPUTED)
        self.probability = np.full(count, np.nan)
        self.changes = Changes(cells.grid)
        self._nowhere = 1.0  # part of the cells that come to no attractor yet
        # what the states that stand for cells come to
        self._exact = np.full(count, NOT_COMPUTED)
        self._ending = np.zeros(count, np.int64)

    @property
    def is_settled(self) -> bool:
        """Whether further iterates would change little."""
        return self.changes.have_ended(self.cells.iterates)

    def update(self) -> None:
        """Look for attractors after a doubling, and label the cells."""
        cells = self.cells
        self._search()
        self._recognise()
        if cells.iterates < _FIRST_CHAIN:
            return
        before = self.label
        self._follow()
        self._nowhere = float(np.mean(self.label == UNSETTLED))
        self.changes.note(before, self.label, self._nowhere)

    def look_closer(self) -> None:
        """Follow the states of cells that go nowhere, and see who else goes where they go."""
        left = np.flatnonzero(self.label == UNSETTLED)
        with Progress("cells that take longer", left.size) as progress:
            for i in range(0, left.size, _AT_ONCE):
                self._settle(left[i : i + _AT_ONCE])
                progress.update(min(i + _AT_ONCE, left.size))
        self._recognise()
        self._follow()

    def basins(self, complete: bool) -> Basins:
        """What was found."""
        found, cells = self.search.known.attractors, self.cells
        columns = [
            cells.grid.completion.system.states.index(n) for n in cells.grid.completion.given
        ]
        held = [np.unique(cells.grid.cells(one.points[:, columns])) for one in found]
        inside, times = np.unique(
            np.concatenate([np.zeros(0, np.int64), *held]), return_counts=True
        )
        several = int(np.count_nonzero(times[inside >= 0] > 1))
        notes = {
            "iterates_per_cell": cells.iterates,
            "changed_by_doubling": self.changes.last,
            "cells_of_several_attractors": several,
        }
        remarks = []
        if several:
            remarks.append(
                f"cells that hold points of several attractors: {several}; take finer cells"
            )
        if complete and max(self.changes.last, self._nowhere) > SETTLED:
            remarks.append(
                f"after {cells.iterates} iterates per cell {self._nowhere:.2%} of the cells came"
                f" to no attractor, and the last doubling changed {self.changes.last:.2%} of the"
                " labels away from borders; take finer cells, or method='recurrences'"
            )
        ending = np.where(self.label <= UNSETTLED, self._ending, 0)
        ended = np.flatnonzero(cells.ending > 0)
        ending[cells.source[ended]] = cells.ending[ended]
        settled = replace(SettledStarts.of(self.label), ending=ending)
        return Basins(found, settled, complete, self.probability, notes, "; ".join(remarks))

    def _search(self) -> None:
        """Follow cells of cycles of centres, of closed classes, and some that go nowhere."""
        cells, count = self.cells, self.cells.grid.size
        has = cells.centre >= 0
        centre = np.where(has, cells.image[cells.centre], -1)
        some = [cycles_of(centre).first]
        classes = closed_classes(self._matrix(np.zeros(len(cells.source), np.int64), 0))[:count]
        for number in range(int(classes.max(initial=-1)) + 1):
            some.append(_few(np.flatnonzero(classes == number)))
        self._settle(np.unique(np.concatenate(some)))

    def _recognise(self) -> None:
        """See who is at an attractor, and follow some of those who are not.

        Cells may be too coarse for an attractor to have one of its own, or lie elsewhere.
        """
        known = self.search.known
        for _ in range(_ROUNDS):
            before = len(known.attractors)
            self.cells.recognise(known)
            some = np.concatenate([_few(part) for part in self.cells.lost()])
            if some.size:
                self.search.settle(*self.cells.come_to(some))
            if len(known.attractors) == before:
                return
        self.cells.recognise(known)

    def _settle(self, cells: Integers) -> None:
        new = cells[self._exact[cells] == NOT_COMPUTED]
        if new.size:
            found = self.search.settle(self.cells.states[new])
            self._exact[new], self._ending[new] = found.label, found.ending

    def _matrix(self, owner: Integers, found: int) -> Any:
        """Chain of the cells, with more cells that nothing leaves: see `_follow`."""
        count, image = self.cells.grid.size, self.cells.image
        image = np.where(image == ENDS, count + found + 1, np.where(image < 0, count, image))
        image = np.where(owner > 0, count + owner, image)
        sinks = count + np.arange(found + 2)
        return transitions(
            np.append(self.cells.source, sinks), np.append(image, sinks), count + found + 2
        )

    def _follow(self) -> None:
        """Shares of the ends of all chains: nowhere, each attractor, motions that end."""
        cells, count, found = self.cells, self.cells.grid.size, len(self.search.known.attractors)
        matrix = self._matrix(cells.owner, found)
        classes = closed_classes(matrix)[:count]
        ends = np.zeros((count + found + 2, found + 2))
        ends[count:] = np.eye(found + 2)
        closed = np.flatnonzero(classes >= 0)
        if closed.size:
            # members that were not followed have the label of the most of those that were
            votes = np.zeros((int(classes.max()) + 1, found + 2))
            known = closed[self._exact[closed] >= ENDED]
            votes[:, 0] = 0.5  # less than any
            np.add.at(votes, (classes[known], self._exact[known] % (found + 2)), 1.0)
            ends[closed, votes.argmax(axis=1)[classes[closed]]] = 1.0
        shares = end_shares(matrix, ends)[:count]
        label = np.argmax(shares, axis=1)
        # a cell that goes nowhere has the label of its own state where that is known
        own = (label == UNSETTLED) & (self._exact >= ENDED)
        label[own] = self._exact[own] % (found + 2)
        probability = np.take_along_axis(shares, label[:, None], axis=1)[:, 0]
        empty = cells.centre < 0
        self.probability = np.where(empty, np.nan, np.clip(probability, 0.0, 1.0))
        self.label = np.where(label == found + 1, ENDED, label)
        self.label[empty] = INADMISSIBLE


def _few(cells: Integers) -> Integers:
    return cells[:: max(1, cells.size // _MEMBERS)][:_MEMBERS]
