"""Signs that exclude each other, against a linear programme, and the cells that are left."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.system.cells.exclusions import Inequality, excluded
from nonsmooth.system.model.explain import explanation

TWO_STOPS = {"x": "v", "v": "-x - k*max(x - e, 0) + k*max(-x - e, 0)"}


def by_linear_programme(rows: np.ndarray) -> bool:
    """Whether no point has all sums positive, the last quantity being one.

    Sums may be scaled, so that all of them are one at least where they are positive.
    """
    whole = np.vstack([rows, np.eye(rows.shape[1])[-1]])
    free = [(None, None)] * rows.shape[1]
    found = linprog(np.zeros(rows.shape[1]), -whole, -np.ones(len(whole)), bounds=free)
    return found.status == 2  # infeasible


@pytest.mark.parametrize("seed", range(60))
def test_against_a_linear_programme(seed):
    generator = np.random.default_rng(seed)
    count, width = generator.integers(2, 7), generator.integers(2, 5)
    rows = generator.integers(-3, 4, (count, width))
    names = [*range(width - 1), ()]
    inequalities = [
        Inequality({key: Fraction(int(value)) for key, value in zip(names, row, strict=True)}, True)
        for row in rows
    ]
    assert excluded(inequalities) == by_linear_programme(rows.astype(float))


def stops(require=(), e=0.5):
    return ns.System(
        name="stops",
        states=["x", "v"],
        parameters={"e": e, "k": 3.0},
        require=dict.fromkeys(require, "a gap"),
        equations=TWO_STOPS,
    )


def cells(system):
    return list(system.structure.modes)


def test_no_cell_beyond_both_stops():
    """With e > 0 no x is above e and below -e; with e of any sign there may be one."""
    assert sorted(cells(stops())) == ["flow[++]", "flow[+-]", "flow[-+]", "flow[--]"]
    for require in ("e > 0", "0 <= e", "e >= 0.1", "2*e - 1 >= -0.5"):
        assert cells(stops([require])) == ["flow[++]", "flow[-+]", "flow[--]"], require
    assert len(cells(stops(["e < 3"]))) == 4


def test_numbers_exclude_as_requirements_do():
    text = "-x - 3*max(x - 1, 0) + 3*max(-x - 1, 0)"
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": text})
    assert len(cells(system)) == 3


def test_the_motion_is_the_same():
    """Every event passes the same surface, whether the impossible cell is there or not."""
    ends = []
    for require in ((), ("e > 0",)):
        run = ns.simulate(stops(require), {"x": 2.0}, t_end=30.0)
        assert run.attrs["n_events"] > 20
        ends.append(run.isel(time=-1))
    # a free motion forgets nothing: rounding of 1e-16 in each of some hundred segments
    assert abs(float(ends[0]["x"] - ends[1]["x"])) < 1e-11


def test_friction_where_cells_are_left_out():
    """Surfaces on which motion slides are found beside cells that others exclude."""
    system = ns.System(
        states=["x", "v"],
        parameters={"e": 0.5},
        require={"e > 0": "a gap"},
        equations={"x": "v", "v": "-x - sign(v) - 9*max(x - e, 0) + 9*max(-x - e, 0)"},
    )
    assert len(system.structure.running) == 6 + 3
    run = ns.simulate(system, {"x": 3.0}, t_end=30.0)
    assert abs(float(run["v"][-1])) < 1e-12  # it sticks at last


def test_explanation_tells_possible_cells_and_folds_what_repeats():
    text = explanation(stops())
    assert "mode flow: 3 cells, and 1 that cannot be with these values" in text
    assert "flow[+-]" not in text
    assert "cells flow[++], flow[--]: exact linear" in text
    assert text.count("natural motions") == 2
    assert "mode flow: 3 cells\n" in explanation(stops(["e > 0"]))
    # stops behind each other: a band in which both press, and none beyond both
    assert "flow[+-]" in explanation(stops(e=-0.5))


def test_all_cells_alike_are_told_once():
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 0.1*sign(x - 1)"})
    assert "every cell: exact linear" in explanation(system)
