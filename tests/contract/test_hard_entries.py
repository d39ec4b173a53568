"""Entries into modes and onto surfaces that rounding, or a tolerance, makes hard to tell."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


@pytest.mark.parametrize(
    ("relation", "z"), [("y*(y - 0.9*y)", 0.025), ("sin(y)*(y - 0.9*y)", 0.05 * np.sin(0.5))]
)
def test_slaved_state_that_is_nothing_where_a_mode_is_entered(relation, z):
    """z = 0.1*y**2 in both modes, or nearly so: 1e-20 where it is left, and 0.1 at the start.

    The relation of the mode that is left says what z was: its series knows it to 1e-17 only.
    """
    system = System(
        states=["y", "w", "z"],
        modes={
            "before": Mode(
                {"y": "0.25", "w": "1"},
                slaved={"z": relation},
                exits=[Exit("z - 0.5*y - 1e-10", to="behind")],
            ),
            "behind": Mode({"y": "0.25", "w": "0"}, slaved={"z": relation}),
        },
    )
    run = ns.simulate(system, {"y": -1.0}, t_end=6.0)
    assert (run.attrs["status"], run.attrs["certified"]) == ("completed", 1)
    assert run["event_time"].values[1] == pytest.approx(4.0 * (1.0 - 2e-10), rel=1e-15)
    assert float(run["w"][-1]) == pytest.approx(4.0 * (1.0 - 2e-10), rel=1e-14)
    assert float(run["z"][-1]) == pytest.approx(z, rel=1e-13)


def test_slaved_state_that_is_another_one_is_still_refused():
    """z = y**2 before and 1.01 y**2 behind: at y = 1e-5 these are 1e-12 apart."""
    system = System(
        states=["y", "z"],
        modes={
            "before": Mode({"y": "1"}, slaved={"z": "y**2"}, exits=[Exit("1e-5 - y", to="behind")]),
            "behind": Mode({"y": "1"}, slaved={"z": "1.01*y**2"}),
        },
    )
    with pytest.warns(ns.RunWarning, match="inadmissible"):
        run = ns.simulate(system, {"y": -1.0}, t_end=2.0)
    assert run.attrs["status"] == "inadmissible"


@pytest.mark.parametrize("half_width", ["1e-11", "1e-12", "5e-13", "1e-13"])
@pytest.mark.parametrize(("text", "factor"), [("y", 1.0), ("y + 0.7*y", 1.7)])
def test_mode_that_is_left_at_once(text, factor, half_width):
    """Between two roots that the tolerance takes for one, w stays: for so short a time.

    A guard so slow beside its terms is told to rounding, and the event is flagged.
    """
    guard = f"(({text}) - 0.25)**2 - {half_width}**2"
    system = System(
        states=["y", "w"],
        modes={
            "above": Mode({"y": "0.75", "w": "1"}, exits=[Exit(guard, to="below")]),
            "below": Mode({"y": "0.25", "w": "0"}, exits=[Exit(f"-({guard})", to="above")]),
        },
    )
    run = ns.simulate(system, {"y": -1.0}, t_end=4.0)
    assert run.attrs["status"] == "completed"
    between = 2.0 * float(half_width) / factor / 0.25
    assert run.attrs["certified"] == (half_width == "1e-11")
    assert float(run["w"][-1]) == pytest.approx(4.0 - between, abs=1e-14)


@pytest.mark.parametrize("offset", ["1e-9", "1e-11", "-1e-10"])
@pytest.mark.parametrize("names", ["xy", "yx"])
def test_slide_on_the_branch_of_a_surface_where_only_one_factor_vanishes(names, offset):
    """(x + 3)*(y - 2) = offset with x = t: y slides along 2 + offset/(t + 3)."""
    x, y = names
    system = System(states=[x, y], equations={x: "1", y: f"-sign(({x} + 3)*({y} - 2) - {offset})"})
    run = ns.simulate(system, {x: 0.0, y: 1.5}, t_end=2.0)
    assert (run.attrs["status"], run.attrs["certified"]) == ("completed", 1)
    assert run["event_kind"].values.tolist() == ["start", "slide_entry"]
    assert run["event_time"].values[1] == pytest.approx(0.5, abs=1e-8)
    assert float(run[y][-1]) == pytest.approx(2.0 + float(offset) / 5.0, abs=1e-14)


@pytest.mark.parametrize("speed", [0.3, 0.9])
def test_belt_that_pulls_a_mass_off_its_wall(speed):
    """Friction presses the mass to the wall x = 0 until the belt turns round, at t = pi.

    The belt is slow enough to take the mass along from there on: v = speed*sin(t), which is zero at
    that instant up to the rounding of the phase.
    """
    wall = Exit("-x", reset={"v": "-0.5*v"}, sticks="rest", name="wall")
    system = System(
        states=["x", "v"],
        parameters={"speed": speed},
        modes={"free": Mode({"x": "v", "v": "-sign(v - speed*sin(t))"}, exits=[wall])},
    )
    run = ns.simulate(system, {"x": 0.0, "v": 0.0}, t_start=1.0, t_end=6.0)
    assert run.attrs["status"] == "completed"
    assert run["event_time"].values[-1] == pytest.approx(np.pi, abs=1e-15)
    assert float(run["x"][-1]) == pytest.approx(-speed * (1.0 + np.cos(6.0)), abs=1e-14)
    assert float(run["v"][-1]) == pytest.approx(speed * np.sin(6.0), abs=1e-14)
