"""The soft impact oscillator against closed forms of its free and of its linear motion."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.models import soft_impact

EPS = np.finfo(float).eps


def free_period(beta, e, speed):
    """Undamped and unforced, from x = e with a speed: an arc of a circle on either side."""
    with mp.workdps(40):
        beta, e, speed = mp.mpf(beta), mp.mpf(e), mp.mpf(speed)
        stiff = mp.sqrt(1 + beta)
        contact = 2 * mp.atan2(speed / stiff, e - beta * e / (1 + beta)) / stiff
        return float(contact + 2 * mp.pi - 2 * mp.atan2(speed, e))


@pytest.mark.parametrize("e", [-0.5, 0.0, 1.26])
@pytest.mark.parametrize("beta", [-0.75, 0.0, 8.0, 29.0, 1e6])
def test_free_period(beta, e):
    system = soft_impact(zeta=0.0, a=0.0, beta=beta, e=e)
    exact = free_period(beta, e, 0.75)
    run = ns.simulate(system, {"x": e, "v": 0.75}, t_end=10 * exact, mode="contact")
    impacts = run["event_time"].values[run["event_name"].values == "impact"]
    assert len(impacts) in (9, 10)
    # twenty arcs, each with some roundings of a time below 100
    wanted = exact * np.arange(1, len(impacts) + 1)
    assert np.abs(impacts - wanted).max() < 20 * 16 * EPS * 100


def test_without_a_gap_the_frequencies_have_a_harmonic_mean():
    w1, w2 = 1.0, np.sqrt(30.0)
    assert free_period(29.0, 0.0, 1.0) == pytest.approx(
        2 * np.pi * (w1 + w2) / (2 * w1 * w2), rel=1e-15
    )


@pytest.mark.parametrize("omega", [0.6, 0.85, 1.3])
def test_areas_shrink_with_the_damping_alone(omega):
    """Liouville: the derivative of the map over time T has the determinant exp(-2 zeta T)."""
    zeta = 0.02
    run = ns.simulate(
        soft_impact(omega=omega, zeta=zeta, e=0.4), periods=6, samples_per_period=1, tangent=True
    )
    assert run.attrs["n_events"] > 6
    for time, tangent in zip(run["time"].values, run["tangent"].values, strict=True):
        exact = np.exp(-2 * zeta * time)
        # the determinant is a difference of products of entries, each off by some roundings
        assert abs(np.linalg.det(tangent) - exact) < 200 * EPS * np.abs(tangent).max() ** 2


@pytest.mark.parametrize("omega", [0.3, 2.5])
def test_without_contact_the_response_is_linear(omega):
    a, zeta, e = 0.3, 0.1, 1.26
    response = a * omega**2 / (1 - omega**2 + 2j * zeta * omega)
    start = {"x": response.imag, "v": (1j * omega * response).imag}
    run = ns.simulate(soft_impact(omega=omega, zeta=zeta, a=a, e=e), start, periods=20)
    exact = (response * np.exp(1j * omega * run["time"].values)).imag
    assert abs(response) < e
    assert run.attrs["n_events"] == 0
    assert np.abs(run["x"].values - exact).max() < 1e-13


def test_grazing_amplitude_separates_contact_from_none():
    """The linear response touches the stop at a = e |1 - w^2 + 2 i zeta w| / w^2."""
    omega, zeta, e = 0.8, 0.1, 1.26
    graze = e * abs(1 - omega**2 + 2j * zeta * omega) / omega**2
    for factor, touches in ((1 - 1e-9, False), (1 + 1e-9, True)):
        a = graze * factor
        response = a * omega**2 / (1 - omega**2 + 2j * zeta * omega)
        start = {"x": response.imag, "v": (1j * omega * response).imag}
        run = ns.simulate(soft_impact(omega=omega, zeta=zeta, a=a, e=e), start, periods=1)
        assert (run.attrs["n_events"] > 0) == touches


def test_force_of_the_stop_is_zero_when_free_and_never_pulls():
    run = ns.simulate(soft_impact(), periods=100)
    force, x = run["stop_force"].values, run["x"].values
    assert np.all(force[x < 1.26] == 0.0)
    assert np.all(force >= 0.0)
    assert force.max() == pytest.approx(29 * (x.max() - 1.26), rel=1e-13)


@pytest.mark.parametrize(("argument", "value"), [("omega", 0.0), ("zeta", -0.1), ("beta", -1.0)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        soft_impact(**{argument: value})
