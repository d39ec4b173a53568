"""Friction on the massless ring: rest in closed form, turned starts, and a light ring."""

from itertools import pairwise

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import massive_ring_rotor, rotor, snubber_rub

SHORT = {"periods": 0.01}


@pytest.mark.parametrize("f", [0.0, 0.1, 0.6])
@pytest.mark.parametrize("angle", np.linspace(0.2, 6.2, 4))
@pytest.mark.parametrize(("springs", "radius"), [(2, 1.04), (1, 1.3)])
def test_ring_stands_off_the_normal_by_the_angle_of_friction(f, angle, springs, radius):
    """a s = mu (n + f t) and r = s + n give |r|^2 = (1 + mu/a)^2 + (f mu/a)^2."""
    delta = 0.1 if springs == 2 else 0.0
    ratio = (-1 + np.sqrt(1 + (1 + f**2) * (radius**2 - 1))) / (1 + f**2)  # mu/a
    r = radius * np.exp(1j * angle)
    n = r / (1 + ratio * (1 + 1j * f))
    s = r - n
    start = {"x": r.real, "y": r.imag, "vx": 0.3 * n.real, "vy": 0.3 * n.imag}
    system = snubber_rub(f=f, delta_x=delta, delta_y=delta)
    run = ns.simulate(system, start, **SHORT)
    assert abs(run["sx"][0] + 1j * run["sy"][0] - s) < 1e-14
    assert abs(float(run["mu"][0]) - springs * ratio) < 1e-13
    quiet = snubber_rub(f=f, delta_x=delta, delta_y=delta, nu2=1e-9)
    run = ns.simulate(quiet, start, **SHORT)
    force = complex(run["force_x"][0], run["force_y"][0]) / n
    assert force.imag == pytest.approx(f * force.real, abs=1e-6)


def test_without_friction_it_is_the_rotor():
    one, two = (ns.simulate(system, periods=20) for system in (rotor(), snubber_rub(f=0)))
    assert one.attrs["n_events"] == two.attrs["n_events"] > 20
    # rounding of other sums, times the growth of the tangent over twenty periods
    assert np.abs(one["x"].values - two["x"].values).max() < 1e-11


@pytest.mark.slow
def test_without_friction_its_ring_rides_as_that_of_the_rotor():
    words = {"delta_x": 0.1, "delta_y": 0.0}
    one, two = (
        ns.simulate(system, periods=10) for system in (rotor(**words), snubber_rub(f=0, **words))
    )
    assert "riding" in ns.phase_word(one) and ns.phase_word(one) == ns.phase_word(two)
    # rounding of other sums, times the growth of the tangent
    assert np.abs(one["x"].values - two["x"].values).max() < 1e-10


@pytest.mark.parametrize("delta", [0.0, 0.1])
def test_a_quarter_turn_is_a_quarter_turn(delta):
    """The springs are alike in x and y, so motions turn with their start and eccentricity."""
    words = {"delta_x": delta, "delta_y": delta, "eta": 2.0}
    base = ns.simulate(snubber_rub(**words, eps_x=0.9, eps_y=0.1), t_end=10)
    for k in range(1, 4):
        turn = 1j**k
        eps = (0.9 + 0.1j) * turn
        system = snubber_rub(**words, eps_x=eps.real, eps_y=eps.imag, phi0=k * np.pi / 2)
        run = ns.simulate(system, t_end=10)
        z, w = (d["x"].values + 1j * d["y"].values for d in (base, run))
        assert base.attrs["n_events"] > 4
        assert np.abs(w - turn * z).max() < 1e-11


def test_a_light_ring_with_friction_comes_to_the_same_motion():
    """Two bodies with impulses and constraint forces against a relation solved at each instant."""
    words = {"eta": 2.0, "f": 0.1}
    exact = ns.simulate(snubber_rub(**words), t_end=4)
    off = []
    for m_s in (1e-3, 1e-4, 1e-5):
        run = ns.simulate(massive_ring_rotor(**words, m_s=m_s), t_end=4)
        off.append(np.hypot(*(float(run[q][-1] - exact[q][-1]) for q in "xy")))
    assert all(7 < a / b < 13 for a, b in pairwise(off))


def test_rolling_stops_the_run():
    words = {"eps_x": 0.0, "eta_m": 0.0, "nu1": 0.01, "delta_x": 0.2, "delta_y": 0.2}
    system = snubber_rub(**words, radius=2.0, f=0.3)
    start = {"x": 1.1, "vy": -4.0}
    run = ns.simulate(system, start, periods=50)
    assert run.attrs["status"] == "stopped"
    assert run["event_name"].values[-1] == "rolling"
    end = float(run["event_time"][-1])
    before = ns.simulate(system, start, times=[end - 1e-3, end - 1e-6])["slip"].values
    assert before[0] > before[1] > 0
    assert before[1] < 1e-4


@pytest.mark.parametrize(("argument", "value"), [("f", -0.1), ("radius", 0), ("nu2", 0)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        snubber_rub(**{argument: value})


def test_rolling_is_not_read_in_a_cell_of_no_width():
    """Without preload a run from one spring to its opposite passes a cell with both at once."""
    system = ns.models.snubber_rub(eta=3.0, delta_x=0.0, delta_y=0.0, radius=4.0, f=0.1)
    for start in ({"x": 0.5, "vy": 0.3}, {"x": -0.3, "vx": 1.0, "vy": -1.0}):
        run = ns.simulate(system, start, periods=60)
        assert run.attrs["status"] == "completed" and run.attrs["n_events"] > 20
        assert float(run["slip"].where(run["force"] > 0).min()) > 0.0
