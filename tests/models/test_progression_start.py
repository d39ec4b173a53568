"""Where progression begins on an orbit, against the event log of a motion."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.models import moling, progression_start


@pytest.mark.parametrize("values", [{}, {"b": 0.12}, {"a": 0.9, "b": 0.4, "xi": 0.01}])
def test_as_in_the_motion(values):
    """The first row of the log with that event has the same phase, displacement and velocity."""
    system = moling(**values)
    orbit = ns.find_orbit(system)
    start = progression_start(orbit)
    assert start.sizes["start"] == 1 and start["entered"].item() == "progression"
    run = ns.simulate(system, orbit, periods=1)
    row = int(np.flatnonzero(run["event_name"].values == "progression")[0])
    p, y, _, _ = run["state_after"].values[row]
    assert start["x_0"].item() == pytest.approx(p, abs=1e-9)
    assert start["y_0"].item() == pytest.approx(y, abs=1e-9)
    phase = system.parameter_values["phi"] + system.parameter_values["omega"] * float(
        run["event_time"][row]
    )
    turns = (start["psi_0"].item() - phase) / (2.0 * np.pi)
    assert abs(turns - round(turns)) < 1e-10
    assert abs(start["residual"].item()) < 1e-12


def test_section_within_progression_makes_no_start():
    """The stay in progression is cut by the section, and still begins once."""
    orbit = ns.find_orbit(moling())
    assert orbit["word"].item().split()[0] == orbit["word"].item().split()[-1] == "progression"
    assert progression_start(orbit).sizes["start"] == 1


def test_two_stays_in_a_period_of_two():
    orbit = ns.find_orbit(moling(b=0.1), period=2)
    start = progression_start(orbit)
    assert start.sizes["start"] == 2
    assert np.all(np.diff(start["tau_0"]) > 0.0)
    assert np.abs(start["residual"]).max() < 1e-12


def test_none_without_progression():
    assert progression_start(ns.find_orbit(moling(a=0.1, b=0.4))).sizes["start"] == 0


def test_other_data_are_refused():
    with pytest.raises(OptionError, match="soft_impact"):
        progression_start(ns.find_orbit(ns.models.soft_impact()))
    with pytest.raises(OptionError, match="has no legs"):
        progression_start(ns.simulate(moling(), periods=1))
    orbit = ns.find_orbit(moling())
    with pytest.raises(OptionError, match="several"):
        progression_start(orbit.expand_dims("point"))
