"""Linear modes without guards: closed form from the start to any time, however many turns later."""

import mpmath as mp
import numpy as np
import pytest

import nonsmooth as ns

EPS = np.finfo(float).eps


def test_a_forcing_of_1e15_radians():
    run = ns.simulate(
        ns.System(states=["x"], equations={"x": "cos(1e15*t)"}), {"x": 0.0}, t_end=1.0
    )
    assert run.attrs["status"] == "completed"
    expected = np.array([float(mp.sin(mp.mpf(t) * 10**15) / 10**15) for t in run["time"].values])
    # the angle is known to some units of rounding of 1e15
    assert np.abs(run["x"].values - expected).max() < 4 * EPS


def test_an_oscillation_of_1e9_radians_per_unit():
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": "-1e18*x"})
    run = ns.simulate(system, {"x": 1.0, "v": 0.0}, t_end=1.0)
    expected = np.array([float(mp.cos(mp.mpf(t) * 10**9)) for t in run["time"].values])
    assert np.abs(run["x"].values - expected).max() < 8 * EPS * 1e9


def test_forced_motion_after_a_million_periods():
    """x'' + 0.1 x' + x = cos 2.8 t: what is left is Re H e^(i phase), known by the phase."""
    system = ns.System(
        states=["x", "v"], period="2*pi/2.8", equations={"x": "v", "v": "cos(2.8*t) - 0.1*v - x"}
    )
    run = ns.simulate(system, {"x": 1.0}, periods=1_000_000, samples_per_period=1)
    response = 1.0 / (1.0 - 2.8**2 + 0.28j)
    # strobed: at phase zero; transients are gone after 400 periods, by exp(-0.05 * 900)
    assert np.abs(run["x"].values[400:] - response.real).max() < 8 * EPS
    late = ns.simulate(system, run, periods=0.3, samples_per_period=10)
    expected = (response * np.exp(2.8j * late["phase"].values)).real
    assert np.abs(late["x"].values - expected).max() < 8 * EPS


@pytest.mark.parametrize("cut", [0.3, 7.0, 5000.0])
def test_cuts_change_no_digit(cut):
    system = ns.System(
        states=["x", "v", "y"],
        equations={"x": "v", "v": "cos(3*t) + sin(sqrt(2)*t) - x - 0.01*v", "y": "x + 1"},
    )
    whole = ns.simulate(system, {"x": 0.2}, times=[0.0, 9000.0])
    first = ns.simulate(system, {"x": 0.2}, times=[0.0, cut])
    last = ns.simulate(system, first, times=[cut, 9000.0])
    assert np.array_equal(last["end_state"], whole["end_state"])


def test_free_fall():
    """A polynomial of time; it counts as diverged where it has come beyond 1e30."""
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": "-10"})
    run = ns.simulate(system, {"x": 1.0, "v": 3.0}, t_end=1000.0)
    t = run["time"].values
    assert np.allclose(run["x"], 1.0 + 3.0 * t - 5.0 * t**2, rtol=16 * EPS, atol=0.0)
    far = ns.System(states=["x", "v"], equations={"x": "v", "v": "1e30"})
    with pytest.warns(ns.RunWarning, match="diverged"):
        run = ns.simulate(far, {"x": 0.0, "v": 0.0}, t_end=1e6)
    assert float(run["time"][-1]) < 1e6
