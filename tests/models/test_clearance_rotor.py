"""The rotor with clearance: synchronous circles, conserved quantities, areas, and scipy."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import clearance_rotor

EPS = np.finfo(float).eps


def radii(omega, zeta, kappa, rho):
    """Radii of synchronous rub: z = R exp(i (w t - theta)) in the equation of motion gives

    [s R - kappa + 2 i zeta w R] exp(-i theta) = rho w^2 with s = 1 + kappa - w^2, whose
    squared modulus is a quadratic in R.
    """
    s = 1 + kappa - omega**2
    roots = np.roots(
        [s**2 + (2 * zeta * omega) ** 2, -2 * kappa * s, kappa**2 - (rho * omega**2) ** 2]
    )
    return [root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 1]


def on_circle(radius, omega, zeta, kappa, rho):
    """Start of the synchronous motion with this radius."""
    stretch = kappa * (radius - 1) if radius > 1 else 0.0
    z = radius / (radius * (1 - omega**2 + 2j * zeta * omega) + stretch) * rho * omega**2
    return {"x": z.real, "y": z.imag, "u": (1j * omega * z).real, "v": (1j * omega * z).imag}


@pytest.mark.parametrize("omega", [0.2, 0.45, 3.0])
def test_free_whirl_is_the_linear_response(omega):
    words = {"omega": omega, "zeta": 0.06, "kappa": 20.0, "rho": 0.7}
    radius = 0.7 * omega**2 / abs(1 - omega**2 + 2j * 0.06 * omega)
    assert radius < 1
    run = ns.simulate(clearance_rotor(**words), on_circle(radius, **words), periods=10)
    assert run.attrs["n_events"] == 0
    assert np.abs(run["radius"].values - radius).max() < 1e-13
    assert np.all(run["ring_force"].values == 0.0)


@pytest.mark.parametrize(
    ("omega", "zeta", "kappa", "rho"),
    [(0.9, 0.06, 20.0, 0.7), (1.5, 0.1, 20.0, 0.7), (0.8, 0.3, 2.0, 1.5), (1.0, 0.2, 0.5, 0.9)],
)
def test_synchronous_rub_stays_on_its_circle(omega, zeta, kappa, rho):
    words = {"omega": omega, "zeta": zeta, "kappa": kappa, "rho": rho}
    radius = max(radii(**words))
    run = ns.simulate(clearance_rotor(**words), on_circle(radius, **words), periods=8, tangent=True)
    multipliers = np.linalg.eigvals(run["tangent"].values[-1])
    assert np.abs(multipliers).max() < 1.0  # the circle is stable
    assert run.attrs["n_events"] == 0
    assert np.abs(run["radius"].values - radius).max() < 1e-11
    assert np.abs(run["ring_force"].values - kappa * (radius - 1)).max() < 1e-11 * kappa


def test_a_free_undamped_rotor_keeps_energy_and_angular_momentum():
    kappa = 20.0
    system = clearance_rotor(zeta=0.0, rho=0.0, kappa=kappa)
    run = ns.simulate(system, {"x": 0.5, "v": 1.4, "u": 1.1}, t_end=100)
    x, u, y, v = (run[name].values for name in "xuyv")
    r = np.hypot(x, y)
    energy = (u**2 + v**2 + r**2 + kappa * np.maximum(r - 1, 0.0) ** 2) / 2
    assert run.attrs["n_events"] > 40
    # some roundings at each of the steps, of which there are a few between two events
    assert np.abs(energy / energy[0] - 1).max() < 1e-13
    assert np.abs((x * v - y * u) / 0.7 - 1).max() < 1e-13


def test_radial_bouncing_has_the_period_of_two_oscillators():
    """On a line through the centre it is the trilinear oscillator with its closed form."""
    kappa, amplitude = 20.0, 1.3
    stiff, centre = np.sqrt(1 + kappa), kappa / (1 + kappa)
    arc = np.arccos((1 - centre) / (amplitude - centre))
    speed = (amplitude - centre) * stiff * np.sin(arc)
    exact = 4 * (arc / stiff + np.arctan2(1.0, speed))
    system = clearance_rotor(zeta=0.0, rho=0.0, kappa=kappa)
    run = ns.simulate(system, {"x": amplitude}, times=[0.0, exact, 5 * exact])
    for i in (1, 2):
        assert abs(float(run["x"][i]) - amplitude) < 1e-13
        assert abs(float(run["u"][i])) < 1e-12
    assert np.all(run["y"].values == 0.0)


def test_volumes_shrink_with_the_damping_alone():
    zeta = 0.06
    run = ns.simulate(clearance_rotor(zeta=zeta), periods=3, samples_per_period=1, tangent=True)
    assert run.attrs["n_events"] >= 3
    for time, tangent in zip(run["time"].values, run["tangent"].values, strict=True):
        bound = 500 * EPS * max(1.0, np.abs(tangent).max()) ** 4
        assert abs(np.linalg.det(tangent) - np.exp(-4 * zeta * time)) < bound


def test_rubbing_against_scipy():
    """Segment by segment, so that no step of scipy's crosses a kink."""
    omega, zeta, kappa, rho = 0.9, 0.06, 20.0, 0.7

    def field(t, s, rubs):
        z, dz = s[0] + 1j * s[2], s[1] + 1j * s[3]
        push = kappa * (1 - 1 / abs(z)) * z if rubs else 0.0
        a = rho * omega**2 * np.exp(1j * omega * t) - 2 * zeta * dz - z - push
        return [dz.real, a.real, dz.imag, a.imag]

    run = ns.simulate(clearance_rotor(), t_end=15, tangent=True)
    assert run.attrs["n_events"] == 8
    state, cuts = np.zeros(4), [*run["event_time"].values, 15.0]
    for i, (begin, end) in enumerate(pairwise(cuts)):
        # it starts free, and contact and release alternate
        state = solve_ivp(
            field, (begin, end), state, method="DOP853", rtol=1e-13, atol=1e-15, args=(i % 2 == 1,)
        ).y[:, -1]
        if i < run.attrs["n_events"]:
            assert abs(np.hypot(state[0], state[2]) - 1.0) < 1e-12
    growth = np.abs(run["tangent"].values).max()
    # DOP853 is good for some 1e-13 in a segment
    assert np.abs(run["end_state"].values - state).max() < 1e-12 * growth


@pytest.mark.parametrize(("argument", "value"), [("omega", 0), ("zeta", -0.1), ("kappa", -1)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        clearance_rotor(**{argument: value})
