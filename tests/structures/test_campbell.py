"""Campbell diagrams against closed forms, and critical speeds against a direct eigenproblem."""

import math

import numpy as np
import pytest
import scipy.linalg

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, Disc, campbell, shaft, unbalance_response

MASS, TILTING, POLAR, SPRING, TURNING = 5.0, 0.06, 0.1, 2e5, 3e3


def jeffcott(damping=0.0, polar=POLAR):
    """A disc in the middle of a massless shaft: it moves and tilts, one apart from the other."""
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = polar, -polar
    return ns.Structure(
        np.diag([MASS, MASS, TILTING, TILTING]),
        np.diag([SPRING, SPRING, TURNING, TURNING]),
        damping=np.diag([damping, damping, 0.0, 0.0]),
        gyroscopic=gyroscopic,
        coordinates=["1x", "1y", "1rx", "1ry"],
    )


def tilting(speed, polar=POLAR):
    """Backward and forward frequency: Id w^2 - Ip speed w - k = 0."""
    root = np.sqrt((polar * speed) ** 2 + 4.0 * TILTING * TURNING)
    return np.abs(polar * speed - root) / (2 * TILTING), (polar * speed + root) / (2 * TILTING)


def test_curves_of_the_jeffcott_rotor():
    speeds = np.linspace(0.0, 800.0, 33)
    found = campbell(jeffcott(), speeds, count=4)
    moving = math.sqrt(SPRING / MASS)
    backward, forward = tilting(speeds)
    exact = np.sort(np.stack([np.full(33, moving), np.full(33, moving), backward, forward]), axis=0)
    curves = np.sort(found["damped_frequency"].values.T, axis=0)
    np.testing.assert_allclose(curves, exact, rtol=1e-12)
    # each curve is one of the four all the way, through the crossings
    names = {"moving": np.full(33, moving), "backward": backward, "forward": forward}
    kept = [
        next(name for name, each in names.items() if np.allclose(curve, each, rtol=1e-10))
        for curve in found["damped_frequency"].values.T
    ]
    assert sorted(kept) == ["backward", "forward", "moving", "moving"]


@pytest.mark.parametrize("polar", [0.02, 0.05, 0.1])
def test_critical_speeds_of_the_jeffcott_rotor(polar):
    """(Id - Ip) w^2 = k forward where the disc is not thin, (Id + Ip) w^2 = k backward."""
    found = campbell(jeffcott(polar=polar), np.linspace(0.0, 900.0, 10), count=4)
    exact = [math.sqrt(SPRING / MASS)] * 2 + [math.sqrt(TURNING / (TILTING + polar))]
    if polar < TILTING:
        exact.append(math.sqrt(TURNING / (TILTING - polar)))
    exact = sorted(each for each in exact if each < 900.0)
    np.testing.assert_allclose(found["critical_speed"], exact, rtol=1e-13)
    words = dict(
        zip(
            found["critical_speed"].values.round(6), found["critical_direction"].values, strict=True
        )
    )
    assert words[round(math.sqrt(TURNING / (TILTING + polar)), 6)] == "backward"


def test_a_damped_critical_speed_and_its_harmonics():
    """Im of -c/2m + i sqrt(k/m - (c/2m)^2) is the speed, or a multiple of it."""
    damping = 400.0
    exact = math.sqrt(SPRING / MASS - (damping / (2 * MASS)) ** 2)
    found = campbell(jeffcott(damping), [10.0, 90.0, 300.0], count=4, harmonics=[1.0, 2.0])
    moving = found["critical_damping_ratio"].values > 0.01
    np.testing.assert_allclose(
        found["critical_speed"].values[moving], [exact / 2] * 2 + [exact] * 2, rtol=1e-13
    )
    np.testing.assert_allclose(
        found["critical_damping_ratio"].values[moving],
        damping / (2 * math.sqrt(SPRING * MASS)),
        rtol=1e-13,
    )


def test_a_rigid_rotor_in_two_bearings():
    """By coordinates at the bearings, where those of the closed form are at the middle."""
    m, across, polar, half, k, c = 20.0, 0.9, 0.3, 0.35, 3e6, 900.0
    plane = np.array([[0.5, 0.5], [0.5 / half, -0.5 / half]])  # middle and tilt of A and B
    to_middle = np.kron(plane, np.eye(2))  # x, y and tilt in both, of "A x", "A y", "B x", "B y"
    inertia = np.diag([m, m, across, across])
    turning = np.zeros((4, 4))
    turning[2, 3], turning[3, 2] = polar, -polar
    rotor = ns.Structure(
        to_middle.T @ inertia @ to_middle,
        np.zeros((4, 4)),
        gyroscopic=to_middle.T @ turning @ to_middle,
        coordinates=["A x", "A y", "B x", "B y"],
        bearings=[Bearing([f"{end} x", f"{end} y"], k, c) for end in "AB"],
    )
    speeds = np.linspace(0.0, 2000.0, 11)
    found = campbell(rotor, speeds, count=4)
    bounce = np.roots([m, 2 * c, 2 * k])
    exact = []
    for speed in speeds:
        # p = slope in x + i slope in y: Id p'' + (2 c l^2 - i Ip speed) p' + 2 k l^2 p = 0
        pitch = np.roots([across, 2 * c * half**2 - 1j * polar * speed, 2 * k * half**2])
        every = np.concatenate([bounce[bounce.imag > 0], bounce[bounce.imag > 0], pitch])
        exact.append(every.real + 1j * np.abs(every.imag))
    for row, expected in zip(found["eigenvalue"].values, exact, strict=True):
        order = np.lexsort([expected.real, expected.imag.round(6)])
        ours = np.lexsort([row.real, row.imag.round(6)])
        np.testing.assert_allclose(row[ours], expected[order], rtol=1e-12)


def machine(n=20, bearings=None, sparse=False):
    held = bearings or [
        Bearing(["2x", "2y"], [[2e7, 4e6], [-3e6, 3e7]], [[3e4, 1e3], [1e3, 5e4]]),
        Bearing([f"{n - 2}x", f"{n - 2}y"], [[3e7, 2e6], [-2e6, 4e7]], 2e4),
    ]
    discs = [Disc.from_geometry(n // 3, 0.05, 0.3), Disc.from_geometry(n // 2, 0.07, 0.4)]
    return shaft([Beam(1.6 / n, 0.07)] * n, discs=discs, bearings=held, sparse=sparse)


def random_shaft(rng, *, isotropic):
    """Beams of different sizes, two discs and two bearings anywhere, without damping."""
    n = int(rng.integers(3, 14))
    held = []
    for node in rng.choice(n + 1, 2, replace=False):
        k = 10 ** rng.uniform(5.0, 8.5)
        other = k if isotropic else k * 10 ** rng.uniform(-0.5, 0.5)
        held.append(Bearing([f"{node}x", f"{node}y"], np.diag([k, other])))
    diameters = rng.uniform(0.03, 0.1) * rng.uniform(0.7, 1.3, n)
    beams = [Beam(rng.uniform(0.05, 0.2), each) for each in diameters]
    discs = [
        Disc.from_geometry(int(rng.integers(0, n + 1)), 0.05, rng.uniform(0.15, 0.6))
        for _ in range(2)
    ]
    return shaft(beams, discs=discs, bearings=held)


LONGEST = {0, 2, 7, 10}  # of the seeds
SEEDS = [pytest.param(k, marks=[pytest.mark.slow] * (k in LONGEST)) for k in range(12)]


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_critical_speeds_of_undamped_shafts_by_a_direct_eigenproblem(seed):
    """At a critical speed w the speed drops out: (K - w^2 (M - i G)) q = 0.

    All of them are found from 17 speeds, however close modes come to each other.
    """
    rng = np.random.default_rng(seed)
    rotor = random_shaft(rng, isotropic=seed % 3 == 0)
    M, _, K = rotor.at_speed(0.0)
    direct = scipy.linalg.eigvals(K, M - 1j * rotor.gyroscopic)
    real = (np.abs(direct.imag) < 1e-6 * np.abs(direct)) & (direct.real > 1.0)
    expected = np.sort(np.sqrt(direct.real[real]))
    found = campbell(rotor, np.linspace(0.0, 4000.0, 17), count=rotor.size // 2)["critical_speed"]
    # the direct problem has eps of its largest eigenvalue as its error
    np.testing.assert_allclose(found, expected[expected < 4000.0], rtol=1e-7)


@pytest.mark.slow
def test_critical_speeds_do_not_depend_on_the_grid():
    """Of a damped shaft in bearings that depend on the speed: found to rounding on each grid."""
    speeds = np.linspace(0.0, 1500.0, 6)
    table = np.array([[[2e7, 4e6], [-3e6, 3e7]]]) * (1.0 + (speeds / 1000.0)[:, None, None] ** 2)
    held = [
        Bearing(["2x", "2y"], table, 5e3, speeds=speeds),
        Bearing(["18x", "18y"], 4e7, lambda speed: 4e3 + 2 * speed),
    ]
    rotor = machine(bearings=held)
    coarse, fine = (campbell(rotor, np.linspace(0.0, 1500.0, n), count=6) for n in (13, 76))
    assert coarse.sizes["critical"] >= 4
    np.testing.assert_allclose(coarse["critical_speed"], fine["critical_speed"], rtol=1e-11)
    for speed, value in zip(
        fine["critical_speed"].values, fine["critical_eigenvalue"].values, strict=True
    ):
        modes = ns.structures.natural_modes(rotor, speed)["eigenvalue"].values
        nearest = modes[np.argmin(np.abs(modes - value))]
        assert abs(nearest - value) < 1e-9 * abs(value)
        assert value.imag == pytest.approx(speed, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_shaft_of_404_coordinates(sparse):
    """As many as engineers have; the curves are those of one speed at a time, in any order."""
    rotor = machine(100, sparse=sparse)
    found = campbell(rotor, np.linspace(0.0, 2000.0, 9), count=8)
    alone = ns.structures.natural_modes(rotor, 1500.0, count=16)["eigenvalue"].values
    for value in found["eigenvalue"].sel(speed=1500.0).values:
        assert np.abs(alone - value).min() < 1e-9 * abs(value)


def test_wrong_speeds_are_refused():
    with pytest.raises(ns.OptionError, match="speeds: give increasing ones"):
        campbell(jeffcott(), [1.0, 0.0])
    table = Bearing("1x", [1.0, 2.0], speeds=[0.0, 50.0])
    rotor = ns.Structure([[1.0]], [[1.0]], coordinates=["1x"], bearings=[table])
    with pytest.raises(
        ns.OptionError, match="speeds: 0 to 60 rad/s, and the tables of the bearings"
    ):
        campbell(rotor, [0.0, 60.0])
    with pytest.raises(ns.OptionError, match="harmonics"):
        campbell(jeffcott(), [0.0, 1.0], harmonics=[-1.0])


def test_overdamped_motions_have_no_critical_speed_at_rest():
    """A massive bearing in oil: its motions are overdamped at rest and whirl at no speed."""
    held = ns.Structure(
        np.eye(4),
        np.diag([1e4, 1e4, 1e4, 1e4]),
        damping=np.diag([10.0, 10.0, 500.0, 500.0]),
        coordinates=["1x", "1y", "2x", "2y"],
    )
    found = campbell(held, np.linspace(0.0, 300.0, 7), count=4)
    np.testing.assert_allclose(found["critical_speed"], [math.sqrt(1e4 - 25.0)] * 2, rtol=1e-12)


def test_critical_speeds_of_motions_that_are_overdamped_at_rest():
    """z'' + (c - i g speed) z' + k z = 0 with z = x + i y, whose roots are real at rest.

    With lambda = s + i speed forward and s - i speed backward: s = -c / (2 - g) and
    (1 - g) speed^2 = k - c^2 (1 - g) / (2 - g)^2, and the same with -g.
    """
    c, k, g = 10.0, 24.0, 0.9
    held = ns.Structure(
        np.eye(2),
        k * np.eye(2),
        damping=c * np.eye(2),
        gyroscopic=[[0.0, g], [-g, 0.0]],
        coordinates=["1x", "1y"],
    )
    found = campbell(held, np.linspace(0.0, 20.0, 11))
    exact = [math.sqrt(k / (1 + s) - (c / (2 + s)) ** 2) for s in (g, -g)]
    np.testing.assert_allclose(found["critical_speed"], exact, rtol=1e-12)
    assert found["critical_direction"].values.tolist() == ["backward", "forward"]
    rates = found["critical_eigenvalue"].values.real
    np.testing.assert_allclose(rates, [-c / (2 + g), -c / (2 - g)], rtol=1e-12)
    # both are damped beyond any resonance
    ratios = [math.sin(math.atan2(c / (2 + s), at)) for s, at in zip((g, -g), exact, strict=True)]
    np.testing.assert_allclose(found["critical_amplification"], 0.5 / np.array(ratios), rtol=1e-11)
    assert (found["critical_amplification"] < 2.5).all()


def test_the_amplification_factor_of_what_does_not_decay_is_infinite():
    assert np.isinf(campbell(jeffcott(), [10.0, 300.0])["critical_amplification"]).any()


def test_the_amplification_factor_is_that_of_the_unbalance_response():
    """The critical speed over the width of the peak at half power, for small damping."""
    ratio = 0.01
    disc = ns.Structure(
        [[1.0, 0.0], [0.0, 1.0]], 1e4 * np.eye(2), damping=200.0 * ratio * np.eye(2),
        coordinates=["1x", "1y"],
    )  # fmt: skip
    speeds = np.linspace(90.0, 110.0, 20001)
    amplitude = unbalance_response(disc, speeds, (1, 1e-4))["amplitude"].sel(coordinate="1x")
    wide = speeds[amplitude.values >= amplitude.values.max() / math.sqrt(2.0)]
    found = campbell(disc, [0.0, 90.0, 150.0])
    measured = found["critical_speed"][0] / (wide[-1] - wide[0])
    # terms of the order of the squared damping are left out, and steps of the speeds
    assert found["critical_amplification"][0] == pytest.approx(float(measured), rel=20 * ratio**2)


def damped_gyroscopic(rng, n=4):
    """Matrices without any pattern."""
    a, b, c, g = rng.normal(size=(4, n, n))
    mass, stiffness = a @ a.T + np.eye(n), 1e4 * (b @ b.T + np.eye(n))
    return mass, stiffness, 60.0 * (c @ c.T), 3.0 * (g - g.T)


@pytest.mark.parametrize("seed", [6, 7, 18])
def test_critical_speeds_of_a_mode_that_begins_to_oscillate_are_those_by_numpy(seed):
    """Of heavily damped structures, by the number of eigenvalues above the line of the speed."""
    mass, stiffness, damping, gyroscopic = damped_gyroscopic(np.random.default_rng(seed))
    n, inverse = len(mass), np.linalg.inv(mass)

    def above(speed):
        lower = [-inverse @ stiffness, -inverse @ (damping + speed * gyroscopic)]
        values = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], lower]))
        return int((values.imag > speed).sum())

    fine = np.linspace(0.01, 400.0, 1500)
    places = np.flatnonzero(np.diff([above(speed) for speed in fine]))
    rotor = ns.Structure(mass, stiffness, damping=damping, gyroscopic=gyroscopic)
    found = campbell(rotor, np.linspace(0.0, 400.0, 41))["critical_speed"].values
    assert len(found) == len(places)
    assert ((found > fine[places]) & (found < fine[places + 1])).all()


def test_without_a_mode_that_oscillates_there_is_a_word():
    slow = ns.Structure([[1.0]], [[100.0]], damping=[[25.0]])
    with pytest.warns(ns.ResultWarning, match="no mode oscillates from 0 to 50 rad/s"):
        found = campbell(slow, [0.0, 50.0])
    assert found.sizes["mode"] == found.sizes["critical"] == 0
