"""Samples of orbits: how many, of which orbit, and that they lie on a known motion."""

import numpy as np
import pytest

import nonsmooth as ns


@pytest.fixture(scope="module")
def branch():
    return ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.15, 0.52), steps=40)


def test_a_turn_of_one_leg_is_smooth():
    """A steady oscillation, known in closed form; each piece turns by less than two degrees."""
    system = ns.models.soft_impact(a=0.2)
    samples = ns.orbit_samples(ns.find_orbit(system))
    assert samples.sizes["time"] == 201
    omega, zeta, a = (float(system.parameters[name]) for name in ("omega", "zeta", "a"))
    steady = a * omega**2 / np.hypot(1 - omega**2, 2 * zeta * omega)
    x, v = samples["x"].values[0], samples["v"].values[0]
    assert np.hypot(x, v / omega) == pytest.approx(steady, rel=1e-11)
    angle = omega * samples["time"].values
    np.testing.assert_allclose(
        samples["x"], x * np.cos(angle) + v / omega * np.sin(angle), atol=1e-11
    )


def test_long_legs_have_more_samples(branch):
    orbit = branch.isel(point=-1)
    samples = ns.orbit_samples(orbit)
    counts = np.bincount(samples["leg"].values) - 1
    durations = orbit["durations"].values[: counts.size]
    share = np.ceil(200 * durations / durations.sum())
    assert counts.size == 3
    np.testing.assert_array_equal(counts, np.maximum(share, 50))
    fixed = ns.orbit_samples(orbit, per_leg=7)
    np.testing.assert_array_equal(np.bincount(fixed["leg"].values), [8, 8, 8])


def test_two_periods_have_twice_as_many():
    twice = ns.find_orbit(ns.models.soft_impact(a=0.2), period=2)
    assert ns.orbit_samples(twice).sizes["time"] == 401


def test_refusals(branch):
    count = branch.sizes["point"]
    with pytest.raises(ns.OptionError, match=rf"{count} orbits.*branch.isel\(point=3\)"):
        ns.orbit_samples(branch)
    with pytest.raises(ns.OptionError, match="give a result of find_orbit"):
        ns.orbit_samples(3)
    with pytest.raises(ns.OptionError, match="per_leg = True"):
        ns.orbit_samples(branch.isel(point=3), per_leg=True)
    with pytest.raises(ns.OptionError, match="period = True"):
        ns.find_orbit(ns.models.soft_impact(a=0.2), period=True)
