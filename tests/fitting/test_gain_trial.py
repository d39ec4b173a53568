"""A fit that fails for want of a gain says so, with the gain that the record was made with."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

FACTOR = 180.0 / np.pi
FREE = {"k": (0.5, 3.0), "c": (0.02, 0.5)}


def oscillator() -> ns.System:
    return ns.System(
        states=["x", "v"],
        parameters={"k": 1.0, "c": 0.1},
        period="2*pi/1.3",
        equations={"x": "v", "v": "cos(1.3*t) - c*v - k*x"},
    )


def record(factor: float):
    """The motion from rest in closed form: k, c and a gain show in the beats at its beginning."""
    t = np.linspace(0.0, 30.0, 600)
    steady = np.exp(1.3j * t) / (1.4 - 1.69 + 1.3j * 0.15)
    root = -0.075 + 1j * np.sqrt(1.4 - 0.075**2)
    x0, v0 = steady[0].real, (1.3j * steady[0]).real
    free = (x0 - 1j * (v0 - root.real * x0) / root.imag) * np.exp(root * t)
    x = steady.real - free.real
    noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    return ns.measured.from_arrays({"x": factor * (x + noise)}, times=t)


@pytest.mark.slow
def test_a_record_in_degrees_is_recognised():
    found = ns.fit(oscillator(), record(FACTOR), FREE, {"x": "x"}, starts=1)
    message = found.attrs["message"]
    assert "a constant gain would explain the record" in message
    gain = float(message.split("gain={'x': ")[1].rstrip("}"))
    assert gain == pytest.approx(FACTOR, rel=0.02)  # noise of 1 % in 600 samples, four digits told
    assert "degrees for radians" in message


def test_the_gain_that_is_told_makes_the_fit_converge():
    found = ns.fit(oscillator(), record(FACTOR), FREE, {"x": "x"}, starts=1, gain=FACTOR)
    assert found.attrs["status"] == "completed"
    assert "constant gain" not in found.attrs["message"]
    low, high = found["interval_low"].values, found["interval_high"].values
    truth = np.array([1.4, 0.15])
    assert np.all((low < truth) & (truth < high))


@pytest.mark.slow
def test_a_free_decay_in_mm_is_recognised():
    """The model rests where nothing drives it, and how fast a hardening spring swings tells m."""
    t = np.linspace(0.0, 15.0, 100)

    def rates(_, y):
        return [y[1], -0.15 * y[1] - 1.3 * y[0] - 0.8 * y[0] ** 3]

    x = solve_ivp(rates, (0.0, 15.0), [2.0, 0.0], "DOP853", t, rtol=1e-12, atol=1e-12).y[0]
    x += 0.01 * np.random.default_rng(1).standard_normal(t.size)
    spring = ns.System(
        states=["x", "v"],
        parameters={"k": 1.0, "c": 0.2},
        equations={"x": "v", "v": "-c*v - k*x - 0.8*x**3"},
    )
    shown = ns.measured.from_arrays({"x": 1000.0 * x}, times=t)
    with pytest.warns(ns.ResultWarning, match="mm for m"):
        found = ns.fit(spring, shown, FREE, {"x": "x"}, starts=1)
    assert "give gain={'x': 1000}" in found.attrs["message"]
