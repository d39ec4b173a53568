"""Orbits that are not alone, as where nothing fixes the amplitude, against closed forms."""

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from periodic_orbits.test_sliding_orbits import belt


def oscillator(force: str, **more) -> ns.System:
    return ns.System(states=["x", "v"], equations={"x": "v", "v": force}, **more)


def found(system: ns.System, **initial: float):
    orbit = ns.find_orbit(system, initial)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert "nothing fixes its amplitude" in orbit.attrs["message"]
    assert not bool(orbit["stable"]) and bool(orbit["admissible"])
    # double, and the root of the rounding of its equations: 1e-16^(1/2)
    np.testing.assert_allclose(orbit["multipliers"].values, [1.0], atol=1e-7)
    return orbit


@pytest.mark.parametrize(
    "start", [{"x": 0.5, "v": 0.2}, {"x": 0.5, "v": 0.0}, {"x": 0.4, "v": 0.1}]
)
def test_circles_on_a_belt_that_never_stick(start):
    """Friction is constant while the mass is slower than the belt: a circle about x = F_k."""
    orbit = found(belt(), **start)
    assert orbit["word"].item() == "lag"
    assert float(orbit["length"]) == pytest.approx(2 * np.pi, rel=1e-14)
    assert float(orbit["x"]) == start["x"] and float(orbit["v"]) == start["v"]


def test_a_duffing_oscillator_without_damping():
    """Its period is 4 K(m)/sqrt(1 + A^2) with m = A^2/(2 + 2 A^2)."""
    orbit = found(oscillator("-x - x**3"), x=0.7, v=0.0)
    with mp.workdps(30):  # the amplitude of the orbit by its energy
        energy = sum(
            c * mpf(float(orbit[k])) ** n for k, n, c in (("x", 2, 2), ("x", 4, 1), ("v", 2, 2))
        )
        a = mp.sqrt(1 + energy) - 1
        period = 4 * mp.ellipk(a / (2 * (1 + a))) / mp.sqrt(1 + a)
    assert float(orbit["length"]) == pytest.approx(float(period), rel=1e-13)


def test_two_springs():
    """Half a turn of the first, and of the second one behind x = 0 twice as fast."""
    orbit = found(oscillator("-x - 3*max(x, 0)"), x=0.9, v=0.0)
    assert float(orbit["length"]) == pytest.approx(1.5 * np.pi, rel=1e-13)


def test_impacts_that_lose_nothing():
    wall = ns.Exit("0.5 - x", reset={"v": "-v"}, name="impact")
    system = ns.System(states=["x", "v"], modes={"free": ns.Mode({"x": "v", "v": "-x"}, [wall])})
    orbit = found(system, x=-0.8, v=0.0)
    assert float(orbit["length"]) == pytest.approx(2 * (np.pi - np.arccos(0.5 / 0.8)), rel=1e-9)


def test_a_fold_is_no_family():
    """Two cycles of r' = r (mu - (r^2 - 1)^2) meet at mu = 0: the one there is alone."""
    system = ns.System(
        states=["x", "y"],
        equations={
            "x": "-y - x*(x**2 + y**2 - 1)**2",
            "y": "x - y*(x**2 + y**2 - 1)**2",
        },
    )
    orbit = ns.find_orbit(system, {"x": 1.0})
    assert "nothing fixes its amplitude;" not in orbit.attrs["message"]


@pytest.mark.parametrize("damping", [1e-2, 1e-5, -1e-5])
def test_a_motion_that_decays_is_no_orbit(damping):
    orbit = ns.find_orbit(oscillator(f"-x - {damping}*v"), {"x": 1.0})
    assert orbit.attrs["status"] != "completed"
    assert "at rest" in orbit.attrs["message"] or "period 1" in orbit.attrs["message"]


def jenkins(force: float) -> ns.System:
    """A mass on a spring beside a spring in series with a slider that holds 12 N."""
    rate = "(F*cos(55*t) - 4000*x - 3*v - q)/2.5"
    slips = {"x": "v", "v": rate, "q": "0"}
    return ns.System(
        states=["x", "v", "q"], parameters={"F": force}, period="2*pi/55",
        modes={
            "stick": ns.Mode(
                {"x": "v", "v": rate, "q": "9000*v"},
                exits=[ns.Exit("12 - q", to="up"), ns.Exit("q + 12", to="down")],
            ),
            "up": ns.Mode(slips, exits=[ns.Exit("v", to="stick")]),
            "down": ns.Mode(slips, exits=[ns.Exit("-v", to="stick")]),
        },
    )  # fmt: skip


def test_a_slider_that_sticks_keeps_its_place():
    """There q - 9000 x is conserved, and any value of it makes an orbit."""
    receptance = 1.0 / (4000.0 + 9000.0 - 2.5 * 55.0**2 + 3.0j * 55.0)
    touch = 12.0 / (9000.0 * abs(receptance))
    slips = ns.continue_orbit(jenkins(10.0), "F", (2.0, 12.0), direction="down")
    assert slips.attrs["end_first"] == "bound"
    assert slips["special_kind"].values.tolist() == ["bound", "grazing"]
    # the place is that in which the last slips leave it, which last a thousandth of a turn
    assert slips["special_value"].values[1] == pytest.approx(touch, rel=1e-7)
    for start in ({}, {"q": 3.0}):
        begin = ns.find_orbit(jenkins(2.0), start)
        branch = ns.continue_orbit(jenkins(2.0), "F", (1.0, 4.0), initial=begin)
        assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
        place = branch["q"].values - 9000.0 * branch["x"].values
        np.testing.assert_allclose(place, place[0], atol=1e-10)
        response = branch["F"].values * receptance.real
        hung = -place[0] / (4000.0 + 9000.0)
        np.testing.assert_allclose(branch["x"].values, response + hung, atol=1e-12)
