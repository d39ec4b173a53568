"""Runs that need far more work than a record calls for end early, and so a fit does not last.

A hardening spring at amplitude A swings at about 0.85 A sqrt(b) rad/s. A record of it in mm asks
for motions a thousand times as fast as those in m.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.fitting.flights import Flights

FREE = {"k": (0.5, 3.0), "c": (0.02, 0.5), "b": (0.2, 2.0)}
TRUTH = {"k": 1.3, "c": 0.15, "b": 0.8}
END = 30.0
TIMES = np.linspace(0.0, END, 150)


def duffing():
    return ns.System(
        states=["x", "v"],
        parameters={"k": 1.0, "c": 0.2, "b": 1.0},
        period="2*pi/1.2",
        equations={"x": "v", "v": "cos(1.2*t) - c*v - k*x - b*x**3"},
    )


def motion(state, times):
    """Positions and speeds by DOP853, (2, K)."""

    def rates(t, y):
        pull = TRUTH["c"] * y[1] + TRUTH["k"] * y[0] + TRUTH["b"] * y[0] ** 3
        return [y[1], np.cos(1.2 * t) - pull]

    span = (0.0, float(times[-1]))
    return solve_ivp(rates, span, state, "DOP853", times, rtol=1e-12, atol=1e-12).y


def flights(*, limited):
    found = Flights(duffing(), tuple(TRUTH), 1e-12)
    found.set_up(TRUTH)
    if limited:
        found.limit_work(np.zeros(2), 0.0, END, TIMES.size)
    return found


def test_motions_as_large_as_the_record_of_a_model_run_as_without_a_limit():
    start, times = np.array([1.5, 0.0]), TIMES[1:30]
    found = flights(limited=True).fly(start, 0.0, times)
    free = flights(limited=False).fly(start, 0.0, times)
    assert np.array_equal(found.samples.states, free.samples.states)
    assert np.array_equal(found.columns, free.columns)
    # 30 samples are 6 s, in which DOP853 at 1e-12 is good to some 1e-11
    assert np.abs(found.samples.states - motion(start, times).T).max() < 1e-9


def test_motions_a_thousand_times_as_large_end_early():
    start, times = np.array([1000.0, 0.0]), TIMES[1:8]
    assert flights(limited=False).fly(start, 0.0, times) is not None
    assert flights(limited=True).fly(start, 0.0, times) is None


def test_a_motion_from_rest_that_stays_there_leaves_room_for_others():
    """Nothing drives it, so the motion from rest is no measure of the work of any other."""
    spring = ns.System(
        states=["x", "v"],
        parameters={"b": 0.8},
        equations={"x": "v", "v": "-0.1*v - x - b*x**3"},
    )
    found = Flights(spring, ("b",), 1e-12)
    found.set_up({"b": 0.8})
    found.limit_work(np.zeros(2), 0.0, END, TIMES.size)
    assert found.fly(np.array([3.0, 0.0]), 0.0, TIMES[1:]) is not None
    assert found.fly(np.array([3000.0, 0.0]), 0.0, TIMES[1:]) is None


@pytest.mark.slow
def test_a_record_in_mm_of_a_model_in_m_is_recognised():
    noise = 0.01 * np.random.default_rng(1).standard_normal(TIMES.size)
    x = motion([0.5, 0.0], TIMES)[0] + noise
    record = ns.measured.from_arrays({"x": 1000.0 * x}, times=TIMES)
    with pytest.warns(ns.ResultWarning, match="not converged"):
        found = ns.fit(duffing(), record, FREE, {"x": "x"})
    message = found.attrs["message"]
    gain = float(message.split("gain={'x': ")[1].rstrip("}"))
    assert gain == pytest.approx(1000.0, rel=0.02)  # noise of 1 % in 150 samples, four digits told
    assert "mm for m" in message
