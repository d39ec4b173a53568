"""How runs end, and that they say so: never a success on a wrong answer, never a hang."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, RunWarning, System


def ending(status, system, initial=None, **words):
    """A run that must end early, with the warning that tells so."""
    with pytest.warns(RunWarning, match=f"{system.name}: {status}"):
        run = ns.simulate(system, initial, **words)
    assert run.attrs["status"] == status
    return run


def test_growth_without_bound_is_diverged():
    system = System(name="runaway", states=["x"], modes={"m": Mode({"x": "x"})})
    run = ending("diverged", system, {"x": 1.0}, t_end=1000.0)
    assert "declare the states that travel without bound in drift=" in run.attrs["message"]
    # what was computed is kept and right; exp of t has error t eps
    assert 20 < run.sizes["time"] < 1001
    assert np.allclose(run["x"], np.exp(run["time"]), rtol=1e-13)


def test_diverged_says_when():
    system = System(states=["x"], modes={"m": Mode({"x": "x"})})
    run = ending("diverged", system, {"x": 1.0}, t_end=1000.0)
    said = float(run.attrs["message"].split("t = ")[1].split(":")[0])
    assert said >= np.log(1e30)  # x passes 1e30 at 69.1


def test_a_drift_may_grow():
    system = System(states=["x"], drift=["x"], modes={"m": Mode({"x": "1e6"})})
    run = ns.simulate(system, times=[0.0, 1e8])
    assert run.attrs["status"] == "completed"
    assert float(run["x"][-1]) == pytest.approx(1e14, rel=1e-13)


def circle(reset=None):
    """Two modes that push towards each other's surface."""
    return System(
        name="circle",
        states=["x", "n"],
        modes={
            "left": Mode({"x": "-1", "n": "0"}, exits=[Exit("x", to="right", reset=reset or {})]),
            "right": Mode({"x": "1", "n": "0"}, exits=[Exit("-x", to="left")]),
        },
    )


def test_modes_that_hand_over_to_each_other():
    # at x = 0 left wants right and right wants left: sliding, not part of this version
    run = ending("undecided", circle(), {"x": 1.0}, t_end=5.0)
    message = run.attrs["message"]
    assert "left" in message and "right" in message
    assert float(run["event_time"][-1]) == 1.0
    assert run["event_path"].values[-1] == "right>left"


def test_a_start_where_modes_hand_over_to_each_other():
    run = ending("undecided", circle(), {"x": 0.0}, t_end=5.0)
    assert "left" in run.attrs["message"] and "right" in run.attrs["message"]


def test_resets_at_one_instant_are_bounded():
    # each turn adds one to n; a hundred passes are the limit
    with pytest.warns(RunWarning):
        run = ns.simulate(circle({"n": "n + 1"}), {"x": 1.0}, t_end=5.0)
    assert run.attrs["status"] in ("undecided", "event_limit")
    assert run.attrs["n_events"] == 1
    assert float(run["end_state"].sel(state="n")) <= 51.0


# ---------------------------------------------------------------- accumulating impacts


def ball(r=0.5, gravity=1.0):
    return System(
        name="ball",
        states=["x", "v"],
        parameters={"r": r, "gravity": gravity},
        modes={
            "flight": Mode(
                {"x": "v", "v": "-gravity"}, exits=[Exit("x", reset={"v": "-r*v"}, name="bounce")]
            )
        },
    )


@pytest.mark.parametrize("r", [0.0, 0.1, 0.5, 0.8, 0.9])
def test_a_bouncing_ball_never_falls_through_the_floor(r):
    # From height h the bounces accumulate at sqrt(2 h/g) (1 + 2 r/(1 - r)).
    accumulation = np.sqrt(2.0) * (1.0 + 2.0 * r / (1.0 - r))
    with pytest.warns(RunWarning):
        run = ns.simulate(ball(r), {"x": 1.0}, t_end=100.0)
    assert run.attrs["status"] in ("event_limit", "undecided", "step_limit")
    # bounces until a speed is lost in rounding, r^n = eps, and a hundred at one instant
    bounces = np.log(np.finfo(float).eps) / np.log(r) if r else 1
    assert run.attrs["n_events"] <= bounces + 110
    # no sample below the floor by more than rounding of the height, none beyond the end
    assert float(run["x"].min()) >= -1e-15
    assert float(run["state_after"].sel(state="x").min()) >= -1e-15
    assert float(run["event_time"][-1]) <= accumulation * (1 + 1e-14)
    assert float(run["time"][-1]) <= accumulation * (1 + 1e-14)


def test_bounces_are_those_of_the_closed_form():
    # t_k = sqrt 2 (1 + 2 (r + ... + r^(k-1))), v_k = r^k sqrt 2, g = h = 1. The first 12
    # bounces: each time carries the rounding of all before, v falls to 3e-4, and a time is
    # off by eps x/v = 1e-16 / 3e-4 at worst.
    with pytest.warns(RunWarning):
        run = ns.simulate(ball(0.5), {"x": 1.0}, t_end=100.0)
    k = np.arange(1, 13)
    times = np.sqrt(2.0) * (1.0 + 2.0 * (0.5 - 0.5**k) / 0.5)
    assert np.allclose(run["event_time"][1:13], times, rtol=0, atol=5e-12)
    assert np.allclose(run["state_after"].sel(state="v")[1:13], np.sqrt(2.0) * 0.5**k, rtol=1e-11)


@pytest.mark.parametrize("r", [0.99, 1.0, 1.05])
def test_bounces_that_do_not_accumulate_yet(r):
    run = ns.simulate(ball(r), {"x": 1.0}, t_end=20.0)
    assert run.attrs["status"] == "completed"
    k = np.arange(1, run.attrs["n_events"] + 1)
    geometric = k - 1 if r == 1.0 else r * (1 - r ** (k - 1)) / (1 - r)
    assert np.allclose(run["event_time"][1:], np.sqrt(2.0) * (1 + 2 * geometric), rtol=1e-13)


def test_a_ball_in_small_units():
    # fall of one micrometre at 1e9 m/s^2: the first bounce is at sqrt(2e-15)
    with pytest.warns(RunWarning):
        run = ns.simulate(ball(0.5, 1e9), {"x": 1e-6}, t_end=1.0)
    assert float(run["event_time"][1]) == pytest.approx(np.sqrt(2e-15), rel=1e-12)


# ---------------------------------------------------------------- stop, slaved states


def test_an_exit_to_stop():
    system = System(
        states=["x"], modes={"m": Mode({"x": "-1"}, exits=[Exit("x", to="stop", name="floor")])}
    )
    run = ns.simulate(system, {"x": 2.0}, t_end=5.0)  # no warning: it is what was asked for
    assert run.attrs["status"] == "stopped"
    assert run["event_name"].values.tolist() == ["start", "floor"]
    assert float(run["event_time"][-1]) == 2.0
    assert float(run["end_state"][0]) == 0.0
    assert float(run["time"][-1]) <= 2.0
    at_once = ns.simulate(system, {"x": 0.0}, t_end=5.0)
    assert at_once.attrs["status"] == "stopped"


def held(reset):
    """y is free in one mode and slaved to x + 1 in the next."""
    return System(
        name="held",
        states=["x", "y"],
        modes={
            "free": Mode({"x": "-1", "y": "0"}, exits=[Exit("x", to="held", reset=reset)]),
            "held": Mode({"x": "2"}, slaved={"y": "x + 1"}),
        },
    )


def test_a_slaved_state_that_disagrees_on_entry():
    run = ending("inadmissible", held({}), {"x": 1.0, "y": 0.25}, t_end=3.0)
    assert "name it in the exit's reset=" in run.attrs["message"]
    assert "from 'free' to 'held'" in run.attrs["message"]
    assert float(run["state_before"][-1].sel(state="y")) == 0.25


def test_a_slaved_state_that_agrees_on_entry():
    run = ns.simulate(held({}), {"x": 1.0, "y": 1.0}, times=[0.0, 1.0, 3.0])
    assert run["y"].values.tolist() == [1.0, 1.0, 5.0]
    assert run["event_kind"].values[-1] == "switch"


def test_a_slaved_state_jumps_when_the_reset_names_it():
    run = ns.simulate(held({"y": "y"}), {"x": 1.0, "y": 0.25}, times=[0.0, 0.5, 3.0])
    assert run["y"].values.tolist() == [0.25, 0.25, 5.0]
    assert float(run["state_after"][-1].sel(state="y")) == 1.0
    assert run["event_kind"].values[-1] == "impact"


def test_a_completed_run_says_so():
    run = ns.simulate(ns.models.moling(), periods=3)
    assert (run.attrs["status"], run.attrs["message"]) == ("completed", "completed")
    assert run.attrs["certified"] == 1
