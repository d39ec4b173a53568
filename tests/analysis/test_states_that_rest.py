"""States that rest beside others that move: their rounding is no motion, and has no period.

A mass on a hardening spring comes to rest at y = 1.5945..., where 2 = y + y^3/10. Its velocity is
rounding there, about 1e-16, however long the motion is followed. Whatever is beside it, on which it
does not act, has the label and the period that it has alone.
"""

from __future__ import annotations

from threading import Event

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.linalg import block_diag

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.analysis.exponents.neighbours import Neighbours, orbit_maps
from nonsmooth.analysis.regimes.window import run_away
from nonsmooth.analysis.settle import Group, ParameterSets
from nonsmooth.analysis.statistics.periodicity import settled_periods
from nonsmooth.analysis.statistics.rest import floor_of, halves, natural_sizes
from nonsmooth.analysis.statistics.sizes_by_rates import sizes_by_rates
from nonsmooth.cli.app import app
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import SweepRunner

RESTING = {"y": "u", "u": "2 - y - 0.3*u - 0.1*y**3"}


def shaker(beside: dict[str, str], stop: str | None = None) -> System:
    """A driven oscillator, which may hit a stop, beside something else."""
    flow = {"x": "v", "v": "cos(w*t) - x - 2*z*v", **beside}
    exits = [] if stop is None else [Exit(stop, reset={"v": "-0.6*v"}, name="impact")]
    return System(
        name="shaker", states=list(flow), parameters={"w": 1.3, "z": 0.1}, period="2*pi/w",
        initial={"y": 1.3} if beside else {}, modes={"free": Mode(flow, exits=exits)},
    )  # fmt: skip


def gear() -> System:
    """A pair in SI units, the mesh of which does not ripple: x = b/2 + F/k0 at rest."""
    return System(
        states=["x", "v"], period="2*pi/W", initial={"x": 5.5e-5},
        parameters={
            "m": 0.23, "c": 480.0, "k0": 3.8e8, "k1": 0.0, "b": 1e-4, "F": 2200.0, "W": 37000.0,
        },
        equations={
            "x": "v",
            "v": "(F - c*v - (k0 + k1*cos(W*t))*(x - clip(x, -b/2, b/2)))/m",
        },
    )  # fmt: skip


def told(found) -> tuple[str, int]:
    return found["regime"].item(), found["period"].item()


@pytest.mark.parametrize("w", [0.5, 1.3, 2.9])
def test_a_driven_oscillator_beside_a_mass_at_rest(w):
    system = shaker(RESTING).with_parameters(w=w)
    assert told(ns.regime(system)) == ("periodic", 1)
    diagram = ns.bifurcation_diagram(system, "w", [w], transient=300)
    assert diagram["period"].values.tolist() == [[1]]


@pytest.mark.parametrize(("w", "period"), [(2.2, 1), (2.3, 1), (2.5, 2)])
def test_impacts_beside_a_mass_at_rest_have_the_period_that_they_have_alone(w, period):
    for beside in ({}, RESTING):
        system = shaker(beside, "0.1 - x").with_parameters(w=w)
        assert told(ns.regime(system)) == ("periodic", period)
        found = ns.bifurcation_diagram(system, "w", [w])
        assert found["period"].values.tolist() == [[period]]


@pytest.mark.parametrize("omega", [27800.0, 37000.0, 41600.0])
def test_a_gear_pair_in_metres_rests(omega):
    """Its velocity would be 2 m/s if x moved by its size, and is 1e-15."""
    system = gear().with_parameters(W=omega)
    assert told(ns.regime(system)) == ("equilibrium", 1)
    diagram = ns.bifurcation_diagram(system, "W", [omega])
    assert diagram["period"].values.tolist() == [[1]]


@pytest.mark.parametrize("x", [0.0, 0.3, 1.0])
def test_parametric_forcing_of_nothing(x):
    """Time stands in the equations, and does nothing."""
    system = System(
        states=["x", "v"], parameters={"F": 0.0, "w": 2.2, "g": x}, period="2*pi/w",
        initial={"x": 0.5}, equations={"x": "v", "v": "g - x - 0.2*v + F*cos(w*t)*x"},
    )  # fmt: skip
    assert told(ns.regime(system)) == ("equilibrium", 1)


@pytest.mark.parametrize("torque", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("period", [np.pi, 1.0])
def test_a_pendulum_rests_whatever_the_time_between_looks(torque, period):
    """After pi, half a turn, a position makes nothing of a velocity."""
    system = System(
        states=["q", "w"], parameters={"m": torque}, initial={"q": 0.5},
        equations={"q": "w", "w": "m - sin(q) - 0.2*w"},
    )  # fmt: skip
    assert told(ns.regime(system, period=period)) == ("equilibrium", 1)


def test_a_state_that_passes_zero_at_each_strobe():
    """x = cos(t) by the force that this needs: v = -sin(t) is rounding at the strobes."""
    system = System(
        states=["x", "v"], parameters={"z": 0.1}, period="2*pi", initial={"x": 1.0},
        equations={"x": "v", "v": "-x - 0.2*x**3 - 2*z*v - 2*z*sin(t) + 0.2*cos(t)**3"},
    )  # fmt: skip
    assert told(ns.regime(system)) == ("periodic", 1)
    assert ns.bifurcation_diagram(system, "z", [0.1])["period"].values.tolist() == [[1]]


def test_commands_say_the_same(tmp_path):
    file = tmp_path / "shaker.toml"
    file.write_text(shaker(RESTING, "0.1 - x").with_parameters(w=2.2).to_toml())
    strobes = CliRunner().invoke(app, ["strobe", str(file), "--transient", "100"])
    assert "after 1 points" in strobes.output
    diagram = CliRunner().invoke(app, ["diagram", str(file), "--over", "w=2:2.5:3"])
    assert "2 of period 1, 1 of period 2" in diagram.output


def test_a_map_of_regimes_beside_a_mass_at_rest():
    system = shaker(RESTING, "0.1 - x")
    found = ns.regime_map(system, {"w": [2.1, 2.3], "z": [0.1, 0.11]}, refine=0)
    assert np.all(found["period"].values == 1)


def test_sizes_come_from_what_others_make_of_a_state():
    """v' = -w^2 x: a velocity is w times the size of its position, also after half a turn."""
    w = 1e4

    def blocks_over(parts, going):
        turns = np.pi * np.array(parts)
        block = [[np.cos(turns), np.sin(turns) / w], [-w * np.sin(turns), np.cos(turns)]]
        return np.outer(going, np.isfinite(turns)), np.moveaxis(np.array([block]), 3, 1)

    sizes = np.array([[2e-5, 1e-16]])
    found = natural_sizes(sizes, np.ones(1, bool), blocks_over)
    # of golden parts of half a turn one has a sine of 0.93
    np.testing.assert_allclose(found, [[2e-5, 0.93 * w * 2e-5]], rtol=0.01)
    assert np.all(floor_of(found, 1e-6) == 1e-6 * found)


def test_fast_states_beside_slow_ones_have_sizes():
    """A pair of frequency w and damping d forgets within a part in which another one does not."""
    w, d = 1e3, 60.0

    def block(part):
        turn, left = w * part, np.exp(-d * part)
        fast = [[np.cos(turn), np.sin(turn) / w], [-w * np.sin(turn), np.cos(turn)]]
        return block_diag(1.0, left * np.array(fast))

    def blocks_over(parts, going):
        return np.outer(going, np.isfinite(parts)), np.array([[block(part) for part in parts]])

    found = natural_sizes(np.array([[1.0, 2e-5, 1e-16]]), np.ones(1, bool), blocks_over)
    assert 0.1 * w * 2e-5 < found[0, 2] <= w * 2e-5


def test_growth_within_a_part_is_no_size():
    """A saddle that takes its neighbours away by 1e9 in a part."""

    def grows(parts, going):
        blocks = np.tile(1e9 * np.eye(2), (1, len(parts), 1, 1))
        return np.outer(going, np.isfinite(parts)), blocks

    sizes = np.array([[1.0, 1.0]])
    found = natural_sizes(sizes, np.ones(1, bool), grows)
    np.testing.assert_array_equal(found, sizes)


def test_derivatives_have_one_state_in_each_row():
    """Of x' = v, v' = 0 the derivative of x by v is the time."""
    system = System(states=["x", "v"], equations={"x": "v", "v": "0"})
    chosen = StroboscopicMap(system, period=3.0)
    sets = ParameterSets(chosen, {}, {"x": 0.0, "v": 1.0}, None)
    group = Group(SweepRunner(system, 1e-12), sets, [0], Event())
    last = group.run(group.strobes(0, 1), log=False).last
    given = Neighbours(
        group.runner, last, np.ones(1, bool), group.strobes(1, 1), group.drifting, None
    )
    known, blocks = orbit_maps(given)
    assert known.tolist() == [[True]]
    np.testing.assert_allclose(blocks[0, 0], [[1.0, 3.0], [0.0, 1.0]])


def test_rounding_beside_a_doubled_period():
    """Noise of 1e-16 of a state whose natural size is one neither hides nor makes a period."""
    generator = np.random.default_rng(0)
    k = np.arange(101)
    points = np.column_stack([np.cos(np.pi * k), 1e-16 * generator.normal(size=101)])[None]
    natural = np.ones((1, 2))
    still = np.zeros(2, bool)
    scale = np.maximum(np.abs(points).max(axis=1), floor_of(natural, 1e-6))
    assert settled_periods(points, still, 1e-6).tolist() == [0]
    assert settled_periods(points, still, 1e-6, scale, natural).tolist() == [2]


def test_rounding_neither_grows_nor_hides_that_others_halve():
    small = 1e-17 * np.arange(10.0)[:, None]
    unseen = np.array([np.inf]), np.array([-np.inf])
    assert run_away(small, 100.0 * small, unseen, np.zeros(1))
    assert not run_away(small, 100.0 * small, unseen, np.full(1, 1e-12))
    points = np.column_stack([0.5 ** np.arange(9.0), 1e-17 * (-1.0) ** np.arange(9)])[None]
    assert halves(points, np.zeros(2)).tolist() == [[True, False]]
    assert halves(points, np.full(2, 1e-15)).tolist() == [[True, True]]


@pytest.mark.parametrize(("w", "period"), [(2.2, 1), (2.5, 2)])
def test_local_regimes_beside_a_mass_at_rest(w, period):
    system = shaker(RESTING, "0.1 - x").with_parameters(w=w)
    run = ns.simulate(system, periods=600, samples_per_period=1, events=False)
    found = ns.local_regimes(run.isel(time=slice(200, None)))
    assert found["stretch_period"].values.tolist() == [period]


def test_dimensions_leave_out_what_rests():
    """Rounding would fill a direction of its own."""
    system = shaker(RESTING, "0.1 - x").with_parameters(w=2.8)
    run = ns.simulate(system, periods=2300, samples_per_period=1, events=False)
    points = run.isel(time=slice(300, None))
    for verb in (ns.box_dimension, ns.correlation_dimension):
        moving, found = verb(points, states=["x", "v"]), verb(points)
        assert found[verb.__name__].item() == moving[verb.__name__].item()


def test_sizes_by_rates_do_not_depend_on_units():
    """A pair in metres has a velocity of x times its angular frequency, and so in micrometres."""
    found = []
    for unit in (1.0, 1e6):
        system = System(
            states=["x", "v"], parameters={"L": unit}, period="1",
            equations={"x": "v", "v": "1e8*(1e-5*L - x) - 10*v"},
        )  # fmt: skip
        states = np.array([[1e-5 * unit, 1e-17 * unit], [1e-5 * unit, -1e-17 * unit]])
        found.append(sizes_by_rates(system, states, 0) / unit)
    np.testing.assert_allclose(found[0], [1e-5, 0.1], rtol=1e-3)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9)
