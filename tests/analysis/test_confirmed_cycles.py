"""Starts that pass near a cycle, and those that converge to it."""

from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.basins.attractor_search import SearchOptions, find_attractors
from nonsmooth.analysis.basins.by_recurrences import label_starts
from nonsmooth.analysis.basins.recurrences import Known, KnownCycles
from nonsmooth.analysis.basins.region import read_box
from nonsmooth.runs.of_system import map_of

MOLE = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.56)
REGION = {"p": (-1.0, 0.0), "y": (-0.75, 0.75)}
SETTLED = 3000  # periods after which motions that converge to a cycle are at it


@pytest.fixture(scope="module")
def found():
    """The mole's cycles of 4 and 24 periods beside chaos."""
    chosen = map_of(MOLE, None, 1e-12, "attractors", states_only=True)
    how = SearchOptions(samples=300, seed=0, cells=64, longest=10_000, record=20_000, match=1e-6,
                 tolerance=1e-12)  # fmt: skip
    return chosen, find_attractors(chosen, read_box(MOLE, REGION, None), how)


def starts():
    p, y = np.meshgrid(np.linspace(-1, 0, 20), np.linspace(-0.75, 0.75, 20))
    states = np.zeros((p.size, 4))
    states[:, 0], states[:, 1] = p.ravel(), y.ravel()
    return states


def distance_after(cycle, states):
    """How far motions are from a cycle once they have settled, in p and y."""
    run = ns.ensemble(
        MOLE, {"p": states[:, 0], "y": states[:, 1]}, transient=SETTLED, record=1, threads=1
    )
    ends = np.stack([run[name].values[:, 0] for name in ("p", "y")], axis=1)
    return np.abs(ends[:, None] - cycle.points[None, :, :2]).max(axis=2).min(axis=1)


@pytest.mark.slow
def test_balls_that_are_too_large_capture_nothing(found):
    """With balls of a fifth of the spread chaos passes through three of them in order."""
    chosen, search = found
    measure = search.known.measure
    known = Known(measure)
    for one in search.known.attractors:
        known.add(replace(one, radius=0.2) if one.is_cycle else one)
    states = starts()
    settled, complete = label_starts(
        lambda cells: states[cells], len(states), known.landmarks(), known.cycles(),
        lambda: chosen.runner(1e-12), longest=1000, threads=1, store=None, protocol={},
    )  # fmt: skip
    assert complete
    periods = [one.period for one in known.attractors]
    assert {4, 24} <= set(periods)
    for number, one in enumerate(known.attractors, start=1):
        chosen_cells = settled.label == number
        if one.is_cycle and np.any(chosen_cells):
            # 2000 periods shrink a distance of 0.2 by 0.9173 each 24: to 2e-4; chaos stays 0.1 away
            assert distance_after(one, states[chosen_cells]).max() < 1e-3


def test_cycles_that_attract_slowly_are_counted(found):
    _, search = found
    (cycle,) = (one for one in search.known.attractors if one.period == 4)
    slow = replace(cycle, multipliers=np.array([0.9999, 0.0, 0.0], complex))
    label = np.array([1, 1, 2, 0, -1])
    for attractors, count in (([cycle, slow], 1), ([slow, cycle], 2), ([cycle, cycle], 0)):
        assert KnownCycles.of(attractors, search.known.measure).unconfirmed(label) == count


def test_cells_rest_on_runs():
    grid = {"p": np.linspace(-1, 0, 15), "y": np.linspace(-0.75, 0.75, 15)}
    basins = ns.basins_of_attraction(MOLE, grid, samples=200, threads=1)
    assert basins.attrs["unconfirmed_cells"] == 0
    assert "confirmed" not in basins.attrs["message"]
