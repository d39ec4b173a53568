"""Equations that end, or never make sense: a status with the time, or an error that says why."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, OptionError, RunWarning, System


def one(flow, exits=(), **words):
    return System(states=list(flow), modes={"m": Mode(flow, exits=exits)}, **words)


def singular(system, start, time, **words):
    """A run that must end as singular at a time."""
    with pytest.warns(RunWarning, match="singular at t = "):
        run = ns.simulate(system, start, t_end=5.0, **words)
    assert run.attrs["status"] == "singular"
    said = float(run.attrs["message"].split("t = ")[1].split(":")[0])
    assert said == pytest.approx(time, abs=1e-8)
    assert np.all(np.isfinite(run["end_state"]))
    for name in system.states:
        assert np.all(np.isfinite(run[name]))
    return run


@pytest.mark.parametrize(
    ("rate", "start", "time"),
    [
        # x' = -x^p reaches zero at x^(1-p)/(1-p)
        ("-sqrt(x)", 1.0, 2.0),  # x = (1 - t/2)^2, whose series knows nothing of the end
        ("-sqrt(x)", 4.0, 4.0),
        ("-x**0.75", 1.0, 4.0),  # (1 - t/4)^4
        ("-x**0.25", 1.0, 4.0 / 3.0),
        ("-1 + 0*t + sqrt(x) - sqrt(x)", 1.0, 1.0),
        ("-1/x", 1.0, 0.5),
        ("x**2", 1.0, 1.0),
        ("-1 - 1e-300*log(x)", 1.0, 1.0),
    ],
)
def test_the_end_of_a_root(rate, start, time):
    singular(one({"x": rate}), {"x": start}, time)


def test_an_arcsine_beyond_its_range():
    # x = t/2: asin(x) ends at t = 2
    singular(one({"x": "0.5", "y": "asin(x)"}), {}, 2.0)


@pytest.mark.parametrize("drift", [0.0, 1e-3, 1e-9])
def test_a_throw_against_the_speed_squared(drift):
    """v' = -1 - v sqrt(u^2 + v^2), upward from 1: at the top sqrt(v^2) changes sign.

    A throw straight up ends there, as the text has no continuation by its series; write
    abs(v) for it. With the least drift u it goes on, v = -tanh(t - pi/4) afterwards.
    """
    flow = {"u": "-u*sqrt(u**2 + v**2)", "v": "-1 - v*sqrt(u**2 + v**2)"}
    if drift == 0.0:
        singular(one(flow), {"v": 1.0}, math.pi / 4)
        return
    run = ns.simulate(one(flow), {"u": drift, "v": 1.0}, times=[3.0])
    # the drift counts with its square, times its logarithm
    expected = -math.tanh(3.0 - math.pi / 4)
    assert float(run["v"][-1]) == pytest.approx(expected, abs=1e-13 + 10 * drift**2)


def test_the_throw_written_with_abs():
    mode = Mode({"v": "-1 - v*abs(v)"})
    run = ns.simulate(System(states=["v"], modes={"m": mode}), {"v": 1.0}, times=[3.0])
    assert float(run["v"][-1]) == pytest.approx(-math.tanh(3.0 - math.pi / 4), abs=1e-14)
    # v = tan(pi/4 - t) before
    assert float(run["event_time"][1]) == pytest.approx(math.pi / 4, abs=1e-15)


def test_an_angle_through_the_origin():
    """atan2(y, x) jumps by pi where x = 1 - t, y = 0 passes zero."""
    flow = {"x": "-1", "y": "0*t", "s": "atan2(y, x)"}
    singular(one(flow), {"x": 1.0}, 1.0)


def test_rates_that_underflow_are_no_singularity():
    """Powers of small numbers vanish; so does what they add."""
    run = ns.simulate(one({"x": "-x**9"}), {"x": 1e-40}, times=[0.0, 1.0, 1e6])
    assert run.attrs["status"] == "completed"
    assert np.all(run["x"].values == 1e-40)


@pytest.mark.parametrize("text", ["1/x", "log(x)", "sqrt(x)", "asin(1 + x)", "x**0.5", "x**(-1)"])
def test_a_start_where_rates_are_not_finite(text):
    singular(one({"x": f"1 + {text}"}), {"x": 0.0}, 0.0)


@pytest.mark.parametrize(("text", "start"), [("1/x", 0.0), ("sqrt(x)", -1.0), ("log(x)", 0.0)])
def test_a_start_where_a_guard_is_not_finite(text, start):
    system = one({"x": "1"}, [Exit(text, to="stop")])
    with pytest.raises(OptionError, match=r"guard '.*' is not a finite number there"):
        ns.simulate(system, {"x": start}, t_end=1.0)


def test_a_reset_that_divides_by_zero():
    flow = {"x": "v", "v": "-x**3"}
    system = one(flow, [Exit("x", reset={"v": "1/x"}, name="wall")])
    with pytest.warns(RunWarning, match="singular"):
        run = ns.simulate(system, {"x": 1.0}, t_end=5.0)
    assert run.attrs["status"] == "singular"
    assert run["event_name"].values[-1] == "wall"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_starts_that_are_no_numbers(value):
    with pytest.raises(OptionError, match="not a finite number"):
        ns.simulate(one({"x": "-x**3"}), {"x": value}, t_end=1.0)


@pytest.mark.parametrize(
    "definitions", [{"a": "a + x"}, {"a": "b + x", "b": "2*a"}, {"a": "b", "b": "c", "c": "sin(a)"}]
)
def test_definitions_that_refer_to_themselves(definitions):
    with pytest.raises(ModelError, match="circle"):
        one({"x": "a"}, definitions=definitions)
