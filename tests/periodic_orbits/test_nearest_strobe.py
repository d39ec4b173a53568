"""An orbit of several periods is told from the one of its strobes that is nearest to the start."""

import numpy as np
import pytest

import nonsmooth as ns

B = 0.1  # the mole's motion has two periods there
OMEGA = 0.1
FREE = ("p", "y", "q")


def turned_mole(time):
    """The mole with its forcing turned such that its phase zero is at some time."""
    return ns.models.moling(b=B, phi=float(np.pi / 2 + OMEGA * time))


def scaled_distances(points, start):
    """Distances of points of an orbit from a start, each state beside its size."""
    sizes = {n: max(np.abs(points[n].values).max(), abs(start[n])) for n in FREE}
    away = [(points[n].values - start[n]) / (sizes[n] or 1.0) for n in FREE]
    return np.linalg.norm(away, axis=0)


@pytest.mark.parametrize("ahead", [0.2, 0.5])
@pytest.mark.parametrize("impact", [0, 1])
def test_a_start_in_another_mode_than_the_strobe(impact, ahead):
    """Strobes just before an impact; the start lies behind it, where the slider progresses."""
    mole = ns.models.moling(b=B)
    orbit = ns.find_orbit(mole, period=2)
    hits = (orbit["leg_time"] + orbit["durations"]).values[orbit["leg_exit"].values == "impact"]
    there = ns.simulate(mole, orbit, times=[0.0, hits[impact] + ahead]).isel(time=-1)
    start = {name: float(there[name]) for name in FREE}
    turned = turned_mole(hits[impact] - 1e-3)
    found = ns.find_orbit(turned, start, period=2)
    assert found.attrs["status"] == "completed"
    points = ns.stroboscopic_map(turned, found, record=2)
    near, far = scaled_distances(points, start)
    assert near < far
    # the same orbit whatever strobe it is told from
    assert found["multipliers"].values == pytest.approx(orbit["multipliers"].values, abs=1e-9)
    assert float(found["v_per_period"]) == pytest.approx(float(orbit["v_per_period"]), abs=1e-9)


@pytest.mark.parametrize("strobe", range(5))
def test_every_strobe_of_an_orbit_is_told_from_itself(strobe):
    system = ns.models.soft_impact()
    orbit = ns.find_orbit(system, period=5)
    points = ns.stroboscopic_map(system, orbit, record=5)
    start = {name: float(points[name][strobe]) for name in system.states}
    found = ns.find_orbit(system, start, period=5)
    for name in system.states:
        assert float(found[name]) == pytest.approx(start[name], abs=1e-12)


def test_strobes_of_a_turn_are_those_of_the_motion():
    """A run, which computes each period anew, meets them to rounding; drifts go on."""
    for system, period in ((ns.models.soft_impact(), 5), (ns.models.moling(b=B), 2)):
        orbit = ns.find_orbit(system, period=period)
        run = ns.simulate(system, orbit, periods=period - 1, samples_per_period=1)
        motion = np.column_stack([run[name].values for name in system.states])
        np.testing.assert_allclose(orbit["strobes"].values, motion, rtol=0, atol=1e-12)


def test_strobes_of_an_orbit_without_forcing_are_none():
    assert "strobes" not in ns.find_orbit(ns.models.belt_oscillator())


@pytest.mark.parametrize("later", range(5))
def test_legs_of_a_later_strobe_solve_the_same_equations(later):
    """The rotated legs close without a step of Newton's method, at the strobe of the engine."""
    from nonsmooth.analysis.options import SharedOptions
    from nonsmooth.analysis.orbit_search.options import read_wanted
    from nonsmooth.periodic_orbits.guess import from_nearest_strobe
    from nonsmooth.periodic_orbits.legs import Legs
    from nonsmooth.periodic_orbits.search import search_orbit, solve_guess

    system = ns.models.soft_impact()
    wanted, _ = read_wanted(
        system, None, SharedOptions(), period=5, word=None, transient=None, phase=0.0,
        verb="find_orbit",
    )  # fmt: skip
    legs = Legs(system)
    legs.set_values(system.parameter_values)
    found = search_orbit(wanted, legs)
    orbit = found.orbit
    initial = dict(zip(system.states, orbit.turn.states[0], strict=True))
    points = ns.stroboscopic_map(system, initial, record=5)
    strobe = np.array([float(points[name][later]) for name in system.states])
    guess = from_nearest_strobe(found.equations, orbit.turn, strobe)
    assert (guess is None) == (later == 0)
    if guess is not None:
        turned = solve_guess(wanted, legs, guess).orbit
        assert turned.turn.states[0] == pytest.approx(strobe, abs=1e-12)
        assert turned.residual < 1e-12
        assert len(turned.word) == len(orbit.word)
