"""Visits of lanes to attractors, against the same rules written plainly."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.engine.attractors import Landmarks, Visits, cell_keys, fill_cells, visit

IN_CYCLE, IN_SET, MISS = 3, 8, 10


def _marks(cells: np.ndarray, cell: float) -> Landmarks:
    """A cycle of three points, number 1, and a set of cells, number 2; two of three states."""
    columns = np.array([0, 2])
    keys, owner = np.zeros(64, np.int64), np.zeros(64, np.int64)
    fill_cells(cell_keys(cells, columns, np.array([2.0, 0.5]), cell), 2, keys, owner)
    return Landmarks(
        columns, np.array([2.0, 0.5]), cell, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        np.full(3, 0.1), np.ones(3, np.int64), np.array([1, 2, 0]), keys, owner, IN_CYCLE, IN_SET,
    )  # fmt: skip


def _visits(count: int) -> Visits:
    zeros = [np.zeros(count, np.int64) for _ in range(5)]
    zeros[1] -= 1
    return Visits(*zeros)


def _plainly(states: np.ndarray, cells: np.ndarray, cell: float) -> tuple[int, int]:
    """Label of a lane and the image at which it is known."""
    known = {tuple(np.floor(c[[0, 2]] / [2.0, 0.5] / cell).astype(int)) for c in cells}
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    candidate, before, score = 0, -1, 0
    for k, state in enumerate(states, start=1):
        scaled = state[[0, 2]] / [2.0, 0.5]
        distance = np.linalg.norm(points - scaled, axis=1)
        point = int(distance.argmin()) if distance.min() <= 0.1 else -1
        if point >= 0:
            going_on = before >= 0 and point == (before + 1) % 3 and candidate == 1
            found = 1
        else:
            found = 2 if tuple(np.floor(scaled / cell).astype(int)) in known else 0
            if found == 0 and before < 0:
                score = max(0, score - MISS)
                continue
            going_on = before < 0 and found == candidate
        score = score + 1 if going_on else 1
        candidate, before = found, point
        if found and score >= (IN_CYCLE if point >= 0 else IN_SET):
            return found, k
    return 0, 0


@pytest.mark.parametrize("seed", range(40))
def test_visits_follow_the_rules(seed: int) -> None:
    generator = np.random.default_rng(seed)
    cell = 0.25
    cells = generator.uniform(-2, 2, (30, 3))
    cycle = np.array([[0.0, 7.0, 0.0], [2.0, -3.0, 0.0], [0.0, 1.0, 0.5]])
    lanes, images = 8, 40
    states = np.empty((lanes, images, 3))
    for lane in range(lanes):
        for k in range(images):
            kind = generator.integers(4) if lane else 0
            if kind == 0:  # mostly in the order of the cycle
                states[lane, k] = cycle[k % 3] + generator.normal(0, 0.03, 3)
            elif kind == 1:
                states[lane, k] = cycle[generator.integers(3)]
            elif kind == 2 or lane % 2:
                states[lane, k] = cells[generator.integers(30)]
            else:
                states[lane, k] = generator.uniform(-3, 3, 3)
    visits = _visits(lanes)
    marks = _marks(cells, cell)
    for first in range(0, images, 7):  # in blocks, as in use
        visit(states[:, first : first + 7], first + 1, marks, visits)
    expected = [_plainly(one, cells, cell) for one in states]
    assert list(zip(visits.label.tolist(), visits.needed.tolist(), strict=True)) == expected


def test_cells_of_states_that_are_not_finite_have_no_key() -> None:
    states = np.array([[np.nan, 0.0], [np.inf, 0.0], [1e300, 0.0], [0.5, 0.0], [-0.5, 0.0]])
    keys = cell_keys(states, np.array([0, 1]), np.ones(2), 0.1)
    assert keys[:3].tolist() == [0, 0, 0]
    assert len({*keys[3:].tolist(), 0}) == 3


def test_a_cell_stays_with_its_first_owner() -> None:
    keys, owner = np.zeros(8, np.int64), np.zeros(8, np.int64)
    assert fill_cells(np.array([5, 13, 21]), 1, keys, owner) == 3  # all for one place
    assert fill_cells(np.array([13, 4]), 2, keys, owner) == 1
    found = dict(zip(keys.tolist(), owner.tolist(), strict=True))
    assert (found[5], found[13], found[21], found[4]) == (1, 1, 1, 2)
