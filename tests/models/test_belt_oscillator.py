"""The belt oscillator against its period, its law, and motions by routes of their own."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from models.friction_truth import Leg, followed, forced_belt
from nonsmooth.models import belt_oscillator

EPS = np.finfo(float).eps
FORCED = {"v_b": 0.3, "F_k": 0.4, "F": 0.5, "omega": 0.7}


def stick_slip_period(v_b, F_s, F_k):
    with mp.workdps(30):
        v_b, D = mp.mpf(v_b), mp.mpf(F_s) - mp.mpf(F_k)
        return float(2 * D / v_b + 2 * mp.pi - 2 * mp.atan(D / v_b))


def times_of(run, kind: str) -> np.ndarray:
    return run["event_time"].values[run["event_kind"].values == kind]


def stuck(run) -> np.ndarray:
    """Samples in stick."""
    names = run["mode"].attrs["flag_meanings"].split()
    return run["mode"].values == names.index("stick")


# ---------------------------------------------------------------- not driven

CASES = [(0.3, 0.6, 0.4), (0.05, 1.0, 0.2), (2.0, 0.6, 0.4), (0.3, 0.41, 0.4)]


@pytest.mark.parametrize(("v_b", "F_s", "F_k"), CASES)
def test_stick_slip_period(v_b, F_s, F_k):
    period = stick_slip_period(v_b, F_s, F_k)
    run = ns.simulate(
        belt_oscillator(v_b, F_s, F_k),
        {"x": F_k, "v": v_b},
        t_end=6 * period,
        samples_per_period=50,
    )
    begins, ends = times_of(run, "slide_entry"), times_of(run, "slide_exit")
    assert len(begins) >= 5 and len(ends) >= 5
    assert np.diff(begins) == pytest.approx(period, abs=1e-12 * period)
    assert np.diff(ends) == pytest.approx(period, abs=1e-12 * period)
    leaves = run["state_after"].values[run["event_kind"].values == "slide_exit"]
    assert leaves == pytest.approx(np.array([[F_s, v_b]] * len(leaves)), abs=1e-13)
    comes = run["state_after"].values[run["event_kind"].values == "slide_entry"]
    assert comes == pytest.approx(np.array([[2 * F_k - F_s, v_b]] * len(comes)), abs=1e-13)


def test_the_cycle_is_found_with_its_multiplier():
    """Whatever comes to stick leaves it at one point: nothing of a disturbance is left."""
    orbit = ns.find_orbit(belt_oscillator())
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert float(orbit["length"]) == pytest.approx(stick_slip_period(0.3, 0.6, 0.4), abs=1e-10)
    assert sorted(set(str(orbit["word"].values).split())) == ["lag", "stick"]
    assert np.abs(orbit["multipliers"].values) == pytest.approx(0.0, abs=1e-8)
    assert bool(orbit["stable"])


@pytest.mark.parametrize("law", ["coulomb", "falling"])
def test_friction_in_stick_is_what_balances_the_spring(law):
    run = ns.simulate(belt_oscillator(law=law), {"x": 0.1, "v": 0.3}, t_end=40)
    inside = stuck(run)
    assert inside.sum() > 100
    x, friction = run["x"].values[inside], run["friction"].values[inside]
    assert friction == pytest.approx(x, abs=8 * EPS)
    assert friction.max() > 0.58 and friction.max() <= 0.6  # beyond kinetic friction
    assert np.all(run["slip_velocity"].values[inside] == 0.0)
    assert np.all(run["acceleration"].values[inside] == 0.0)


def test_between_static_and_kinetic_friction_the_mass_rests_at_the_kinetic_one():
    run = ns.simulate(belt_oscillator(), {"x": 0.4}, t_end=50)
    assert run.attrs["n_events"] == 0
    assert np.abs(run["x"].values - 0.4).max() < 64 * EPS


# ---------------------------------------------------------------- the falling law

LEINE = {"v_b": 0.2, "F_s": 1.0, "delta": 3.0, "law": "falling"}


def falling_by_hand(v_b, F_s, delta) -> dict[str, Leg]:
    def lagging(t, z):
        return [z[1], -z[0] + F_s / (1 + delta * (v_b - z[1]))]

    def stuck(t, z):
        return "stick", np.array([z[0], v_b])

    def slips(t, z):
        return "lag", z

    return {
        "lag": Leg(lagging, [(lambda t, z: v_b - z[1], stuck)]),
        "stick": Leg(lambda t, z: [v_b, 0.0], [(lambda t, z: F_s - z[0], slips)]),
    }


def test_the_falling_law_holds_up_to_its_static_value():
    run = ns.simulate(belt_oscillator(**LEINE), {"x": 0.0, "v": 0.2}, t_end=60)
    leaves = run["state_after"].values[run["event_kind"].values == "slide_exit"]
    assert len(leaves) == 5
    assert np.abs(leaves[:, 0]) == pytest.approx(1.0, abs=1e-14)
    assert np.all(leaves[:, 1] == 0.2)


def test_the_falling_law_by_hand_written_modes():
    times = np.linspace(0, 60, 301)
    run = ns.simulate(belt_oscillator(**LEINE), {"x": 0.0, "v": 0.2}, times=times)
    states, log = followed(falling_by_hand(0.2, 1.0, 3.0), "stick", [0.0, 0.2], times)
    switches = run["event_time"].values[1:]
    assert len(log) == len(switches) == 10
    assert switches == pytest.approx([time for _, time in log], abs=1e-10)
    assert np.abs(run["x"].values - states[:, 0]).max() < 1e-10
    assert np.abs(run["v"].values - states[:, 1]).max() < 1e-10


# ---------------------------------------------------------------- driven


@pytest.mark.parametrize("F_s", [0.4, 0.55])
@pytest.mark.parametrize(("x", "v"), [(0.0, 0.0), (0.9, 0.5)])
def test_the_forced_belt_by_closed_forms_with_many_digits(F_s, x, v):
    periods = 10
    with mp.workdps(40):
        states, log = forced_belt(**FORCED, F_s=F_s, x=x, v=v, periods=periods)
    run = ns.simulate(
        belt_oscillator(**FORCED, F_s=F_s), {"x": x, "v": v}, periods=periods, samples_per_period=1
    )
    until = periods * run.attrs["period"]
    log = [(cell, float(time)) for cell, time in log if time <= until]
    assert "stick" in {cell for cell, _ in log} and len(log) > 15
    assert list(ns.phase_word(run)) == ["lag" if v < 0.3 else "lead", *(cell for cell, _ in log)]
    assert run["event_time"].values[1:] == pytest.approx([t for _, t in log], abs=1e-11)
    for name, exact in zip(("x", "v"), np.array(states, float).T, strict=True):
        assert run[name].values == pytest.approx(exact, abs=1e-11)


def test_friction_of_the_forced_belt():
    run = ns.simulate(belt_oscillator(**FORCED, F_s=0.55), periods=50, samples_per_period=200)
    inside = stuck(run)
    x, v, friction = (run[name].values for name in ("x", "v", "friction"))
    drive = 0.5 * np.cos(0.7 * run["time"].values)
    assert inside.sum() > 1000
    assert friction[inside] == pytest.approx((x - drive)[inside], abs=1e-12)
    assert np.abs(friction).max() <= 0.55 * (1 + 8 * EPS)
    slips = ~inside & (np.abs(v - 0.3) > 1e-6)
    assert friction[slips] == pytest.approx(-0.4 * np.sign(v - 0.3)[slips], abs=8 * EPS)


# ---------------------------------------------------------------- arguments


def test_each_system_has_the_parameters_that_it_uses():
    assert list(belt_oscillator().parameters) == ["v_b", "F_s", "F_k", "zeta"]
    assert list(belt_oscillator(law="falling").parameters) == ["v_b", "F_s", "delta", "zeta"]
    driven = belt_oscillator(F=0.5)
    assert driven.period_value == pytest.approx(2 * np.pi / 0.7)
    assert belt_oscillator().period_value is None


@pytest.mark.parametrize(("words", "message"), [
    ({"law": "wet"}, "must be 'coulomb' or 'falling'"),
    ({"F_s": 0.3}, "F_s >= F_k"), ({"F_k": 0}, "F_k > 0"),
    ({"law": "falling", "delta": -1}, "delta >= 0"), ({"F": 1, "omega": 0}, "omega > 0"),
    ({"zeta": -1}, "zeta >= 0"), ({"v_b": -1}, "v_b >= 0")])  # fmt: skip
def test_impossible_arguments_are_refused(words, message):
    with pytest.raises(ns.ModelError, match=message):
        belt_oscillator(**words)
