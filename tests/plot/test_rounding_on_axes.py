"""States that are zero but for rounding: drawn as a line at zero, with numbers that can be read."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

SYSTEM = ns.System(
    states=["x", "v", "y", "w"],
    parameters={"a": 1.0, "tiny": 1e-18},
    period="2*pi",
    equations={
        "x": "v",
        "v": "-0.5*x - 0.2*v + a*cos(t)",
        "y": "w",
        "w": "-y - 0.3*w + tiny*cos(t)",
    },
)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """A mass that swings by about two, beside one that hardly moves."""
    return ns.simulate(SYSTEM, periods=30)


def is_at_zero(low: float, high: float) -> bool:
    """Whether an axis is as wide as a part of the state that is not zero, about zero."""
    return 0.05 < high < 0.2 and low == pytest.approx(-high, rel=1e-9)


def test_a_run(run):
    ax = ns.plot.time_history(run, "y")
    assert is_at_zero(*ax.get_ylim())
    ax.get_figure().draw_without_rendering()
    assert ax.yaxis.get_offset_text().get_text() == "" and "10^" not in ax.get_ylabel()
    assert is_at_zero(*ns.plot.phases(run, "y").get_ylim())
    assert ns.plot.time_history(run, ["x", "y"]).get_ylim()[1] > 1.0


def test_a_portrait(run):
    ax = ns.plot.phase_portrait(run, "x", "y")
    assert is_at_zero(*ax.get_ylim()) and ax.get_xlim()[1] > 1.0
    assert is_at_zero(*ns.plot.phase_portrait(run, "y", "x").get_xlim())


def test_a_branch_and_a_diagram():
    orbits = ns.continue_orbit(SYSTEM, "a", (0.8, 1.2))
    assert is_at_zero(*ns.plot.branch(orbits, "y").get_ylim())
    points = ns.bifurcation_diagram(SYSTEM, "a", [0.8, 1.0, 1.2], record=16)
    assert is_at_zero(*ns.plot.bifurcation(points, "y").get_ylim())
    strobes = ns.stroboscopic_map(SYSTEM, record=4)
    assert is_at_zero(*ns.plot.section(strobes, "x", "y").get_ylim())


def test_small_states_are_drawn_as_they_are():
    """What is small altogether, and what is small beside others but far above rounding."""
    small = {"a": 1e-18}
    run = ns.simulate(SYSTEM, periods=5, parameters=small)
    assert ns.plot.time_history(run, "y").get_ylim()[1] < 1e-16
    run = ns.simulate(SYSTEM, periods=5, parameters={"tiny": 1e-12})
    assert 1e-13 < ns.plot.time_history(run, "y").get_ylim()[1] < 1e-10


def test_the_end_of_a_decay_is_drawn_as_it_is():
    """exp(-t) of the start is left, 1e-26 at t = 60, beside states as small at that time."""
    decay = ns.System(states=["x", "y"], equations={"x": "-x", "y": "-y"})
    run = ns.simulate(decay, {"x": 1.0, "y": 1.0}, times=np.linspace(0.0, 61.0, 200))
    assert ns.plot.time_history(run, "x", time_range=(58.0, 61.0)).get_ylim()[1] < 1e-24
