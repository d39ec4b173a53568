"""Cycles that motions come to slowly, while they turn about them: found as one turn."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit import primitive_parts
from nonsmooth.periodic_orbits.word import Word


def kicked(z, w=1.7):
    """A linear oscillator kicked by its own clock; |multipliers| are exp(-z w) per kick."""
    kick = ns.Exit("1 - tau", reset={"tau": "0", "v": "v + 0.3"}, name="kick")
    field = {"x": "v", "v": "-2*z*w*v - w**2*x", "tau": "1"}
    return ns.System(
        states=["x", "v", "tau"],
        parameters={"z": z, "w": w},
        initial={"x": 1.0},
        period=1.0,
        modes={"m": ns.Mode(field, exits=[kick])},
    )


@pytest.mark.parametrize("z", [0.0013, 0.005])
def test_one_turn_where_the_motion_comes_back_nearest_after_many(z):
    found = ns.find_orbit(kicked(z))
    assert found.attrs["message"] == "completed"
    assert float(found["length"]) == pytest.approx(1.0, rel=1e-12)
    assert int(found["primitive_parts"]) == 1
    np.testing.assert_allclose(np.abs(found["multipliers"]), np.exp(-1.7 * z), rtol=1e-10)


def test_as_many_turns_as_are_wanted():
    found = ns.find_orbit(kicked(0.0013), period=2)
    assert float(found["length"]) == pytest.approx(2.0, rel=1e-12)
    assert int(found["primitive_parts"]) == 2
    np.testing.assert_allclose(np.abs(found["multipliers"]), np.exp(-2 * 1.7 * 0.0013), rtol=1e-10)


@pytest.mark.parametrize("period", [1, 2])
def test_branches_pass_once_through_such_a_cycle(period):
    branch = ns.continue_orbit(kicked(0.0013), "w", (1.6, 1.8), period=period)
    np.testing.assert_allclose(branch["length"], 1.0, rtol=1e-12)
    exact = np.exp(-0.0013 * branch["w"].values)
    np.testing.assert_allclose(np.abs(branch["multipliers"]).max("multiplier"), exact, rtol=1e-10)


@pytest.mark.parametrize(
    "find", [ns.find_orbit, lambda s: ns.orbits(s, samples=1, record=100).isel(orbit=0)]
)
def test_one_turn_of_a_cycle_without_events(find):
    # a van der Pol oscillator drives a weakly damped one; its cycle lasts 6.66328686 and the
    # other's perturbations fade by exp(-1.7 z) per unit time, whatever drives it
    z, length = 0.0003, 6.6632868593
    field = {"x": "v", "v": "-2*z*1.7*v - 1.7**2*x + 0.1*y", "y": "w", "w": "(1 - y**2)*w - y"}
    states = {"states": list(field), "initial": {"x": 1.0, "y": 1.0}}
    found = find(ns.System(**states, parameters={"z": z}, equations=field))
    assert float(found["length"]) == pytest.approx(length, rel=1e-9)
    assert int(found["primitive_parts"]) == 1
    sizes = np.sort(np.abs(found["multipliers"].values))
    np.testing.assert_allclose(sizes[1:], np.exp(-1.7 * z * length), rtol=1e-8)


@pytest.mark.parametrize("turns", [1, 2, 9, 281, 1050])
def test_turns_are_counted_beside_the_size_of_the_cycle(turns):
    # a circle of radius 1e-5 about x = 1, at unit speed
    field = {"x": "v - k*(x - 1)*g", "v": "-(x - 1) - k*v*g"}
    system = ns.System(
        states=["x", "v"],
        parameters={"a": 1e-5, "k": 0.1},
        definitions={"g": "((x - 1)**2 + v**2)/a**2 - 1"},
        equations=field,
    )
    legs = Legs(system)
    legs.set_values(system.parameter_values)
    equations = OrbitEquations(
        legs, Word((0,), ((),)), period=1, autonomous=True, reference=np.array([1.0, 1e-5])
    )
    turn = Turn(np.array([[1.0, 1e-5]]), np.array([0.0, 2 * np.pi * turns]))
    assert primitive_parts(equations, turn) == turns
