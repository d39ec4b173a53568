"""Words of a hundred legs at a rigid wall: an unstable orbit, and one turned a hundred times."""

import numpy as np
from mpmath import mp

import nonsmooth as ns
from periodic_orbits.references.long_words import WallCourses
from periodic_orbits.references.make_orbits import WALL
from periodic_orbits.references.rigid_wall import RigidWall
from periodic_orbits.references.turn import take_turn
from periodic_orbits.sampler import wall_penetration
from periodic_orbits.systems import ORBITS, as_complex, assert_multipliers, assert_state, rigid_wall

KEPT = ORBITS["long_wall"]
NUMBERS = {name: float(value) for name, value in WALL.items()}
IMPACTS = sum(len(each) - 1 for each in KEPT["durations"])
PERIODS = len(KEPT["points"])


def log_determinant() -> float:
    span = 2 * np.pi * PERIODS / NUMBERS["omega"]
    return 2 * IMPACTS * np.log(NUMBERS["r"]) - 2 * NUMBERS["zeta"] * span


def test_the_reference_closes_and_keeps_off_the_wall():
    """136 turns of a period each, in 60 digits, from what is kept in 25; no part repeats."""
    with mp.workdps(60):
        wall = WallCourses(**WALL)
        for k, (point, durations) in enumerate(zip(KEPT["points"], KEPT["durations"], strict=True)):
            turn = take_turn(wall.course(len(durations) - 1), [mp.mpf(x) for x in point], durations)
            then = KEPT["points"][(k + 1) % PERIODS]
            assert max(abs(a - mp.mpf(b)) for a, b in zip(turn.end, then, strict=True)) < 1e-22
    assert (IMPACTS, PERIODS) == (102, 136)
    x = np.array([float(point[0]) for point in KEPT["points"]])
    for part in (2, 4, 8, 17, 34, 68):
        assert np.abs(x - np.roll(x, part)).max() > 1e-3
    product = sum(np.log(abs(as_complex(each))) for each in KEPT["multipliers"])
    assert abs(product - log_determinant()) < 1e-12 * abs(log_determinant())


def test_an_unstable_orbit_of_103_legs():
    start = dict(zip("xv", map(float, KEPT["points"][0]), strict=True))
    system = rigid_wall(**NUMBERS)
    orbit = ns.find_orbit(system, start, period=PERIODS)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert orbit.sizes["leg"] == IMPACTS + 1
    assert bool(orbit["admissible"]) and not bool(orbit["stable"])
    assert_state(orbit, start)
    assert_multipliers(orbit, [as_complex(each) for each in KEPT["multipliers"]])
    assert abs(float(orbit["log_determinant"]) - log_determinant()) < 1e-11 * IMPACTS
    deepest, joint = wall_penetration(orbit, **NUMBERS)
    assert deepest < 1e-12 and joint < 1e-11


def test_a_saddle_turned_fifty_times():
    """Its multipliers to the fiftieth power: 3e10 and 1e-23, which no matrix product keeps apart.

    The motion from its state in doubles is still within 1e-5 of it after 150 periods.
    """
    words = {"omega": 5.6, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
    wall = RigidWall.of(**words, n=3)
    speed = wall.speeds(1.0)[1]
    orbit = ns.find_orbit(rigid_wall(F=1.0, **words), wall.start(speed), period=150)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert int(orbit["primitive_parts"]) == 50 and orbit.sizes["leg"] == 51
    expected = [(m**50).real for m in wall.multipliers(speed)]
    assert 1e10 < expected[0] < 1e11 and 1e-24 < expected[1] < 1e-22
    assert_state(orbit, wall.start(speed))
    # the relative error of a power is fifty times that of its base, about 50 EPS here
    assert_multipliers(orbit, expected)
    log = 50 * float(mp.log(wall.determinant))
    assert abs(float(orbit["log_determinant"]) - log) < 1e-11 * abs(log)
