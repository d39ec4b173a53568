"""Bifurcation pictures as they are drawn: lines that break at jumps, legends that can be read."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.plot.branch_curves import event_passes_strobe


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def branch_of_two_periods(event: list[float]) -> xr.Dataset:
    """Orbits of two periods, each a unit of time, with one event at the times given."""
    count = len(event)
    return xr.Dataset(
        {
            "length": ("point", np.full(count, 2.0)),
            "leg_time": (("point", "leg"), np.column_stack([np.zeros(count), event])),
        },
        attrs={"period": 2},
    )


@pytest.mark.parametrize(
    ("event", "first", "second"),
    [
        ([0.8, 0.9, 1.1, 1.2], [False, False, False], [False, True, False]),
        ([0.2, 0.1, 1.9, 1.8], [False, True, False], [False, False, False]),
        ([1.9, 1.99, 0.05, 0.1], [False, True, False], [False, False, False]),
        ([0.9, 1.0, 1.1, 1.2], [False, False, False], [True, True, False]),
    ],
)
def test_an_event_passes_one_of_two_strobes(event, first, second):
    """At a strobe itself it counts as on either side."""
    branch = branch_of_two_periods(event)
    assert event_passes_strobe(branch).tolist() == first
    assert event_passes_strobe(branch, 1).tolist() == second


def lines_of_branches(ax) -> list[np.ndarray]:
    return [
        np.asarray(line.get_ydata(), float)
        for line in ax.lines
        if str(line.get_gid()).startswith("branch ")
    ]


@pytest.mark.slow
def test_no_line_leads_over_the_jump_of_a_bouncing_ball():
    """Its two orbits meet at pi (1 - r)/(1 + r), where the ball bounces just at the strobe.

    There it turns its velocity from -pi to pi. All else along the branch changes little by little:
    the velocity at the strobe is -pi + t or pi - t, for an impact t beside it.
    """
    picture = ns.bifurcation_picture(
        ns.models.bouncing_ball(r=0.5),
        "Gamma",
        (1.0, 1.3),
        {"y": (0.0, 4.0), "v": (-3.0, 3.0)},
        columns=4,
        samples=8,
        searches=1,
        longest=1,
    )
    drawn = lines_of_branches(ns.plot.bifurcation_picture(picture, "v"))
    steps = np.concatenate([np.abs(np.diff(each)) for each in drawn])
    assert max(np.nanmax(each) for each in drawn) > 2.5  # the unstable orbit, and the stable one
    assert min(np.nanmin(each) for each in drawn) < -2.5
    assert np.nanmax(steps) < 1.0


@pytest.mark.slow
def test_a_legend_names_the_attractors_with_most_of_the_starts():
    """x rests at each whole number, with the starts that are nearest: 11 of them, fewer at ends."""
    steps = ns.System(
        states=["x"], period=1.0, parameters={"p": 0.0}, equations={"x": "p - sin(2*pi*x)"}
    )
    picture = ns.bifurcation_picture(
        steps, "p", (-0.01, 0.01), {"x": (-5.2, 5.2)}, columns=2, samples=64, searches=0, longest=1
    )
    assert picture.sizes["attractor"] == 11
    ax = ns.plot.bifurcation_picture(picture, "x")
    told = [text.get_text() for text in ax.get_legend().get_texts()]
    named = [text for text in told if text.startswith("attractor ")]
    assert len(named) == 7 and "and 4 with fewer starts" in told
    shares = picture["fraction"].fillna(0.0).mean("parameter")
    least = min(float(shares.sel(attractor=int(text.split()[1]))) for text in named)
    assert np.count_nonzero(shares.values > least) <= 7
    dots = [line for line in ax.lines if str(line.get_gid()).startswith("attractor ")]
    assert len(dots) == 11  # all are drawn
