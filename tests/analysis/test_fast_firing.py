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
