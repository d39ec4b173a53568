"""Progression against a drift that is known exactly, and its errors."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import moling, progression

EPS = np.finfo(float).eps


def drifting(speed=0.25, omega=1.7):
    """A state that drifts at a constant speed and swings about it."""
    return ns.System(
        name="drifter",
        states=["s", "w"],
        drift=["s"],
        parameters={"speed": speed, "omega": omega},
        period="2*pi/omega",
        describe={"s": "way [mm]"},
        modes={"go": ns.Mode({"s": "speed + cos(omega*t)", "w": "-w"})},
    )


@pytest.mark.parametrize("t_start", [0.0, 0.4, 7.3])
@pytest.mark.parametrize("samples", [1, 7, 100])
def test_mean_speed_is_exact_at_any_phase(t_start, samples):
    """The swing has period one, so it drops out wherever the period begins."""
    run = ns.simulate(drifting(), t_start=t_start, periods=12.3, samples_per_period=samples)
    result = progression(run, "s", periods=5)
    assert float(result["per_unit_time"]) == pytest.approx(0.25, abs=100 * EPS)
    assert float(result["total"]) == pytest.approx(5 * float(result["per_period"]), rel=4 * EPS)
    assert result.sizes["period"] == 12
    assert np.abs(result["progression"] - 0.25 * run.attrs["period"]).max() < 100 * EPS


def test_units_come_from_the_state_and_the_time():
    """Progression per time has the units of both."""
    run = ns.simulate(drifting(), periods=3)
    assert "units" not in progression(run, "s")["per_unit_time"].attrs
    run["time"].attrs["units"] = "s"
    result = progression(run, "s")
    assert result["per_period"].attrs["units"] == "mm"
    assert result["per_unit_time"].attrs["units"] == "mm/s"


def test_period_numbers_go_on_with_a_run():
    """A run that goes on counts its periods from the beginning."""
    first = ns.simulate(moling(), periods=4)
    result = progression(ns.simulate(moling(), first, periods=3))
    assert list(result["period"].values) == [4, 5, 6]


def test_series_adds_up_to_the_drift():
    """Nothing is lost between the periods."""
    run = ns.simulate(moling(b=0.19), periods=30)
    result = progression(run)
    assert float(result["progression"].sum()) == pytest.approx(float(run["v"][-1]), rel=1e-13)
    assert float(result["total"]) == float(run["v"][-1])


def test_strobes_may_be_chosen_by_the_caller():
    """Times one period apart are strobes as well."""
    times = 3.0 + 2 * np.pi / 0.1 * np.arange(6)
    assert progression(ns.simulate(moling(), times=times)).sizes["period"] == 5


def no_drift():
    """An oscillator."""
    return ns.System(
        states=["x", "v"], period="2*pi", modes={"m": ns.Mode({"x": "v", "v": "cos(t) - x/2"})}
    )


def no_period():
    """A state that creeps away, with no forcing."""
    return ns.System(states=["x"], drift=["x"], modes={"m": ns.Mode({"x": "1"})})


@pytest.mark.parametrize(
    ("make", "arguments", "message"),
    [
        (lambda: ns.simulate(no_drift(), periods=2), {"state": "x"}, "no drift state"),
        (lambda: ns.simulate(no_period(), t_end=2.0), {"state": "x"}, "no period"),
        (lambda: ns.simulate(moling(), periods=2), {"state": "p"}, "drift state 'p'"),
        (lambda: ns.simulate(moling(), periods=2), {"periods": 3}, "2 whole periods"),
        (lambda: ns.simulate(moling(), periods=2), {"periods": 0}, "at least 1"),
        (lambda: ns.simulate(moling(), periods=2), {"periods": 1.5}, "a whole number"),
        (lambda: ns.simulate(moling(), periods=0.5), {}, "at the phase of its first one"),
        (lambda: ns.simulate(moling(), times=[0.0, 200.0]), {}, "at the phase of its first one"),
        (lambda: ns.simulate(moling(), periods=2).drop_attrs(), {}, "nonsmooth.simulate"),
    ],
)
def test_errors_say_what_is_missing(make, arguments, message):
    """Each message names what the run lacks."""
    with pytest.raises(ns.OptionError, match=message):
        progression(make(), **arguments)
