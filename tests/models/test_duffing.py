"""The Duffing oscillator: energy, elliptic functions, areas, and scipy with the force on."""

import numpy as np
import pytest
from mpmath import ellipk, mp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import duffing

EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    ("alpha", "beta", "x"), [(1.0, 1.0, 2.0), (-1.0, 1.0, 1.3), (-1.0, 1.0, 2.0), (1.0, -0.2, 1.5)]
)
def test_energy_is_kept(alpha, beta, x):
    run = ns.simulate(duffing(delta=0, gamma=0, alpha=alpha, beta=beta), {"x": x}, t_end=200)
    X, V = run["x"].values, run["v"].values
    energy = V**2 / 2 + alpha * X**2 / 2 + beta * X**4 / 4
    scale = V**2 / 2 + abs(alpha) * X**2 / 2 + abs(beta) * X**4 / 4
    assert np.abs(energy - energy[0]).max() < 1e-13 * scale.max()
    assert np.abs(run["energy"].values - energy).max() < 4 * EPS * scale.max()


def hardening(alpha, beta, a):
    return 4 * ellipk(beta * a**2 / (2 * (alpha + beta * a**2))) / mp.sqrt(alpha + beta * a**2)


def in_one_well(alpha, beta, a):
    return 2 * ellipk(2 * (beta * a**2 + alpha) / (beta * a**2)) / (a * mp.sqrt(beta / 2))


def softening(alpha, beta, a):
    square = alpha + beta * a**2 / 2
    return 4 * ellipk(-beta * a**2 / (2 * square)) / mp.sqrt(square)


@pytest.mark.parametrize(
    ("period", "alpha", "beta", "a"),
    [
        (hardening, 1.0, 1.0, 0.1),
        (hardening, 1.0, 1.0, 10.0),
        (hardening, 0.0, 1.0, 1.0),  # (alpha = 0: no linear term at all)
        (hardening, -1.0, 1.0, 1.6),  # over the hump
        (in_one_well, -1.0, 1.0, 1.2),
        (in_one_well, -1.0, 1.0, 1.414),  # nearly to the top of the hump
        (softening, 1.0, -0.2, 1.5),
    ],
)
def test_period_is_an_elliptic_integral(period, alpha, beta, a):
    with mp.workdps(30):
        exact = float(period(mp.mpf(alpha), mp.mpf(beta), mp.mpf(a)))
    system = duffing(delta=0, gamma=0, alpha=alpha, beta=beta)
    run = ns.simulate(system, {"x": a}, times=[0.0, exact, 3 * exact], tangent=True)
    growth = np.abs(run["tangent"].values).max()
    # from rest: an error of the time shows in v only
    for i in (1, 2):
        assert abs(float(run["x"][i]) - a) < 64 * EPS * growth * a
        assert abs(float(run["v"][i])) < 64 * EPS * growth * (1 + abs(alpha * a + beta * a**3))


@pytest.mark.parametrize("parameters", [{}, {"alpha": 1.0, "delta": 0.05}])
def test_areas_shrink_with_the_damping_alone(parameters):
    system = duffing(**parameters)
    run = ns.simulate(system, {"x": 0.2}, periods=5, samples_per_period=1, tangent=True)
    for time, tangent in zip(run["time"].values, run["tangent"].values, strict=True):
        exact = np.exp(-system.parameter_values["delta"] * time)
        assert abs(np.linalg.det(tangent) - exact) < 200 * EPS * np.abs(tangent).max() ** 2


def test_forced_motion_against_scipy():
    def field(t, s):
        return [s[1], 0.5 * np.cos(1.2 * t) - 0.3 * s[1] + s[0] - s[0] ** 3]

    found = solve_ivp(field, (0, 20), [0.2, 0.1], method="DOP853", rtol=1e-13, atol=1e-15)
    run = ns.simulate(duffing(), {"x": 0.2, "v": 0.1}, t_end=20, tangent=True)
    growth = np.abs(run["tangent"].values).max()
    assert np.abs(run["end_state"].values - found.y[:, -1]).max() < 1e-12 * growth


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_bottoms_of_the_wells_are_equilibria(sign):
    system = duffing(gamma=0, alpha=-2.0, beta=0.5)
    run = ns.simulate(system, {"x": 2.0 * sign}, t_end=50)
    assert np.abs(run["x"].values - 2.0 * sign).max() < 16 * EPS


def test_a_softening_spring_lets_go_and_says_so():
    with pytest.warns(ns.RunWarning):
        run = ns.simulate(duffing(alpha=1, beta=-1, gamma=0), {"x": 1.5}, t_end=50)
    assert run.attrs["status"] in ("singular", "diverged")


@pytest.mark.parametrize(("argument", "value"), [("omega", 0.0), ("delta", -0.1)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        duffing(**{argument: value})
