"""Units of time, length and guards change no event of a Taylor run."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from runs.flows import crossings


def oscillator(second, metre):
    """A Duffing oscillator with drag and a stop in units of time and length."""
    p = {"w0": 1 / second, "L": metre, "c": 0.1 / second, "d": 0.2 / metre}
    p |= {"F": 0.5 * metre / second**2, "w": 1.2 / second, "s": 0.8 * metre, "r": 0.7}
    flow = {"x": "v", "v": "w0**2*(x - x**3/L**2) - c*v - d*v*abs(v) + F*cos(w*t)"}
    mode = Mode(flow, exits=[Exit("s - x", reset={"v": "-r*v"}, name="impact")])
    return System(states=["x", "v"], period="2*pi/w", parameters=p, modes={"m": mode})


UNITS = {"kHz and um": (1e-3, 1e-6), "geological": (1e9, 1e3), "molecular": (1e-12, 1e-10)}


@pytest.mark.parametrize("units", UNITS)
def test_units_of_time_and_length(units):
    second, metre = UNITS[units]
    one = crossings(ns.simulate(oscillator(1.0, 1.0), times=[40.0]))
    other = crossings(ns.simulate(oscillator(second, metre), times=[40.0 * second]))
    assert one.sizes["event"] > 15
    assert one["event_name"].values.tolist() == other["event_name"].values.tolist()
    # other units round the eight parameters and the time; differences of eps grow by less than 1e4
    # in six periods
    rounding = 9 * np.finfo(float).eps * 1e4
    assert np.allclose(other["event_time"] / second, one["event_time"], rtol=rounding, atol=0)
    after = [log["state_after"].sel(state="x").values for log in (one, other)]
    assert np.allclose(after[1] / metre, after[0], rtol=0, atol=rounding)


@pytest.mark.parametrize("units", UNITS)
def test_states_that_stay_zero_have_no_unit(units):
    """A state that is identically zero must not set the step, in whatever unit of time."""
    second, _ = UNITS[units]
    flow = {"x": "v", "v": "-k*sin(x)", "idle": "-idle**3", "guarded": "0*t"}
    mode = Mode(flow, exits=[Exit("x", reset={"v": "-v"}), Exit("guarded", to="stop")])
    system = System(states=list(flow), parameters={"k": second**-2}, modes={"m": mode})
    run = ns.simulate(system, {"x": 1.0}, times=[100.0 * second])
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    gaps = np.diff(run["event_time"].values[1:])
    # half a swing of amplitude 1; each gap has the rounding of two times
    half = float(2 * mp.ellipk(mp.sin(mp.mpf(1) / 2) ** 2))
    assert np.allclose(gaps / second, half, rtol=1e-12, atol=0)


GUARDS = {
    "times 1e12": "1e12*g",
    "times 1e-12": "1e-12*g",
    "g^3 + g": "g**3 + g",
    "tanh": "tanh(g)",
    "exp": "exp(g) - 1",
    "atan of 100 g": "atan(100*g)",
}


@pytest.mark.parametrize("guard", GUARDS)
def test_monotone_functions_of_a_guard(guard):
    def run(text):
        mode = Mode(
            {"x": "v", "v": "x - x**3 - 0.1*v + 0.5*cos(1.2*t)"},
            exits=[Exit(text, reset={"v": "-0.8*v"}, name="impact")],
        )
        system = System(states=["x", "v"], definitions={"g": "0.9 - x"}, modes={"m": mode})
        return crossings(ns.simulate(system, times=[30.0]))

    one, other = run("g"), run(GUARDS[guard])
    assert one.sizes["event"] == other.sizes["event"] > 5
    assert bool(other["certified"].all())
    # a rate changed by 1e-16 x^5 moves the last event by 4e-12: roundings grow that much
    assert np.allclose(one["event_time"], other["event_time"], rtol=0, atol=1e-10)


@pytest.mark.parametrize("depth", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("guard", GUARDS)
def test_shallow_dips_whatever_the_guard(guard, depth):
    """cos t dips below depth - 1 for about sqrt(8 depth) around pi."""

    def run(text):
        modes = {
            "above": Mode({"x": "v", "v": "-x + tiny*x*x"}, exits=[Exit(text, to="below")]),
            "below": Mode({"x": "v", "v": "-x + tiny*x*x"}, exits=[Exit(f"-({text})", to="above")]),
        }
        system = System(
            states=["x", "v"],
            parameters={"tiny": 0.0, "depth": depth},
            definitions={"g": "x + 1 - depth"},
            modes=modes,
        )
        return crossings(ns.simulate(system, {"x": 1.0}, times=[5.0]))

    log = run(GUARDS[guard])
    level = -1.0 + depth
    half = np.sqrt(2 * (1 + level)) * (1 + (1 + level) / 12)
    assert log["event_to"].values.tolist() == [1, 0]
    assert bool(log["certified"].all())
    # eps over the rate sqrt(2 depth), and the next term of the arccosine
    expected = np.pi + half * np.array([-1.0, 1.0])
    error = np.abs(log["event_time"].values - expected)
    assert np.all(error < 1e-14 / half + 0.03 * half**5)
