"""A picture for print is drawn of results that are there, and of calls where there are none."""

from dataclasses import replace

import pytest

import nonsmooth as ns
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.printing import printed
from nonsmooth.explorer.tasks import TASKS

WALL = replace(
    opening("impact_oscillator"), columns=16, transient=20, record=10, cells=8,
    region=(-2.0, 1.0, -1.0, 1.0),
)  # fmt: skip
VERBS = {"diagram": "bifurcation_diagram", "plane": "basins_of_attraction"}


@pytest.mark.parametrize("pane", list(VERBS))
def test_what_is_on_the_screen_is_not_computed_again(pane, monkeypatch):
    *_, last = TASKS[pane](WALL)
    fresh = printed(WALL, pane, ".png", {})

    def refuse(*args, **options):
        raise AssertionError("it was there")

    monkeypatch.setattr(ns, VERBS[pane], refuse)
    assert printed(WALL, pane, ".png", last["result"]) == fresh
    with pytest.raises(AssertionError, match="it was there"):
        printed(WALL, pane, ".png", {})


def test_columns_that_came_in_pieces_make_the_whole_diagram():
    *_, last = TASKS["diagram"](WALL)
    known = ns.bifurcation_diagram(
        WALL.system, WALL.over, last["result"]["diagram"]["parameter"].values,
        transient=20, record=10,
    )  # fmt: skip
    assert last["result"]["diagram"]["parameter"].to_index().is_monotonic_increasing
    assert last["result"]["diagram"].sizes == known.sizes
    assert (last["result"]["diagram"][WALL.shown] == known[WALL.shown]).all()
