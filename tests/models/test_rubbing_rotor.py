"""Dry rub: circles in closed form, onset of dry whip, turned starts, and scipy."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import clearance_rotor, rubbing_rotor


def as_start(z, dz):
    return {"x": z.real, "y": z.imag, "vx": dz.real, "vy": dz.imag}


def synchronous_circle(omega, zeta, kappa, rho, f):
    """Largest radius and start of z = R exp(i(w t - phase)) with friction against the rotation.

    (s R - kappa) + i (2 zeta w R + f kappa (R - 1)) = rho w^2 exp(i phase), s = 1 + kappa - w^2.
    """
    s, g = 1 + kappa - omega**2, 2 * zeta * omega + f * kappa
    real, imaginary = [s, -kappa], [g, -f * kappa]
    square = np.polyadd(np.polymul(real, real), np.polymul(imaginary, imaginary))
    radius = max(np.roots(np.polysub(square, [(rho * omega**2) ** 2])).real)
    phase = np.angle(np.polyval(real, radius) + 1j * np.polyval(imaginary, radius))
    return radius, radius * np.exp(-1j * phase)


def whip_circle(zeta, kappa, f):
    """Radius and frequency of the whirl that friction and damping hold in balance."""
    p = 2 * zeta * (zeta + np.hypot(zeta, f)) / f**2  # f p = 2 zeta sqrt(1 + p)
    return 1 / (1 - p / kappa), -np.sqrt(1 + p)


def onset(zeta, kappa):
    return 2 * zeta * np.sqrt(1 + kappa) / kappa


@pytest.mark.parametrize(
    ("omega", "zeta", "kappa", "rho", "f"),
    [(1.5, 0.1, 20.0, 0.7, 0.05), (0.9, 0.3, 20.0, 1.5, 0.2), (0.8, 0.3, 2.0, 2.5, 0.3)],
)
def test_synchronous_rub_with_friction_stays_on_its_circle(omega, zeta, kappa, rho, f):
    radius, z = synchronous_circle(omega, zeta, kappa, rho, f)
    assert radius > 1
    system = rubbing_rotor(omega, zeta, kappa, rho, f)
    run = ns.simulate(system, as_start(z, 1j * omega * z), periods=4, tangent=True)
    assert run.attrs["n_events"] == 0
    growth = np.abs(run["tangent"].values).max()
    assert np.abs(run["radius_of_whirl"].values - radius).max() < 1e-12 * growth
    assert np.abs(run["whirl"].values - omega).max() < 1e-12 * growth
    normal = kappa * (radius - 1)
    assert run["normal_force"][-1] == pytest.approx(normal, rel=1e-11 * growth)
    assert run["friction"][-1] == pytest.approx(-f * normal, rel=1e-11 * growth)


@pytest.mark.parametrize("f", [0.1, 0.3])
def test_balanced_whirl_is_a_circle_faster_than_the_natural_frequency(f):
    zeta, kappa = 0.06, 20.0
    radius, frequency = whip_circle(zeta, kappa, f)
    system = rubbing_rotor(zeta=zeta, kappa=kappa, rho=0, f=f, omega=1.0)
    turns = 2 * np.pi / abs(frequency) * np.arange(3)
    start = as_start(radius + 0j, 1j * frequency * radius)
    run = ns.simulate(system, start, times=turns, tangent=True)
    growth = np.abs(run["tangent"].values).max()
    z = run["x"].values + 1j * run["y"].values
    assert np.abs(z - radius).max() < 1e-13 * growth
    assert np.abs(np.linalg.eigvals(run["tangent"].values[-1])).max() > 1  # a threshold


def test_dry_whip_begins_at_the_known_friction():
    """Whirl fast enough at first fades below 2 zeta sqrt(1 + kappa)/kappa and grows above."""
    zeta, kappa = 0.06, 20.0
    fast = np.sqrt(1 + kappa)
    start = as_start(40.0 + 0j, -40j * fast)  # p = kappa (1 - 1/40), nearly kappa
    grown = {}
    for factor in (0.97, 1.06):
        system = rubbing_rotor(1.0, zeta, kappa, 0.0, factor * onset(zeta, kappa), radius=1e4)
        run = ns.simulate(system, start, t_end=10.0)
        assert run.attrs["status"] == "completed"
        grown[factor] = float(run["radius_of_whirl"][-1])
    assert grown[0.97] < 39.9
    assert grown[1.06] > 40.1


def test_whip_ends_in_rolling():
    """Rolling: (1 + kappa) R^2 - kappa R = (omega R_s)^2, with the friction -2 zeta omega R_s.

    In the frame that turns with it r'' = (omega R_s)^2/r - 2 zeta r' - r - kappa (r - 1), so what
    is left of the approach falls by exp(-zeta t).
    """
    zeta, kappa, f, surface = 0.06, 20.0, 0.2, 12.0
    system = rubbing_rotor(1.0, zeta, kappa, rho=0.0, f=f, radius=surface)
    run = ns.simulate(system, as_start(1.5 + 0j, -4j), t_end=400)
    assert run.attrs["status"] == "completed"
    assert ns.phase_word(run) == ("forward_slip", "rolling")
    assert run["event_kind"].values.tolist() == ["start", "slide_entry"]
    names = run["mode"].attrs["flag_meanings"].split()
    rolls = run["mode"].values == names.index("rolling")
    assert np.abs(run["slip"].values[rolls]).max() < 1e-12
    assert (np.abs(run["friction"]) <= f * run["normal_force"] * (1 + 1e-12)).all()
    radius = (kappa + np.sqrt(kappa**2 + 4 * (1 + kappa) * surface**2)) / (2 * (1 + kappa))
    left = 10 * np.exp(-zeta * (400 - run["event_time"].values[1]))
    assert abs(run["radius_of_whirl"].values[-1] - radius) < left
    assert abs(run["friction"].values[-1] + 2 * zeta * surface) < 5 * left  # kappa r' among others
    assert abs(run["whirl"].values[-1] + surface / radius) < left


def test_rolling_ends_where_it_would_take_more_than_friction_can_give():
    """Across the normal: T = -w R_s (r'/r + 2 zeta) - rho w^2 sin(w t - angle) while it rolls."""
    omega, zeta, rho, f, surface = 1.0, 0.06, 0.7, 0.1, 12.0
    system = rubbing_rotor(omega, zeta, rho=rho, f=f, radius=surface)
    run = ns.simulate(system, as_start(1.5 + 0j, -8.4j), t_end=60)
    assert run.attrs["status"] == "completed"

    def needed(t, x, y, vx, vy):
        r = np.hypot(x, y)
        drift = (x * vx + y * vy) / r**2
        across = rho * omega**2 * np.sin(omega * t - np.arctan2(y, x))
        return -omega * surface * (drift + 2 * zeta) - across

    rolls = run["mode"].values == run["mode"].attrs["flag_meanings"].split().index("rolling")
    shown = needed(run["time"].values, *(run[name].values for name in ("x", "y", "vx", "vy")))
    # forces of some tens cancel in the rates
    assert np.allclose(run["friction"].values[rolls], shown[rolls], rtol=0, atol=1e-11)
    assert (np.abs(shown[rolls]) <= f * run["normal_force"].values[rolls] + 1e-11).all()
    exits = np.flatnonzero(run["event_kind"].values == "slide_exit")
    assert len(exits) >= 2
    for k in exits:
        state = run["state_before"].values[k]
        normal = 20.0 * (np.hypot(state[0], state[1]) - 1)
        taken = abs(needed(run["event_time"].values[k], *state))
        assert taken == pytest.approx(f * normal, rel=1e-10)


def test_friction_has_its_direction_at_every_angle():
    """Without unbalance there is no first angle: a turned start gives the turned motion."""
    system = rubbing_rotor(1.0, rho=0.0, f=0.15)
    first = ns.simulate(system, as_start(0.5 + 0.2j, 0.9 - 2.0j), t_end=12)
    assert first.attrs["n_events"] > 5
    for turn in np.exp(1j * np.array([0.7, np.pi / 2, 2.5, np.pi, 4.4])):
        other = ns.simulate(system, as_start((0.5 + 0.2j) * turn, (0.9 - 2.0j) * turn), t_end=12)
        z, w = (run["x"].values + 1j * run["y"].values for run in (first, other))
        assert np.abs(w - z * turn).max() < 1e-11


def test_without_friction_it_is_the_clearance_rotor():
    smooth = ns.simulate(clearance_rotor(), periods=10)
    dry = ns.simulate(rubbing_rotor(f=0), periods=10)
    assert smooth.attrs["n_events"] == dry.attrs["n_events"] > 5
    assert np.abs(smooth["x"].values - dry["x"].values).max() < 1e-11


def test_reversals_of_slip_against_scipy():
    """A small shaft and little friction: the slip changes sign and motion goes on."""
    omega, zeta, kappa, rho, f, radius = 0.9, 0.06, 20.0, 0.7, 0.05, 1.0

    def field(t, s, cell):
        z, dz = s[0] + 1j * s[1], s[2] + 1j * s[3]
        sign = {"free": 0, "forward_slip": 1, "backward_slip": -1}[cell]
        push = 0.0 if cell == "free" else kappa * (1 - 1 / abs(z)) * z * (1 + 1j * f * sign)
        a = rho * omega**2 * np.exp(1j * omega * t) - 2 * zeta * dz - z - push
        return [dz.real, dz.imag, a.real, a.imag]

    system = rubbing_rotor(omega, zeta, kappa, rho, f, radius)
    run = ns.simulate(system, {"x": 0.5, "vy": -2.5}, t_end=6, tangent=True)
    words = ns.phase_word(run)
    assert {"forward_slip", "backward_slip"} <= set(words)
    state, cuts = np.array([0.5, 0.0, 0.0, -2.5]), [0.0, *run["event_time"].values, 6.0]
    cuts = [0.0, *(t for t in cuts[1:-1] if t > 0), 6.0]
    for (begin, end), cell in zip(pairwise(cuts), words, strict=True):
        state = solve_ivp(
            field, (begin, end), state, method="DOP853", rtol=1e-13, atol=1e-15, args=(cell,)
        ).y[:, -1]
    growth = np.abs(run["tangent"].values).max()
    assert np.abs(run["end_state"].values - state).max() < 1e-12 * growth


@pytest.mark.parametrize(
    ("argument", "value"),
    [("omega", 0), ("zeta", -0.1), ("kappa", -1), ("f", -0.1), ("radius", 0)],
)
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        rubbing_rotor(**{argument: value})
