"""A neuron that fires hundreds of times in a unit of time, and declares no period.

v' = I - v from 0 to 1 takes log(I/(I - 1)), and what is left of a disturbance behind the reset is
none: the motion is a cycle without other exponents than the zero along it.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System

pytestmark = pytest.mark.filterwarnings("error::nonsmooth.RunWarning")


def firing(current: float, per_unit: float = 1.0) -> System:
    """The neuron, in units of time that hold so many of its own."""
    fires = Mode({"v": "c*(I - v)"}, exits=[Exit("1 - v", reset={"v": "0"}, name="spike")])
    values = {"I": current, "c": per_unit}
    return System(
        name="fires", states=["v"], parameters=values, modes={"sub": fires}, initial={"v": 0.0}
    )


def interval(current: float) -> float:
    return float(np.log(current / (current - 1.0)))


@pytest.mark.parametrize("current", [150.0, 160.0, 500.0])
def test_the_regime_is_a_limit_cycle_however_fast_it_fires(current):
    found = ns.regime(firing(current), period=1.0)
    assert found["regime"].item() == "limit-cycle"
    assert found["events"].item() == pytest.approx(1.0 / interval(current), abs=1.0)


@pytest.mark.slow
def test_verbs_complete_with_more_than_ten_thousand_events_in_a_window():
    system, turn = firing(500.0), interval(500.0)
    orbit = ns.find_orbit(system)
    assert orbit.attrs["status"] == "completed"
    assert float(orbit["length"]) == pytest.approx(turn, rel=1e-12)
    exponents = ns.lyapunov_spectrum(system, transient=10, record=100)
    assert exponents.attrs["status"] == "completed"
    assert exponents.attrs["n_events"] == pytest.approx(100.0 / turn, abs=1.0)
    assert abs(exponents["lyapunov_exponent"].item()) < 3.0 / 100.0
    section = ns.poincare_section(system, section="spike", transient=30, record=10)
    assert np.diff(section["time"].values) == pytest.approx(turn, abs=1e-12)


@pytest.mark.parametrize("per_unit", [1e-4, 1.0, 1e6])
def test_default_lengths_of_exponents_follow_the_motion(per_unit):
    """200 and 1000 returns, whatever the unit of time: an interval is counted to one in eight."""
    system = firing(50.0, per_unit)
    found = ns.lyapunov_spectrum(system)
    turn = interval(50.0) / per_unit
    assert found.attrs["record"] == pytest.approx(1000.0 * turn, rel=1.0 / 8.0)
    assert found.attrs["transient"] == pytest.approx(200.0 * turn, rel=1.0 / 8.0)
    assert found.attrs["n_events"] == pytest.approx(found.attrs["record"] / turn, abs=1.0)
    assert abs(found["lyapunov_exponent"].item()) < 3.0 / found.attrs["duration"]


def test_default_lengths_are_those_of_the_state_that_returns_most_seldom():
    """A pair of oscillators of which one turns 30 times while the other one turns once."""
    system = System(
        states=["x", "v", "y", "w"],
        equations={"x": "v", "v": "-900*x", "y": "w", "w": "-y"},
        initial={"x": 1.0, "v": 0.0, "y": 1.0, "w": 0.0},
    )
    found = ns.lyapunov_spectrum(system, exponents=1)
    assert found.attrs["record"] == pytest.approx(1000.0 * 2.0 * np.pi, rel=1.0 / 8.0)


def test_lengths_that_are_given_count_units_of_time():
    found = ns.lyapunov_spectrum(firing(50.0), transient=1, record=2)
    assert (found.attrs["transient"], found.attrs["record"]) == (1.0, 2.0)
    assert found.attrs["n_events"] == pytest.approx(2.0 / interval(50.0), abs=1.0)
    forced = ns.lyapunov_spectrum(ns.models.soft_impact(), confirm=0)
    assert (forced.attrs["transient"], forced.attrs["record"]) == (200.0, 1000.0)
    rests = System(states=["x"], equations={"x": "-x"}, initial={"x": 1.0})
    assert ns.lyapunov_spectrum(rests)["lyapunov_exponent"].item() == pytest.approx(-1.0)
