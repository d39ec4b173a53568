"""Two relays that act on one equation: crossed, slid along one by one, and both at once."""

import numpy as np
import pytest

import nonsmooth as ns


def masses(spring: float, friction: float) -> ns.System:
    """x'' = -spring sgn(x) - friction sgn(x')."""
    return ns.System(
        states=["x", "v"],
        parameters={"spring": spring, "friction": friction},
        equations={"x": "v", "v": "-spring*sign(x) - friction*sign(v)"},
    )


def test_a_mass_that_stops_where_its_spring_is_weaker_than_friction():
    """v' = 0.7 until v = 0 at t = 1/0.7, where x = 1 - 1/1.4, and 0.3 does not move it on."""
    run = ns.simulate(masses(0.3, 1.0), {"x": 1.0, "v": -1.0}, t_end=20.0)
    assert run["event_kind"].values.tolist() == ["start", "slide_entry"]
    assert run["event_time"].values[1] == pytest.approx(1 / 0.7, rel=1e-15)
    assert run["end_state"].values == pytest.approx([1 - 1 / 1.4, 0.0], rel=1e-14)


def test_a_mass_whose_spring_is_as_strong_as_friction():
    """v' = 0 until x = 0 at t = 1, then 2 until v = 0 at x = -1/4, where all forces cancel."""
    run = ns.simulate(masses(1.0, 1.0), {"x": 1.0, "v": -1.0}, t_end=20.0)
    assert run["event_time"].values == pytest.approx([0.0, 1.0, 1.5], rel=1e-15)
    assert run["end_state"].values == pytest.approx([-0.25, 0.0], abs=1e-15)


def test_a_mass_that_winds_itself_into_the_meeting_of_both_surfaces():
    """From x = 1 at rest v' = -1/2 for 2, then 3/2 for 2/3 until rest at x = -1/3.

    Each half turn is a third of the one before, and takes 1/sqrt(3) of its time.
    """
    with pytest.warns(ns.RunWarning, match="winds itself into the meeting of two surfaces"):
        run = ns.simulate(masses(1.0, 0.5), {"x": 1.0}, t_end=20.0)
    assert run.attrs["status"] == "event_limit"
    switches = run["event_time"].values[1:5]
    longer = (2 + 2 / 3) / np.sqrt(3)
    assert switches == pytest.approx(
        [2, 2 + 2 / 3, 2 + 2 / 3 + 2 / np.sqrt(3), 2 + 2 / 3 + longer], rel=1e-14
    )
    assert run["event_time"].values[-1] == pytest.approx(
        (2 + 2 / 3) / (1 - 1 / np.sqrt(3)), rel=1e-14
    )


def test_sliding_along_one_surface_and_then_along_both():
    """From (-0.2, 0.3): x' = 0.9 to x = 0 at 2/9, y slides with w = -1/10 at y' = -0.38, to 0.

    There 0.3 - w - 0.4 u = 0 and 0.1 - 0.5 u - 0.2 w = 0 give u = 2/21 and w = 11/42.
    """
    system = ns.System(
        states=["x", "y"],
        equations={
            "x": "0.3 - sign(x) - 0.4*sign(y)",
            "y": "0.1 - 0.5*sign(y) - 0.2*sign(x)",
        },
        outputs={"w": "sign(x)", "u": "sign(y)"},
    )
    first = 2 / 9
    second = first + (0.3 - 0.2 * first) / 0.38
    run = ns.simulate(system, {"x": -0.2, "y": 0.3}, times=[0.5, 3.0])
    assert run["event_kind"].values.tolist() == ["start", "slide_entry", "slide_entry"]
    assert run["event_time"].values == pytest.approx([0.0, first, second], rel=1e-14)
    assert run["w"].values == pytest.approx([-0.1, 11 / 42], rel=1e-13)
    assert run["u"].values == pytest.approx([1.0, 2 / 21], rel=1e-13)
    assert run["end_state"].values == pytest.approx([0.0, 0.0], abs=1e-15)
