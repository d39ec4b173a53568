"""Branches through changes of the word at which a multiplier is 1, and rounding decides nothing.

Den Hartog's oscillator without damping: in its motion with two stops per turn the mass leaves the
last stop at t0 and comes to the next one. Where that takes just a period of its own, 2 pi, the
homogeneous part of x'' + x = cos(omega t) + f has come back to where it was, so

    x0 = cos(omega t0)/(1 - omega^2),   cos(omega t0) = f (1 - omega^2)/omega^2,

by the balance of forces at the start, and x1 = -x0 with v1 = 0 needs omega t0 = pi/2 - pi omega.
The force at the next stop is then at its limit as well: below this frequency the mass stays there,
beyond it overshoots. The map over half a turn followed by the symmetry has the multiplier -1.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns

F = 0.3
BORDER = brentq(lambda w: np.sin(np.pi * w) * w * w - F * (1.0 - w * w), 0.45, 0.5, xtol=1e-14)
# rounding of the orbit over the distance of its multiplier from 1, both at their least there
NEAR = 2e-6


@pytest.fixture(scope="module")
def oscillator():
    return ns.models.friction_oscillator(f=F, zeta=0.0)


@pytest.mark.few(1)
@pytest.mark.parametrize(("begin", "transient"), [(0.48, 3000), (0.4812, 3000), (0.4835, 300)])
def test_a_branch_passes_a_border_where_its_multiplier_is_one(oscillator, begin, transient):
    orbit = ns.find_orbit(oscillator, parameters={"omega": begin}, transient=transient)
    branch = ns.continue_orbit(oscillator, "omega", (0.478, 0.484), initial=orbit)
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    kinds = list(branch["special_kind"].values)
    assert kinds[1] == "switching_sliding" and len(kinds) == 4
    assert float(branch["special_value"][1]) == pytest.approx(BORDER, abs=NEAR)
    assert bool(branch["admissible"].all())
    # further on one stop vanishes as the velocity only touches zero: told from either side
    assert kinds[2] in ("grazing", "grazing_sliding")
    first, last = branch["word"].values[0], branch["word"].values[-1]
    assert sorted(first.split()) == ["back", "forth", "stick", "stick", "stick"]
    assert "stick" not in last


def test_the_branch_of_an_orbit_begins_at_its_parameters(oscillator):
    orbit = ns.find_orbit(oscillator, parameters={"omega": 0.6, "f": 0.25})
    branch = ns.continue_orbit(oscillator, "omega", (0.58, 0.72), initial=orbit, steps=3)
    begin = branch.isel(point=int(np.flatnonzero(branch["arclength"].values == 0.0)[0]))
    assert float(begin["omega"]) == pytest.approx(0.6, rel=1e-12)
    assert float(begin["x"]) == pytest.approx(float(orbit["x"]), abs=1e-10)
    own = ns.continue_orbit(
        oscillator, "omega", (0.58, 0.72), initial=orbit, steps=3, parameters={}
    )
    begin = own.isel(point=int(np.flatnonzero(own["arclength"].values == 0.0)[0]))
    assert float(begin["omega"]) == pytest.approx(0.7, rel=1e-12)


def test_resonance_without_damping_is_an_amplitude_without_bound(oscillator):
    """Friction takes less work per turn than the force gives at omega = 1 while f < pi/4."""
    start = ns.find_orbit(oscillator, parameters={"omega": 0.95})
    branch = ns.continue_orbit(oscillator, "omega", (0.9, 1.5), initial=start, direction="up")
    assert branch.attrs["end_last"] == "unbounded"
    assert float(branch["omega"].values.max()) == pytest.approx(1.0, abs=1e-5)


def test_an_orbit_that_settles_slowly_is_found_behind_a_longer_transient(oscillator):
    """At omega = 0.481 the largest multiplier is 0.998, so 200 periods leave two thirds."""
    orbit = ns.find_orbit(oscillator, parameters={"omega": 0.481})
    assert orbit.attrs["status"] == "completed" and orbit.attrs["transient"] == 2000
    again = ns.find_orbit(oscillator, parameters={"omega": 0.481}, transient=2000)
    assert float(orbit["x"]) == float(again["x"])
    asked = ns.find_orbit(oscillator, parameters={"omega": 0.481}, transient=200)
    assert asked.attrs["status"] != "completed"
