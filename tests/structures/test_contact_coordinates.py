"""What contacts look at: sums of coordinates with factors, less a displacement that is imposed.

The truth is scipy's, with what moves by itself as one more coordinate: an oscillator of 1e20 kg,
which no contact force slows down by more than 1e-18 of its speed.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.structures import DryFriction, Force, GapSpring, Stop, machine
from structures.contact_truth import Bench, Spring, Wall, chain

N = 4
OMEGA, IMPOSED, AMPLITUDE = 2.1, 1.7, 0.06
HEAVY = 1e20
# DOP853 at 3e-14 leaves 1e-12 of a state; a slow crossing divides that by its speed
NEAR = 1e-9


def structure():
    mass, stiffness = chain(N)
    names = [f"{i}x" for i in range(N)]
    damping = 0.05 * mass + 0.02 * stiffness
    return ns.Structure(mass, stiffness, damping=damping, coordinates=names)


def shaken(contacts):
    return machine(
        structure(),
        contacts,
        [Force("2x", "F*cos(omega*t)")],
        parameters={"F": 2.0, "omega": OMEGA, "e": AMPLITUDE, "nu": IMPOSED},
    )


def truth(springs=(), walls=()):
    """The chain, and last a heavy oscillator that moves as e cos(nu t)."""
    mass, stiffness = chain(N)
    damping = 0.05 * mass + 0.02 * stiffness
    grown = [np.zeros((N + 1, N + 1)) for _ in range(3)]
    for whole, part, own in zip(
        grown, (mass, damping, stiffness), (HEAVY, 0.0, HEAVY * IMPOSED**2), strict=True
    ):
        whole[:N, :N], whole[N, N] = part, own
    unit = np.eye(N + 1)
    bench = Bench(*grown, lambda t: 2.0 * np.cos(OMEGA * t) * unit[2], springs, walls)
    start = np.zeros(2 * (N + 1))
    start[N] = AMPLITUDE
    return bench.run(start, 20, 200.0)


def along(offset=False, **factors):
    """Row of factors over the coordinates, less the heavy one."""
    row = np.array([factors.get(f"x{i}", 0.0) for i in range(N)] + [-1.0 if offset else 0.0])
    return row


def assert_same(system, events):
    run = ns.simulate(system, t_end=events[-1].time + 1e-3)
    kinds = run["event_kind"].values != "start"
    found = run["event_time"].values[kinds][: len(events)]
    assert len(found) == len(events) == 20
    assert np.abs(found - [event.time for event in events]).max() < NEAR
    after = run["state_after"].values[kinds][: len(events)]
    states = np.array([np.delete(event.state, [N, 2 * N + 1]) for event in events])
    assert np.abs(after - states).max() < NEAR


FACTORS = {"3x": 0.5, "1x": -1.5, "0x": 0.25}
MOVES = "e*cos(nu*t)"


def test_a_spring_on_a_sum_with_factors():
    system = shaken([GapSpring(FACTORS, 0.05, 30.0, 0.4)])
    row = along(x3=0.5, x1=-1.5, x0=0.25)
    assert_same(system, truth([Spring(row, 0.05, 30.0, 0.4)]))


def test_an_impact_on_a_sum_with_factors():
    system = shaken([Stop(FACTORS, 0.05, 0.8)])
    assert_same(system, truth(walls=[Wall(along(x3=0.5, x1=-1.5, x0=0.25), 0.05, 0.8)]))


@pytest.mark.few(1)
@pytest.mark.parametrize("damping", [None, 0.6])
def test_a_spring_on_a_support_that_moves(damping):
    system = shaken([GapSpring("3x", 0.1, 30.0, damping, offset=MOVES)])
    row = along(offset=True, x3=1.0)
    assert_same(system, truth([Spring(row, 0.1, 30.0, damping or 0.0)]))


def test_springs_on_both_sides_of_a_support_that_moves():
    """As the teeth of gears with a transmission error, by the radii 2 and 1/2."""
    system = shaken([GapSpring({"3x": 2.0, "0x": -0.5}, 0.1, 30.0, 0.6, side="both", offset=MOVES)])
    row = along(offset=True, x3=2.0, x0=-0.5)
    springs = [Spring(sign * row, 0.1, 30.0, 0.6) for sign in (1.0, -1.0)]
    assert_same(system, truth(springs))


@pytest.mark.few(1)
@pytest.mark.parametrize("coordinate", ["3x", {"3x": 2.0}])
def test_an_impact_on_a_wall_that_moves(coordinate):
    system = shaken([Stop(coordinate, 0.1, 0.8, offset=MOVES)])
    row = along(offset=True, x3=2.0 if isinstance(coordinate, dict) else 1.0)
    assert_same(system, truth(walls=[Wall(row, 0.1, 0.8)]))


def test_a_mass_rests_on_a_wall_that_moves():
    """It is pressed to the wall by a constant force, and moves as the wall does."""
    mass = ns.Structure([[2.0]], [[0.0]], coordinates=["1x"])
    system = machine(
        mass,
        [Stop("1x", 0.0, 0.3, offset="e*sin(nu*t)")],
        [Force("1x", 10.0)],
        parameters={"e": 0.1, "nu": 1.3},
    )
    run = ns.simulate(system, {"x1": -0.2}, t_end=9.0)
    assert run.attrs["status"] == "completed"
    late = run.isel(time=run["time"].values > 5.0)
    t = late["time"].values
    assert np.abs(late["x1"].values - 0.1 * np.sin(1.3 * t)).max() < 1e-12
    assert np.abs(late["vx1"].values - 0.13 * np.cos(1.3 * t)).max() < 1e-12


def test_a_constant_offset_shifts_the_gap():
    """It is a parameter, and both sides move together, which no gap can do."""
    system = shaken([GapSpring("3x", 0.1, 30.0, side="both", offset=0.03)])
    assert system.parameters["spring1_offset"] == 0.03
    row = along(x3=1.0)
    assert_same(system, truth([Spring(row, 0.13, 30.0), Spring(-row, 0.07, 30.0)]))


def test_friction_between_sums():
    """Gears of radii 2 and 1 whose slip is 2 x1 - x2: the friction acts with these factors."""
    pair = ns.Structure(np.eye(2), np.zeros((2, 2)), coordinates=["1x", "2x"])
    system = machine(pair, [DryFriction({"1x": 2.0, "2x": -1.0}, 0.3)])
    run = ns.simulate(system, {"vx1": 1.0}, t_end=3.0)
    # slip 2 v1 - v2 falls from 2 at the rate (4 + 1) 0.3, then is zero
    times = run["event_time"].values[run["event_kind"].values != "start"]
    assert abs(times[0] - 2.0 / 1.5) < 1e-12
    assert abs(float(run["vx1"][-1]) - 0.2) < 1e-12
    assert abs(float(run["vx2"][-1]) - 0.4) < 1e-12


def test_what_is_refused():
    cases = [
        ({"3x": 0.0}, "factor that is not zero"),
        ({"3x": "a"}, "3x"),
        ({3: 1.0, "3x": 2.0}, "'3x' stands twice"),
        (("1x", "2x", "3x"), "mapping of coordinates to factors"),
    ]
    for coordinate, told in cases:
        with pytest.raises(ns.ModelError, match=told):
            shaken([GapSpring(coordinate, 0.1, 30.0)])
    with pytest.raises(ns.OptionError, match=r"spring1_offset: 'x1' is no parameter"):
        shaken([GapSpring("3x", 0.1, 30.0, 0.5, offset="0.1*x1")])
    with pytest.raises(ns.NonsmoothError):
        GapSpring("3x", 0.1, 30.0, offset="e*(")
