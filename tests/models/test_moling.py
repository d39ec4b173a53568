"""The mole against closed forms and balances that hold for any correct solution."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import moling

EPS = np.finfo(float).eps


def test_first_flight_is_the_closed_form():
    """Before the first impact the mass is free: its motion under the force is elementary."""
    a, b, omega, phi, y0 = 0.3, 0.15, 0.1, 0.7, -0.4
    run = ns.simulate(moling(a=a, b=b, omega=omega, phi=phi), {"p": -5.0, "y": y0}, periods=1)
    t = run["time"].values[run["time"].values < run["event_time"].values[1]]
    n = len(t)
    wave = np.cos(omega * t + phi) - np.cos(phi) + omega * t * np.sin(phi)
    p = -5.0 + y0 * t + b * t**2 / 2 - a / omega**2 * wave
    y = y0 + b * t + a / omega * (np.sin(omega * t + phi) - np.sin(phi))
    # a/omega^2 = 30 and t^2 b/2 < 300 are the largest terms, each rounded some times
    assert n > 10
    assert np.abs(run["p"].values[:n] - p).max() < 300 * 16 * EPS
    assert np.abs(run["y"].values[:n] - y).max() < 30 * 16 * EPS
    assert np.all(run["q"].values[:n] == 0.0)


def test_slider_top_relaxes_exponentially():
    """Free of the mass, the slider's top creeps back by exp(-t / 2 xi)."""
    run = ns.simulate(moling(xi=0.35), {"p": -5.0, "q": 0.8}, t_end=2.0)
    exact = 0.8 * np.exp(-run["time"].values / 0.7)
    assert np.abs(run["q"].values - exact).max() < 8 * EPS


def test_static_force_presses_the_mass_to_equilibrium():
    """With a constant force below the limit the mass comes to rest where the spring holds it."""
    run = ns.simulate(moling(a=0.0, b=0.4, xi=0.5), periods=2)
    assert run["q"].values[-1] == pytest.approx(0.4, abs=1e-12)
    assert run["p"].values[-1] == pytest.approx(0.42, abs=1e-12)
    assert run["slider_force"].values[-1] == pytest.approx(0.4, abs=1e-12)


@pytest.mark.parametrize(("a", "b"), [(0.3, 0.15), (0.3, 0.27), (0.9, 0.3)])
def test_slider_gives_back_the_momentum_of_the_static_force(a, b):
    """Over a period of a periodic motion the mean of the slider's force is the static force."""
    samples = 4000
    settled = ns.simulate(moling(a=a, b=b), periods=60)
    run = ns.simulate(moling(a=a, b=b), settled, periods=1, samples_per_period=samples)
    mean = np.trapezoid(run["slider_force"].values, run["time"].values) / run.attrs["period"]
    # each jump of the force, by 1 at most, is misplaced by half a sample
    assert abs(mean - b) < 0.5 * run.attrs["n_events"] / samples


def test_force_is_between_zero_and_the_limit():
    """Friction limits what the slider can push back, and it cannot pull."""
    for b in (0.05, 0.19, 0.27):
        force = ns.simulate(moling(b=b), periods=50)["slider_force"].values
        assert force.min() >= -4 * EPS
        assert force.max() <= 1.0 + 4 * EPS


def test_progression_never_falls():
    """The slider's bottom yields forward only."""
    for b in (0.05, 0.19, 0.27):
        v = ns.simulate(moling(b=b), periods=50)["v"].values
        assert np.diff(v).min() >= 0.0


@pytest.mark.parametrize(
    ("argument", "value"), [("xi", 0.0), ("xi", -0.1), ("g", -0.01), ("omega", 0.0)]
)
def test_impossible_parameters_are_refused(argument, value):
    """The message names the parameter's condition."""
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        moling(**{argument: value})
