"""Tasks of a page where motions end early, ranges go downwards, and columns are few."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from nonsmooth.explorer import calls
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.tasks import TASKS
from nonsmooth.models.ready_made import ready_made

WALL = replace(
    opening("impact_oscillator"), columns=20, transient=5, record=4, length=3.0, leave_out=0.0
)
RUNAWAY = 'states = ["x", "v"]\nperiod = "2"\n[parameters]\nc = 1.0\n[equations]\n'
RUNAWAY += 'x = "v"\nv = "c*x**3 + sin(pi*t)"\n'


def test_columns_that_end_early_join_those_that_do_not():
    """Of the first of them no point came, so the parts have points in different numbers."""
    view = replace(WALL, between=(-1.0, 0.9))
    *_, last = TASKS["diagram"](view)
    assert (last["done"], last["ended"]) == (20, ["refused"]) and 0 < last["n_ended"] < 20
    (call,) = calls.diagram(view)
    whole = calls.computed([call], {"system": view.system})["diagram"]
    for name, each in whole.data_vars.items():  # the same as in one piece, types and all
        xr.testing.assert_equal(last["result"]["diagram"][name].variable, each.variable)
        assert last["result"]["diagram"][name].dtype == each.dtype


def test_a_diagram_may_have_one_column_where_all_lie_at_one_value():
    *_, last = TASKS["diagram"](replace(WALL, columns=1))
    assert last["done"] == last["count"] == 1


def test_a_branch_reaches_over_a_diagram_that_goes_downwards():
    up = calls.branch(replace(WALL, between=(1.0, 3.0)))[0].arguments[2]
    down = calls.branch(replace(WALL, between=(3.0, 1.0)))[0].arguments[2]
    assert down == up and np.diff(down)[0] > 0.0


def test_a_motion_that_runs_away_has_no_orbit_near_its_end():
    view = replace(opening(text=RUNAWAY), turn=-1, branch=True)
    (piece,) = TASKS["orbit"](view)
    assert piece == {
        "turn": 0, "message": "the motion ends early, so there is no orbit near its end",
    }  # fmt: skip


@pytest.mark.parametrize("name", sorted(ready_made()))
def test_every_slider_of_a_ready_made_machine_has_words(name):
    system = opening(name).system
    assert not [each for each in system.parameters if not system.describe.get(each)]
