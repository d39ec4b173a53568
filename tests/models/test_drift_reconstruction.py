"""The drift rebuilt from the bounded motion equals the one that was integrated.

Tolerance: a segment of either is right to about four roundings of the drift, and over n
segments these add up to 4 n eps at worst. The runs have fewer than 1000 segments, so 1e-12
of the drift's size is never reached by rounding, and any wrong term is far beyond it.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import drift_reconstruction, moling

SETS = [
    {},
    {"b": 0.05},
    {"b": 0.27},
    {"a": 0.5, "b": 0.456, "xi": 0.35, "omega": 0.11},
    {"a": 0.9, "b": 0.3},
    {"xi": 1.5},
    {"a": 0.3, "b": 1.2},
]


@pytest.mark.parametrize("values", SETS)
def test_equals_the_integrated_drift(values):
    """Aperiodic motion, direct passages, heavy damping, and progression that never ends."""
    run = ns.simulate(moling(**values), periods=80)
    assert run.sizes["event"] < 1000
    error = np.abs(drift_reconstruction(run) - run["v"]).max()
    assert error <= 1e-12 * np.abs(run["v"]).max()
    assert run["v"][-1] > 0.0


def test_does_not_read_the_drift():
    """Only the first value of v is used: spoiling the others changes nothing."""
    run = ns.simulate(moling(), periods=10)
    spoilt = run.copy(deep=True)
    spoilt["v"].values[1:] = np.nan
    spoilt["state_after"].loc[{"state": "v"}] = np.nan
    assert np.array_equal(drift_reconstruction(spoilt), drift_reconstruction(run))


def test_run_that_goes_on():
    """Without the event that began its first segment, the first sample begins it."""
    first = ns.simulate(moling(), periods=9.95)  # ends while it progresses
    assert first["mode"][-1] == 2
    run = ns.simulate(moling(), first, periods=10)
    error = np.abs(drift_reconstruction(run) - run["v"]).max()
    assert error <= 1e-12 * float(run["v"][-1])


def test_samples_at_the_very_events():
    """A sample belongs to either segment that meets there, so both give the same drift."""
    times = ns.simulate(moling(b=0.27), periods=5)["event_time"].values
    run = ns.simulate(moling(b=0.27), times=times)
    error = np.abs(drift_reconstruction(run) - run["v"]).max()
    assert error <= 1e-12 * float(run["v"][-1])


def test_late_phases_lose_nothing():
    """Phases are reduced: twenty thousand periods on, a period is as exact as the first."""
    system = moling(b=0.15)
    late = ns.simulate(system, {"v": 0.0}, t_start=20_000 * system.period_value, periods=20)
    early = ns.simulate(system, {"v": 0.0}, periods=20)
    # the start itself is rounded to 2e-10 of a time unit; steady drift forgets it
    assert drift_reconstruction(late).values[-1] == pytest.approx(
        float(drift_reconstruction(early).values[-1]), rel=1e-9
    )
    error = np.abs(drift_reconstruction(late) - late["v"]).max()
    assert error <= 1e-12 * float(late["v"][-1])


def test_as_printed_it_is_wrong():
    """The printed sign makes the drift jump by 2 (p0 - g - 1) when progression begins."""
    run = ns.simulate(moling(b=0.05), periods=20)
    k = int(np.flatnonzero(run["event_to"].values == 2)[0])
    # a sample at it, or behind it by rounding of two periods of 63, is before it
    just_after = float(run["event_time"][k]) + 1e-10
    start = ns.simulate(moling(b=0.05), times=[just_after])
    jump = float(drift_reconstruction(start, as_printed=True)[0] - start["v"][0])
    p0 = float(run["state_after"].sel(state="p")[k])
    assert jump == pytest.approx(2 * (p0 - 0.02 - 1.0), abs=2e-9)  # it moves by 12 per time
    assert abs(jump) > 0.5


def test_other_systems_are_refused():
    """The formulas hold for the mole only."""
    system = ns.System(name="other", states=["x"], modes={"m": ns.Mode({"x": "-x"})})
    with pytest.raises(ns.OptionError, match="'other'"):
        drift_reconstruction(ns.simulate(system, {"x": 1.0}, t_end=1.0))


def test_a_run_without_its_log_is_refused():
    run = ns.simulate(moling(), periods=3, events=False)
    with pytest.raises(ns.OptionError, match="simulate without events=False"):
        ns.models.drift_reconstruction(run)
