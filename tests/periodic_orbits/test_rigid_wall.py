"""One-impact orbits of the rigid impact oscillator against closed forms."""

import numpy as np
import pytest

import nonsmooth as ns
from periodic_orbits.references.rigid_wall import RigidWall
from periodic_orbits.sampler import wall_penetration
from periodic_orbits.systems import assert_multipliers, assert_state, rigid_wall

EPS = np.finfo(float).eps

# omega, zeta, sigma, r, n, F, which of the two orbits (0: the faster one)
CASES = [
    (2.8, 0.02, 0.1, 0.8, 2, 0.3, 0),
    (2.8, 0.02, 0.1, 0.8, 2, 0.3, 1),
    (2.8, 0.02, 0.1, 0.8, 2, 1.0, 0),
    (2.8, 0.02, 0.1, 0.8, 1, 1.0, 0),
    (0.8, 0.05, 0.5, 0.7, 1, 0.3, 0),
    (5.6, 0.02, 0.1, 0.8, 3, 1.0, 0),
    (5.6, 0.02, 0.1, 0.8, 3, 1.0, 1),
    (4.0, 0.02, 0.1, 0.8, 2, 2.0, 0),
    (1.6, 0.02, 0.1, 0.8, 1, 0.3, 0),
    (2.8, 0.02, -0.1, 0.8, 1, 1.0, 0),
    (2.5, 0.0, 0.0, 0.8, 1, 1.0, 0),
]


def family(omega, zeta, sigma, r, n) -> tuple[RigidWall, dict]:
    words = {"omega": omega, "zeta": zeta, "sigma": sigma, "r": r}
    return RigidWall.of(**words, n=n), words


@pytest.mark.parametrize(("omega", "zeta", "sigma", "r", "n", "F", "which"), CASES)
def test_one_impact_orbit(omega, zeta, sigma, r, n, F, which):
    wall, words = family(omega, zeta, sigma, r, n)
    speed = wall.speeds(F)[which]
    assert wall.clearance(speed, 200) > 1e-3  # it is a motion
    system = rigid_wall(F=F, **words)
    orbit = ns.find_orbit(system, wall.start(speed), period=n)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert bool(orbit["admissible"])
    assert_state(orbit, wall.start(speed))
    expected = wall.multipliers(speed)
    assert_multipliers(orbit, expected)
    assert bool(orbit["stable"]) == bool(abs(expected[0]) < 1)
    # the determinant is a sum of logs: each of the few terms is right to rounding
    log = 2 * np.log(r) - 2 * zeta * float(wall.span)
    assert abs(float(orbit["log_determinant"]) - log) < 1e-12 * max(1.0, abs(log))
    assert abs(float(orbit["length"]) - float(wall.span)) < 8 * EPS * float(wall.span)
    assert orbit.sizes["leg"] == 2
    since = (2 * np.pi * n - (float(wall.phase(speed)) + 2 * np.pi * (n - 1))) / omega
    assert abs(float(orbit["durations"][1]) - since) < 1e-10
    deepest, joint = wall_penetration(orbit, F=F, **words)
    assert deepest < 1e-12 and joint < 1e-11


@pytest.mark.parametrize("off", [1e-3, -1e-3])
def test_a_guess_nearby_is_enough(off):
    wall, words = family(2.8, 0.02, 0.1, 0.8, 2)
    speed = wall.speeds(0.3)[1]  # a saddle, which no motion finds
    start = {name: value + off for name, value in wall.start(speed).items()}
    orbit = ns.find_orbit(rigid_wall(F=0.3, **words), start, period=2)
    assert_state(orbit, wall.start(speed))
    assert not bool(orbit["stable"])


def test_undamped_trace():
    """zeta = sigma = 0: -2 r cos T + (1 + r)^2 (1 - omega^2) (1 + cos T) / 2."""
    omega, r = 2.5, 0.8
    wall, words = family(omega, 0.0, 0.0, r, 1)
    orbit = ns.find_orbit(rigid_wall(F=1.0, **words), wall.start(wall.speeds(1.0)[0]))
    span = 2 * np.pi / omega
    trace = -2 * r * np.cos(span) + (1 + r) ** 2 * (1 - omega**2) * (1 + np.cos(span)) / 2
    assert abs(orbit["multipliers"].values.sum() - trace) < 1e-10


@pytest.mark.slow
def test_below_the_fold_there_is_no_orbit():
    wall, words = family(2.8, 0.02, 0.1, 0.8, 2)
    fold = float(wall.force(wall.fold_speed))
    above = wall.start(wall.fold_speed)
    orbit = ns.find_orbit(rigid_wall(F=fold * 0.99, **words), above, period=2, word="free free")
    assert orbit.attrs["status"] in ("no_orbit", "singular")
    assert len(orbit.attrs["message"]) > 20
    assert np.isnan(float(orbit["x"]))
    assert not bool(orbit["admissible"]) and not bool(orbit["stable"])


def test_a_construction_through_the_wall_is_called_inadmissible():
    """The two-period orbit, carried on, touches the wall between its impacts and then passes it."""
    wall, words = family(2.8, 0.02, 0.1, 0.8, 2)
    before = ns.find_orbit(rigid_wall(F=1.9, **words), wall.start(wall.speeds(1.9)[0]), period=2)
    assert bool(before["admissible"])
    orbit = ns.find_orbit(rigid_wall(F=1.95, **words), before, period=2)
    assert orbit.attrs["status"] == "inadmissible" and not bool(orbit["admissible"])
    speed = wall.speeds(1.95)[0]
    assert wall.clearance(speed, 200) < -1e-3
    assert_state(orbit, wall.start(speed))
    assert_multipliers(orbit, wall.multipliers(speed))


# RigidWall.of(omega=2.8, zeta=0.02, sigma=0.1, r=0.8, n=2).touching(speeds at F = 1.8 and 1.9)
TOUCHING = 1.928925317900750545320119


@pytest.mark.parametrize(("off", "status"), [(-1e-9, "completed"), (1e-9, "inadmissible")])
def test_admissible_up_to_the_touch(off, status):
    """The clearance shrinks by 0.06 per unit of force: 1e-9 of it is 1e5 roundings."""
    wall, words = family(2.8, 0.02, 0.1, 0.8, 2)
    start = wall.start(wall.speeds(1.9)[0])
    before = ns.find_orbit(rigid_wall(F=1.9, **words), start, period=2)
    orbit = ns.find_orbit(rigid_wall(F=TOUCHING + off, **words), before, period=2)
    assert orbit.attrs["status"] == status


@pytest.mark.slow
def test_the_touch_again():
    wall, _ = family(2.8, 0.02, 0.1, 0.8, 2)
    _, force = wall.touching((wall.speeds(1.8)[0], wall.speeds(1.9)[0]))
    assert abs(float(force) - TOUCHING) < 4 * EPS * TOUCHING


def test_without_impact_up_to_grazing():
    """Just below the grazing force the linear motion is the orbit; its multipliers are known."""
    wall, words = family(0.8, 0.05, 0.5, 0.7, 1)
    force = float(wall.grazing_force)
    span, root = float(wall.span), -0.05 + 1j * np.sqrt(1 - 0.05**2)
    for share in (0.5, 0.999, 1 - 1e-9):
        response = complex(wall.response) * force * share
        start = {"x": response.real, "v": (0.8j * response).real}
        orbit = ns.find_orbit(rigid_wall(F=force * share, **words), start)
        assert orbit.attrs["status"] == "completed" and orbit["word"].item() == "free"
        assert_state(orbit, start)
        assert_multipliers(orbit, [np.exp(root * span), np.exp(np.conj(root) * span)])


@pytest.mark.parametrize("share", [1e-2, 1e-4, 1e-6])
def test_just_beyond_grazing_the_orbit_hits_slowly(share):
    """One impact of speed ~ share: multipliers grow as 1 / speed, the orbit stays known."""
    wall, words = family(0.8, 0.05, 0.5, 0.7, 1)
    force = wall.force(share)
    assert force > wall.grazing_force
    orbit = ns.find_orbit(rigid_wall(F=float(force), **words), wall.start(share), word="free free")
    assert orbit.attrs["status"] == "completed"
    # the speed, which the force fixes to first order, is lost by rounding of the force alone
    speed = float(wall.speeds(float(force))[0])
    assert abs(float(orbit["leg_states"].sel(state="v")[1]) + 0.7 * speed) < 1e-10
    assert_state(orbit, wall.start(speed))
    expected = wall.multipliers(speed)
    assert abs(expected[0]) > 0.1 / share
    # the largest is as exact as the speed is: rounding of some EPS in it, over its size
    allowed = 1e-9 + 100 * EPS / share
    assert abs(orbit["multipliers"].values[0] / complex(expected[0]) - 1) < allowed
