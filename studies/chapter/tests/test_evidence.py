"""The parts that evidence is made of: closed forms, a general integrator, regimes, the soil."""

import numpy as np
import pytest

import nonsmooth as ns
from neighbours import neighbour_exponent
from nonsmooth.models import MolingRig, moling, moling_solution
from nonsmooth_chapter.mole.independent import (
    absolute_mole,
    adaptive_mole_run,
    solve_switching_times,
    stitched_states,
)
from nonsmooth_chapter.mole.model_claims import push, pushed_slider
from nonsmooth_chapter.mole.sweeps import primitive_period, settled_regime

VALUES = {"a": 0.3, "b": 0.19, "xi": 0.05, "omega": 0.1, "g": 0.02, "phi": np.pi / 2}


def slope(values, mode, state, time):
    """Rates p', y', q', v' of the chapter's Eqs. (25)-(27), corrected, written again."""
    _, y, q, _ = state
    load = values["b"] + values["a"] * np.cos(values["omega"] * time + values["phi"])
    force, slip = 2 * values["xi"] * y + q, (1 - q) / (2 * values["xi"])
    return {
        "no_contact": [y, load, -q / (2 * values["xi"]), 0.0],
        "contact": [y, load - force, y, 0.0],
        "progression": [slip, load - 1.0, slip, y - slip],
    }[mode]


@pytest.mark.parametrize("xi", [0.05, 0.35, 1.5])
@pytest.mark.parametrize("mode", ["no_contact", "contact", "progression"])
def test_closed_forms_satisfy_their_equations(mode, xi):
    """Central differences of step h are right to h^2 times the third derivative."""
    values, step = VALUES | {"xi": xi}, 1e-5
    start = np.array([0.32, 0.7, 0.3, 2.0])
    for time in (3.1, 3.4, 5.0):
        low, mid, high = moling_solution(
            values, mode, start, 3.0, np.array([time - step, time, time + step])
        )
        exact = slope(values, mode, mid, time)
        # third derivatives are below (1 / 2 xi)^3 = 1000; differences lose eps / h
        assert np.abs((high - low) / (2 * step) - exact).max() < 2e-7
    assert np.allclose(moling_solution(values, mode, start, 3.0, np.array([3.0]))[0], start)


def test_three_routes_agree():
    """Closed forms with roots, DOP853, and the engine, on a motion with many contacts."""
    times = np.linspace(0.0, 100.0, 301)
    adaptive = adaptive_mole_run(VALUES, times)
    roots = solve_switching_times(VALUES, adaptive.switch_modes, adaptive.switch_times)
    stitched = stitched_states(VALUES, adaptive.switch_modes, roots, times)
    run = ns.simulate(moling(b=0.19), times=times)
    engine = np.column_stack([run[name].values for name in "pyqv"])
    assert len(roots) == run.attrs["n_events"]
    # the motion is chaotic: roundings grow some hundredfold in two periods
    assert np.abs(stitched - engine).max() < 1e-11
    assert np.abs(stitched - adaptive.states).max() < 1e-7


def test_absolute_mole_needs_no_scaling():
    """Its drift agrees with that of the scaled system."""
    rig = MolingRig(
        mass=2.0, stiffness=5e4, damping=31.6, static_force=30.0, dynamic_force=60.0,
        friction_force=200.0, angular_frequency=15.8, gap=8e-5,
    )  # fmt: skip
    drift = ns.simulate(absolute_mole(rig), periods=10)["X_b"].values
    scaled = rig.to_si(ns.simulate(rig.system(), periods=10))["v"].values
    assert np.allclose(1e3 * drift, scaled, rtol=1e-10, atol=1e-9)


@pytest.mark.few(1)
@pytest.mark.parametrize(("b", "period"), [(0.095, 4), (0.1, 2), (0.15, 1), (0.19, 0), (0.05, 0)])
def test_regimes(b, period):
    """Primitive periods from rest; the aperiodic one has a positive exponent."""
    found = settled_regime(moling(b=b))
    assert found["period"] == period
    if period:
        assert 0.0 < found["multiplier"] < 1.0
    else:
        expected, error = neighbour_exponent(moling(b=b), 600, 400)
        assert found["exponent"] == pytest.approx(expected, abs=3 * error)
        assert found["exponent"] > 3.0 * found["exponent_error"] > 0.0


def test_primitive_period_is_the_least():
    """A motion of period three also repeats after six."""
    points = np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]] * 30)
    assert primitive_period(points) == (3, 0.0)
    assert primitive_period(np.arange(50.0)[:, None], longest=5) == (0, 1.0)


def test_slow_push_follows_the_piecewise_linear_law():
    """Depth below the threshold is elastic, the rest is progression."""
    run = ns.simulate(pushed_slider(xi=0.05, rate=1e-5, depth=2.5), periods=1)
    assert float(run["v"][-1]) == pytest.approx(1.5, abs=1e-4)
    # the viscous part is 2 xi times the speed, 1.25e-5 at most
    assert push(0.05, 1e-5, 2.5)["law_distance"] < 2 * 0.05 * 1.25e-5 * 1.01


def test_weak_push_is_elastic():
    """A tool that goes in less than the threshold leaves the bottom where it is."""
    run = ns.simulate(pushed_slider(xi=0.05, rate=1e-3, depth=0.8), periods=1)
    assert abs(float(run["v"][-1])) < 4 * np.finfo(float).eps
    assert run.attrs["phase_word"] == "contact free"
