"""Basins by sharing each cell among the cells to which its points go."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_options import Search
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    UNSETTLED,
    AttractorSearch,
    Settled,
)
from nonsmooth.analysis.basins.cell_cycles import cycles_of
from nonsmooth.analysis.basins.cell_labels import NOT_COMPUTED
from nonsmooth.analysis.basins.cell_mapping import ENDS
from nonsmooth.analysis.basins.cell_points import CellPoints
from nonsmooth.analysis.basins.cell_shares import closed_classes, end_shares, transitions
from nonsmooth.analysis.basins.changed_labels import DOUBLINGS, SETTLED, Changes
from nonsmooth.analysis.basins.found_basins import Basins, search_from
from nonsmooth.analysis.basins.region import Grid
from nonsmooth.runs.progress import Progress

__all__ = ["by_cell_shares"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MEMBERS = 16  # cells of a class, or that go nowhere, that are followed by the exact map
_ROUNDS = 4  # of looking for attractors where points have come to, after each doubling
_FIRST_CHAIN = 4  # iterates of a cell; chains of fewer are only looked at for attractors
_AT_ONCE = 256  # starts that are followed together


def by_cell_shares(
    chosen: Any,
    grid: Grid,
    how: Search,
    threads: int,
) -> Basins:
    """Map points of every cell, and follow the chain of cells that this makes."""
    cells = CellPoints(grid, lambda: chosen.runner(how.tolerance), threads)
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
            return Basins([], Settled(nothing, np.zeros_like(nothing)), False)
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
        self._exact = np.full(count, NOT_COMPUTED)  # labels of the states that stand for cells

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
        settled = Settled(self.label, np.zeros(self.label.size, np.int64))
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
            self._exact[new] = self.search.settle(self.cells.states[new]).label

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
