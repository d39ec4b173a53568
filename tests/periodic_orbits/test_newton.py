"""Newton's method for orbits: how fast, how near, and what it says where there is none."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.newton import scale_of, solve_orbit
from periodic_orbits.kinds import KINDS, found_equations


@pytest.mark.parametrize("kind", KINDS)
def test_back_from_a_little_off(kind):
    system, options, _ = KINDS[kind]
    equations, unknowns = found_equations(system, ns.find_orbit(system, **options))
    scale = scale_of(equations, unknowns)
    rng = np.random.default_rng(5)
    off = unknowns + 1e-3 * scale * rng.uniform(-1.0, 1.0, unknowns.size)
    solution = solve_orbit(equations, off)
    assert solution.status == "completed"
    assert solution.residual < 1e-10
    assert solution.iterations <= 12  # 1e-3, 1e-6, 1e-12; the others tell that rounding is left
    drifts = np.tile(equations.drifting, len(equations.word))
    gap = np.abs(solution.unknowns - unknowns) / scale
    gap[: drifts.size][drifts] = 0.0
    if not equations.autonomous or equations.word.closes_at_event:
        assert gap.max() < 1e-9


def test_convergence_is_quadratic():
    """Digits double: the residuals of one, two and three steps, where the flow is not linear."""
    system, options, _ = KINDS["Duffing"]
    equations, unknowns = found_equations(system, ns.find_orbit(system, **options))
    off = unknowns + 1e-2
    left = [solve_orbit(equations, off, steps=count).residual for count in (1, 2, 3)]
    assert left[1] < 100.0 * left[0] ** 2
    assert left[2] < 100.0 * left[1] ** 2 + 1e-13


def test_nothing_fixes_the_amplitude_of_a_free_oscillator():
    free = ns.models.soft_impact(zeta=0, a=0, omega=1)
    orbit = ns.find_orbit(free, {"x": 0.5})
    # any amplitude closes, also the one that was given
    assert orbit.attrs["status"] == "completed"
    assert float(orbit["x"]) == 0.5
    assert "nothing fixes its amplitude" in orbit.attrs["message"]
    assert not orbit["stable"]


def test_resonance_without_damping_has_no_orbit():
    orbit = ns.find_orbit(ns.models.soft_impact(zeta=0, a=0.01, omega=1, e=1e9), {"x": 0.5})
    assert orbit.attrs["status"] == "singular"
    assert "nothing fixes its amplitude" in orbit.attrs["message"]


def test_no_legs_of_negative_duration_on_the_way():
    """From instants in the wrong order Newton's method returns to the orbit, or says no."""
    system, options, _ = KINDS["trilinear"]
    equations, unknowns = found_equations(system, ns.find_orbit(system, **options))
    first = len(equations.word) * 2
    swapped = unknowns.copy()
    swapped[first], swapped[first + 1] = unknowns[first + 1], unknowns[first]
    solution = solve_orbit(equations, swapped)
    assert solution.status in ("completed", "no_orbit", "singular")
    if solution.status == "completed":
        assert solution.residual < 1e-12


def test_it_says_so_where_there_is_no_orbit():
    """The wall moves away to where one impact per period is out of reach."""
    system = KINDS["rigid wall"][0]
    equations, unknowns = found_equations(system, ns.find_orbit(system, transient=300))
    values = dict(system.parameter_values)
    equations.legs.set_values(values | {"sigma": 50.0})
    solution = solve_orbit(equations, unknowns)
    assert solution.status != "completed"
