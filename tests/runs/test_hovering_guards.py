"""A guard that rounding leaves open keeps no other guard from firing."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("level", [100.1, 100.1 - 1e-14, 100.1 + 1e-14])
def test_impacts_beside_a_guard_that_decays_into_rounding(order, level):
    """q + v - 100.1 falls to a few 1e-14 and stays: flagged or fired, but no impact is lost."""
    exits = [
        Exit("p", reset={"y": "-0.9*y"}, name="impact"),
        Exit(f"q + v - {level!r}", to="stop", name="touch"),
    ][::order]
    flow = {"p": "y", "y": "-0.05", "q": "-10*q", "v": "0"}
    ball = System(states=list(flow), modes={"m": Mode(flow, exits=exits)})
    run = ns.simulate(ball, {"p": 1.0, "q": 0.5, "v": 100.1}, times=np.linspace(0, 60, 7))
    assert run.attrs["status"] in ("completed", "stopped")
    assert float(run["p"].min()) > -1e-9
    assert run["state_before"].sel(state="p").min() > -1e-9
    hits = run["event_time"].values[run["event_name"].values == "impact"]
    # falls from 1, then bounces with 0.9 of the speed before
    first = np.sqrt(2 / 0.05)
    expected = first * (1 + 2 * np.concatenate([[0], np.cumsum(0.9 ** np.arange(1, 40))]))
    expected = expected[expected < float(run["time"][-1])]
    if run.attrs["status"] == "completed":
        assert hits == pytest.approx(expected, rel=1e-12)
        assert run.attrs["n_uncertain"] > 0
    assert not np.any(run["event_kind"].values[run["certified"].values] == "graze")


def test_an_open_root_waits_for_an_earlier_certain_one():
    """A shallow dip of one guard at t = 1 is decided at 1; another guard falls before, at 0.5."""
    flow = {"x": "1"}
    exits = [
        Exit("(x - 1)**2 + 1e-17 - 1e-17", name="touch", to="stop"),
        Exit("0.5 - x", to="stop"),
    ]
    line = System(states=["x"], modes={"m": Mode(flow, exits=exits)})
    run = ns.simulate(line, {"x": 0.0}, t_end=2.0)
    assert run["event_time"].values[-1] == pytest.approx(0.5, abs=1e-14)


def test_a_level_equal_to_a_plateau():
    """A guard that becomes exactly zero and stays does not end the motion of the others."""
    wall = Exit("x + 1", reset={"v": "-v"}, name="wall")
    plateau = Exit("q", to="stop", name="plateau")
    mass = System(
        states=["x", "v", "q"],
        modes={"m": Mode({"x": "v", "v": "-x", "q": "-50*q"}, exits=[plateau, wall])},
    )
    run = ns.simulate(mass, {"x": 0.0, "v": 2.0, "q": 1.0}, t_end=40.0)
    walls = run["event_time"].values[run["event_name"].values == "wall"]
    # x = 2 sin t reaches -1 at 7 pi/6 and comes back as 2 sin from -1: every 4 pi/3
    expected = 7 * np.pi / 6 + 4 * np.pi / 3 * np.arange(9)
    assert walls == pytest.approx(expected[expected < float(run["time"][-1])], rel=1e-12)
