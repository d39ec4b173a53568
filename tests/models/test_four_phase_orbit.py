"""The chapter's minimisation against motions, and against orbits found by Newton's method."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.models import four_phase_misfit, four_phase_orbit, moling, progression_start

WORD = ("progression", "contact", "no_contact", "contact")


def one_period(system, y, psi):
    """A motion that begins with progression at a phase of the forcing."""
    values = system.parameter_values
    q = 1.0 - 2.0 * values["xi"] * y
    start = {"p": q + values["g"], "y": y, "q": q}
    return ns.simulate(system.with_parameters(phi=psi), start, mode="progression", periods=1)


@pytest.mark.parametrize("b", [0.1, 0.15])
def test_misfit_is_that_of_a_motion_of_four_phases(b):
    system = moling(b=b)
    y, psi = {0.1: (5.81, 1.951), 0.15: (7.24, 1.162)}[b]
    run = one_period(system, y, psi)
    assert tuple(ns.phase_word(run, 0.0, 20 * np.pi)) == WORD
    p, velocity = run["p"].values, run["y"].values
    expected = np.hypot(p[-1] - p[0], velocity[-1] - velocity[0])
    assert expected > 1e-3
    assert four_phase_misfit(system, y, psi) == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
def test_minimum_is_the_orbit():
    """Two constructions of one orbit that share no code: a minimum, and a root."""
    system = moling()
    found = four_phase_orbit(system).isel(minimum=0)
    orbit = ns.find_orbit(system)
    start = progression_start(orbit)
    assert found["F"] < 1e-12 and found["admissible"]
    for name in ("y_0", "x_0", "psi_0"):
        assert found[name].item() == pytest.approx(start[name].item(), abs=1e-10)
    assert found["v_per_period"].item() == pytest.approx(orbit["v_per_period"].item(), abs=1e-10)
    legs = orbit["durations"].values
    assert np.allclose(found["durations"], [legs[0] + legs[4], *legs[1:4]], atol=1e-10)


@pytest.mark.slow
def test_both_orbits_below_the_fold():
    """A stable orbit and its unstable partner, both four phases and both motions for a period."""
    system = moling(b=0.155)
    found = four_phase_orbit(system)
    both = found.isel(minimum=found["admissible"].values)
    assert both.sizes["minimum"] == 2
    for k in range(2):
        each = both.isel(minimum=k)
        run = one_period(system, each["y_0"].item(), each["psi_0"].item())
        assert tuple(ns.phase_word(run, 0.0, 62.8)) == WORD
        assert np.allclose(run["p"][-1], run["p"][0], atol=1e-6)


@pytest.mark.slow
def test_closed_constructions_that_are_no_motions_are_labelled():
    """The force passes the limit inside phase IV: the motion progresses there instead."""
    system = moling(b=0.17)
    found = four_phase_orbit(system, guess=(1.0, 2.85))
    assert found.attrs["status"] == "completed"
    closed = found.isel(minimum=found["closes"].values)
    assert closed.sizes["minimum"] >= 1 and not closed["admissible"].any()
    each = closed.isel(minimum=0)
    run = one_period(system, each["y_0"].item(), each["psi_0"].item())
    assert tuple(ns.phase_word(run, 0.0, 62.8)) != WORD


@pytest.mark.slow
def test_no_orbit():
    """Near resonance and above, the mole only vibrates in contact."""
    found = four_phase_orbit(moling(a=0.5, b=0.15, xi=0.01, omega=1.0))
    assert found.attrs["status"] == "no_orbit"
    assert not found["closes"].any() and np.all(found["F"] > 1e-3)


@pytest.mark.slow
def test_guess_from_a_neighbour():
    near = four_phase_orbit(moling(b=0.149), progression_start(ns.find_orbit(moling())))
    assert near.sizes["minimum"] == 1
    expected = ns.find_orbit(moling(b=0.149))["v_per_period"].item()
    assert near["v_per_period"].item() == pytest.approx(expected, abs=1e-9)


def test_construction_that_does_not_end_is_infinite():
    assert four_phase_misfit(moling(), -1.0, 0.0) == np.inf
    assert four_phase_misfit(moling(b=3.0), 1.0, 0.0) == np.inf


def test_errors():
    with pytest.raises(OptionError, match="not for 'duffing'"):
        four_phase_misfit(ns.models.duffing(), 1.0, 1.0)
    with pytest.raises(OptionError, match="two numbers"):
        four_phase_orbit(moling(), (1.0,))
    with pytest.raises(OptionError, match=r"guess\[1\] = nan is not a finite number"):
        four_phase_orbit(moling(), (1.0, float("nan")))
