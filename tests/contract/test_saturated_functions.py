"""Functions that are flat to the last digit here and steep elsewhere: pulses, switches, tanh.

Where they are flat their Taylor coefficients vanish beside what they are added to, so nothing in
the series of the states tells that a step reaches into the steep part. Smoothed friction and
smoothed contact are of this kind.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erf

import nonsmooth as ns

OVERFLOWS = pytest.mark.xfail(
    strict=True,
    raises=(AssertionError, ns.RunWarning),
    reason="exp or cosh overflows on the way",
)
TIMES = np.array([0.0, 5.0, 9.0, 10.0, 10.5, 12.0, 20.0])
WIDTHS = [3.0, 1.0, 0.3, 0.1, 0.01]


def one_mode(flow, exits=(), **parameters):
    mode = ns.Mode(flow, exits=exits)
    return ns.System(states=list(flow), parameters=parameters, modes={"m": mode})


def cases(texts, values, failing):
    """All pairs; ``failing`` has for a text the largest value that is not right yet."""
    return [
        pytest.param(text, value, marks=[OVERFLOWS] if value <= failing.get(text, 0.0) else [])
        for text in texts
        for value in values
    ]


def softplus(u):
    return np.logaddexp(0.0, u)


INTEGRALS = {
    "exp(-((t - 10)/w)**2)": lambda t, w: w * math.sqrt(math.pi) / 2 * (erf((t - 10) / w)),
    "1 + tanh((t - 10)/w)": lambda t, w: w * softplus(2 * (t - 10) / w),
    "1/(1 + exp(-(t - 10)/w))": lambda t, w: w * softplus((t - 10) / w),
    "1/cosh((t - 10)/w)**2": lambda t, w: w * np.tanh((t - 10) / w),
    "1/2 + atan((t - 10)/w)/pi": lambda t, w: (
        t / 2
        + ((t - 10) * np.arctan((t - 10) / w) - w / 2 * np.log(w * w + (t - 10) ** 2)) / math.pi
    ),
}


def assert_integral(text, start, w):
    run = ns.simulate(one_mode({"x": text}, w=w), {"x": start}, times=TIMES)
    assert run.attrs["status"] == "completed"
    integral = INTEGRALS[text]
    expected = start + integral(TIMES, w) - integral(0.0, w)
    assert np.abs(run["x"].values - expected).max() < 1e-12


FROM_ZERO = dict.fromkeys(list(INTEGRALS)[2:4], 0.01)
FROM_ONE = FROM_ZERO


@pytest.mark.parametrize(("text", "w"), cases(INTEGRALS, WIDTHS, FROM_ZERO))
def test_integral_of_a_pulse_or_a_switch(text, w):
    assert_integral(text, 0.0, w)


@pytest.mark.parametrize(("text", "w"), cases(INTEGRALS, WIDTHS, FROM_ONE))
def test_integral_beside_something_larger(text, w):
    assert_integral(text, 1.0, w)


PULSE = "1 - 3/2*exp(-((t - 10)/w)**2)"


@pytest.mark.parametrize(("text", "w"), cases([PULSE], WIDTHS, {}))
def test_a_guard_with_a_pulse_in_it(text, w):
    """It falls below zero for a moment."""
    stop = ns.Exit(text, to="stop")
    run = ns.simulate(one_mode({"x": "x*(1 - x)"}, [stop], w=w), {"x": 0.1}, t_end=20.0)
    assert run.attrs["status"] == "stopped"
    assert float(run["event_time"][-1]) == pytest.approx(10 - w * math.sqrt(math.log(1.5)))


FRICTION = {
    "tanh(v/p)": lambda v, p: np.tanh(v / p),
    "2/(1 + exp(-2*v/p)) - 1": lambda v, p: np.tanh(v / p),
    "2/pi*atan(v/p)": lambda v, p: 2 / math.pi * np.arctan(v / p),
    "v/sqrt(p**2 + v**2)": lambda v, p: v / np.sqrt(p * p + v * v),
}


SMOOTHED = {list(FRICTION)[1]: 1e-3}


@pytest.mark.parametrize(("text", "p"), cases(FRICTION, [0.1, 0.01, 1e-3], SMOOTHED))
def test_smoothed_friction(text, p):
    """scipy at 1e-11 in short steps; its own error stays below 1e-9."""
    flow = {"x": "v", "v": f"-x - 0.1*({text}) + 0.5*cos(1.3*t)"}
    times = np.linspace(0.0, 10.0, 21)
    run = ns.simulate(one_mode(flow, p=p), {"x": 1.3}, times=times)
    force = FRICTION[text]
    other = solve_ivp(
        lambda t, z: [z[1], -z[0] - 0.1 * force(z[1], p) + 0.5 * math.cos(1.3 * t)],
        (0.0, 10.0),
        [1.3, 0.0],
        method="DOP853",
        rtol=1e-11,
        atol=1e-12,
        t_eval=times,
        max_step=0.02,
    )
    assert run.attrs["status"] == "completed"
    assert np.abs(run["x"].values - other.y[0]).max() < 1e-8
