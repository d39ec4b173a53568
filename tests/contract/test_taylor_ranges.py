"""Taylor flows where the size of what is integrated says little about the motion.

Closed forms; 1e-13 of the value where nothing is lost.
"""

import math
import warnings

import numpy as np
import pytest

import nonsmooth as ns


def one_mode(flow, exits=(), **words):
    return ns.System(states=list(flow), modes={"m": ns.Mode(flow, exits=exits)}, **words)


@pytest.mark.parametrize("power", [1, 2, 3, 4, 5, 8, 12, 18, 20, 25])
def test_a_state_that_leaves_zero_slowly(power):
    """x' = t^k exp(t) from zero: the first k coefficients vanish."""
    system = one_mode({"x": f"t**{power}*exp(t)"})
    run = ns.simulate(system, times=[0.0, 0.5, 2.0])
    assert run.attrs["status"] == "completed"
    for t, x in zip([0.5, 2.0], run["x"].values[1:], strict=True):
        nodes, weights = np.polynomial.legendre.leggauss(40)
        s = t * (nodes + 1) / 2
        expected = t / 2 * (weights * s**power * np.exp(s)).sum()
        assert x == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("rate", [1.0, 10.0, 1e3])
def test_a_decay_below_the_smallest_number(rate):
    """x' = -k x (1 + x^2): x^2/(1 + x^2) falls as exp(-2 k t), and at last x is zero."""
    system = one_mode({"x": "-k*x*(1 + x**2)"}, parameters={"k": rate})
    times = np.array([0.0, 1.0, 100.0, 700.0, 740.0, 800.0, 2000.0]) / rate
    run = ns.simulate(system, {"x": 1.0}, times=times)
    assert run.attrs["status"] == "completed"
    share = np.exp(-2 * rate * times[:3]) / 2
    assert np.allclose(run["x"].values[:3], np.sqrt(share / (1 - share)), rtol=1e-12, atol=0)
    assert abs(run["x"].values[-1]) < 1e-307


def test_an_equilibrium_holds():
    run = ns.simulate(one_mode({"x": "v", "v": "-sin(x)"}), times=[0.0, 10.0, 1e4])
    assert run.attrs["status"] == "completed"
    assert np.array_equal(run["x"].values, np.zeros(3))
    assert np.array_equal(run["v"].values, np.zeros(3))


@pytest.mark.parametrize("scale", [1e-60, 1e-12, 1e12, 1e25])
def test_units_of_length_change_nothing(scale):
    """A Duffing oscillator with an impact, in other units; powers of two leave the digits alone."""
    scale = 2.0 ** round(math.log2(scale))
    stop = ns.Exit("s - x", reset={"v": "-r*v"}, name="impact")
    flow = {"x": "v", "v": "x - x**3/L**2 - c*v + F*cos(omega*t)"}
    runs = []
    for unit in (1.0, scale):
        p = {"L": unit, "c": 0.1, "F": 0.5 * unit, "omega": 1.2, "s": 0.9 * unit, "r": 0.8}
        system = one_mode(flow, [stop], parameters=p)
        runs.append(ns.simulate(system, {"x": 0.1 * unit}, times=np.linspace(0.0, 20.0, 21)))
    one, other = runs
    assert one.attrs["n_events"] == other.attrs["n_events"] >= 3
    assert np.allclose(other["x"].values / scale, one["x"].values, rtol=0, atol=1e-11)
    assert np.allclose(other["event_time"].values, one["event_time"].values, rtol=0, atol=1e-11)


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1e4, 1e9])
def test_units_of_time_change_nothing(scale):
    """The same oscillator, its clock running faster or slower by a power of two."""
    scale = 2.0 ** round(math.log2(scale))
    stop = ns.Exit("s - x", reset={"v": "-r*v"}, name="impact")
    flow = {"x": "v", "v": "k**2*(x - x**3 + F*cos(k*omega*t)) - c*k*v"}
    runs = []
    for k in (1.0, scale):
        p = {"k": k, "c": 0.1, "F": 0.5, "omega": 1.2, "s": 0.9, "r": 0.8}
        system = one_mode(flow, [stop], parameters=p)
        runs.append(ns.simulate(system, {"x": 0.1}, times=np.linspace(0.0, 20.0, 21) / k))
    one, other = runs
    assert one.attrs["n_events"] == other.attrs["n_events"] >= 3
    assert np.allclose(other["x"].values, one["x"].values, rtol=0, atol=1e-11)
    assert np.allclose(
        other["event_time"].values * scale, one["event_time"].values, rtol=0, atol=1e-11
    )


def test_phases_do_not_drift():
    """u' = (sin(t)^2 - 1/2) exp(-u): exp(u) + sin(2 t)/4 stays what it was, whatever the time."""
    system = one_mode(
        {"u": "(sin(omega*t)**2 - 1/2)*exp(-u)"}, parameters={"omega": 1.0}, period="2*pi/omega"
    )
    times = np.array([0.0, 1.0, 1e3, 1e4 + 0.5])
    run = ns.simulate(system, {"u": 1.0}, times=times)
    expected = np.log(math.e - np.sin(2 * times) / 4)
    assert np.allclose(run["u"].values, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("flow", ["x**2", "exp(x)*exp(-1)"])
def test_a_run_to_infinity_in_finite_time_says_so(flow):
    """Both are infinite at time 1; the run must end there, with what was computed until then."""
    system = one_mode({"x": flow})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = ns.simulate(system, {"x": 1.0}, times=[0.0, 0.5, 0.9, 2.0])
    assert run.attrs["status"] in ("singular", "diverged")
    assert run.sizes["time"] == 3
    expected = {"x**2": 1 / (1 - 0.9), "exp(x)*exp(-1)": 1 - math.log(1 - 0.9)}[flow]
    assert float(run["x"][-1]) == pytest.approx(expected, rel=1e-13)
