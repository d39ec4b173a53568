"""Residual and Jacobian of the equations of an orbit, for every kind of system."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.cycle_plane import on_new_plane
from periodic_orbits.kinds import KINDS, found_equations

KIND = pytest.mark.parametrize("kind", KINDS)


@KIND
def test_an_orbit_that_was_found_solves_them(kind):
    system, options, _ = KINDS[kind]
    orbit = ns.find_orbit(system, **options)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    equations, unknowns = found_equations(system, orbit)
    residual, jacobian, _ = equations.evaluate(unknowns)
    assert jacobian.shape == (unknowns.size, unknowns.size)
    assert np.abs(residual).max() < 1e-11 * max(1.0, np.abs(unknowns).max())


@KIND
def test_derivatives_against_differences(kind):
    """By all unknowns and by a parameter, a little off the orbit, where nothing vanishes."""
    system, options, parameter = KINDS[kind]
    equations, unknowns = found_equations(system, ns.find_orbit(system, **options), parameter)
    check_derivatives(equations, unknowns, system, parameter)


def test_derivatives_of_a_plane_that_goes_along_with_a_cycle():
    system = ns.System(
        states=["x", "v"],
        parameters={"mu": 1.0, "c": 5.0},
        equations={"x": "v", "v": "mu*(1 - (x - c)**2 - 0.3*(x - c))*v - (x - c)"},
        initial={"x": 7.0},
    )
    orbit = ns.find_orbit(system)
    equations, unknowns = found_equations(system, orbit, "c")
    plane = on_new_plane(equations, unknowns)
    assert abs(plane.evaluate(unknowns)[0][-1]) < 1e-9
    check_derivatives(plane, unknowns, system, "c")
    # the cycle about another place, which begins at the same place of it
    moved = unknowns + np.array([3.0, 0.0, 0.0])
    plane.legs.set_values(dict(system.parameter_values) | {"c": 8.0})
    assert np.abs(plane.evaluate(moved)[0]).max() < 1e-9


def check_derivatives(equations, unknowns, system, parameter):
    # slaved states follow from the others: their own column says nothing a difference could tell
    rng = np.random.default_rng(3)
    unknowns = unknowns + 1e-4 * rng.standard_normal(unknowns.size)
    _, jacobian, moved = (part.copy() for part in equations.evaluate(unknowns))
    size = np.abs(jacobian).max()
    for k in range(unknowns.size):
        h = 1e-5 * max(1.0, abs(unknowns[k]))
        step = np.zeros_like(unknowns)
        step[k] = h
        high = equations.evaluate(unknowns + step)[0].copy()
        low = equations.evaluate(unknowns - step)[0].copy()
        difference = (high - low) / (2 * h)
        assert np.abs(difference - jacobian[:, k]).max() < 1e-6 * size, k
    values = dict(system.parameter_values)
    h = 1e-6 * max(1e-2, abs(values[parameter]))
    sides = []
    for way in (h, -h):
        equations.legs.set_values(values | {parameter: values[parameter] + way})
        sides.append(equations.evaluate(unknowns)[0].copy())
    difference = (sides[0] - sides[1]) / (2 * h)
    assert np.abs(difference - moved[:, 0]).max() < 1e-6 * max(size, np.abs(moved).max())


@KIND
def test_packing_and_unpacking(kind):
    system, options, _ = KINDS[kind]
    equations, unknowns = found_equations(system, ns.find_orbit(system, **options))
    turn = equations.unpack(unknowns)
    np.testing.assert_array_equal(equations.pack(turn), unknowns)
    assert np.all(turn.durations > 0.0)
    assert len(turn.states) == len(equations.word) == len(turn.durations)


def test_the_last_instant_of_a_driven_orbit_is_given():
    equations, unknowns = found_equations(
        ns.models.moling(), ns.find_orbit(ns.models.moling(), phase=0.25)
    )
    turn = equations.unpack(unknowns)
    period = 2 * np.pi / 0.1
    assert turn.instants[0] == pytest.approx(0.25 * period, rel=1e-15)
    assert turn.instants[-1] == pytest.approx(1.25 * period, rel=1e-15)
