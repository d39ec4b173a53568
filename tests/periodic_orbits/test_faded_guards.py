"""Guards that fade: where only rounding is left of them, their sign says nothing."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.branch_tests import BranchTests
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.newton import solve_orbit
from periodic_orbits.kinds import found_equations

FADES = ("corner:0:1", "corner:1:1")


def fading(below: float = 0.0) -> ns.System:
    """p - q - w is one at every odd multiple of pi, and exp(-k t) a time t later; a guard on it.

    The states themselves are of the size of one, so that rounding of them is left of the guard.
    """
    q, w = "cos(t) - 0.3*q", "0.7*sin(t) - 1.7*w"
    drift = {"p": f"{q} + {w} - k*(p - q - w)", "q": q, "w": w}
    meets = ns.Exit("p - q - w - below", to="beyond")
    kick = ns.Exit("sin(t)", to="second", reset={"p": "q + w + 1"})
    return ns.System(
        name="fading",
        states=["p", "q", "w"],
        period="2*pi",
        parameters={"k": 0.5, "below": below},
        modes={
            "first": ns.Mode(drift, exits=[kick, meets]),
            "second": ns.Mode(drift, exits=[ns.Exit("-sin(t)", to="first"), meets]),
            "beyond": ns.Mode(drift, exits=[ns.Exit("q + w - p", to="first")]),
        },
        initial={"p": 1.0},
    )


@pytest.fixture(scope="module")
def legs_of_orbit() -> tuple[OrbitEquations, np.ndarray]:
    system = fading()
    return found_equations(system, ns.find_orbit(system, transient=20, phase=0.25))


def looked_at(legs_of_orbit, k: float, below: float = 0.0) -> tuple[dict[str, float], np.ndarray]:
    """Tests of the orbit, and the guards themselves at the ends of both legs."""
    equations, unknowns = legs_of_orbit
    equations.legs.set_values({"k": k, "below": below})
    solution = solve_orbit(equations, unknowns)
    assert solution.status == "completed"
    tests = BranchTests(equations, 1e-12, whole=False, grows=FADES[0])
    turn = equations.unpack(solution.unknowns)
    return (
        tests.look(solution.unknowns).tests,
        equations.legs.follow(equations.word, turn.states, turn.instants).others[:2, 1].copy(),
    )


def test_a_guard_that_fades_does_not_vanish(legs_of_orbit):
    """Of exp(-2 pi k) nothing is left at k = 6, and many a guard is negative from there on."""
    found = [looked_at(legs_of_orbit, k) for k in np.linspace(0.5, 60.0, 120)]
    guards = np.array([guards[0] for _, guards in found])
    assert np.abs(guards[12:]).max() < 1e-14 and (guards < 0.0).sum() > 5
    assert all(tests[FADES[0]] > 0.0 for tests, _ in found)
    assert all(tests.get(FADES[1], 1.0) > 0.0 for tests, _ in found)


def test_what_has_not_faded_is_itself(legs_of_orbit):
    """exp(-2 pi k) by exp(-pi k), both with a margin of 1e-13: 6e-11 of the smaller one."""
    tests, _ = looked_at(legs_of_orbit, 1.0)
    assert tests[FADES[0]] / tests[FADES[1]] == pytest.approx(np.exp(-np.pi), rel=3e-10)


@pytest.mark.parametrize("below", [1e-11, 1e-3])
def test_a_guard_that_is_passed_is_negative(legs_of_orbit, below):
    """By more than rounding, however little; the size of the guard is some of that of its terms."""
    tests, guards = looked_at(legs_of_orbit, 30.0, below)
    assert guards[0] == pytest.approx(-below, abs=1e-14)
    assert -below < tests[FADES[0]] < -0.1 * below
