"""Natural modes against closed forms: chains of masses, beams and shafts on pinned ends."""

import math

import mpmath
import numpy as np
import pytest
import scipy.sparse as sp

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, natural_modes, shaft

EPS = float(np.finfo(float).eps)


def chain(n, *, planes=1, sparse=False, k=7.0, m=3.0):
    """Masses between springs and two walls, in one or more planes."""
    one = sp.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    stiffness, mass = (
        sp.kron(sp.eye_array(planes), each) for each in (k * one, m * sp.eye_array(n))
    )
    if not sparse:
        stiffness, mass = stiffness.toarray(), mass.toarray()
    return ns.Structure(mass, stiffness)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("planes", [1, 2, 3])
@pytest.mark.parametrize("n", [4, 30, 100, 400])
def test_a_chain_of_masses(n, planes, sparse):
    """Frequencies 2 sqrt(k/m) sin(j pi/(2n + 2)), each of them once for each plane.

    Rounding of the matrices, some eps of the largest eigenvalue of K, moves a squared frequency by
    as much; the first-order form that is decomposed adds a few.
    """
    found = natural_modes(chain(n, planes=planes, sparse=sparse), count=min(10, n * planes))
    half = np.repeat(np.arange(1, n + 1), planes)[: found.sizes["mode"]] * math.pi / (2 * n + 2)
    exact = 2.0 * math.sqrt(7.0 / 3.0) * np.sin(half)
    error = np.abs(found["natural_frequency"].values / exact - 1.0)
    assert (error <= 8.0 * EPS * (1.0 + 1.0 / np.sin(half) ** 2)).all()
    assert (np.abs(found["damping_ratio"].values) <= 1e-12 / np.sin(half)).all()


def test_all_modes_of_a_chain_in_one_call():
    found = natural_modes(chain(60))
    exact = 2.0 * math.sqrt(7.0 / 3.0) * np.sin(np.arange(1, 61) * math.pi / 122)
    np.testing.assert_allclose(found["natural_frequency"], exact, rtol=1e-12)


def test_shapes_solve_the_equations():
    """Of a structure with all matrices full; the residual is rounding of the terms."""
    rng = np.random.default_rng(1)
    a, b, c, g = rng.normal(size=(4, 9, 9))
    structure = ns.Structure(a @ a.T, b @ b.T, damping=c @ c.T, gyroscopic=g - g.T)
    found = natural_modes(structure, 2.0)
    assert found.sizes["mode"] >= 9
    M, C, K = structure.at_speed(2.0)
    for value, shape in zip(found["eigenvalue"].values, found["shape"].values.T, strict=True):
        residual = value**2 * M @ shape + value * C @ shape + K @ shape
        sizes = [np.linalg.norm(each, 2) for each in (M, C, K)]
        whole = abs(value) ** 2 * sizes[0] + abs(value) * sizes[1] + sizes[2]
        assert np.linalg.norm(residual) < 1e-13 * whole * np.linalg.norm(shape)
        assert np.abs(shape).max() == pytest.approx(1.0, rel=1e-9)


def test_damping_as_it_is_defined():
    """One mass with damping ratios below and above one."""
    found = natural_modes(ns.Structure([[1.0]], [[4.0]], damping=[[0.8]]))
    assert found["natural_frequency"].item() == pytest.approx(2.0, rel=1e-14)
    assert found["damping_ratio"].item() == pytest.approx(0.2, rel=1e-14)
    assert found["damped_frequency"].item() == pytest.approx(2.0 * math.sqrt(0.96), rel=1e-14)
    decrement = 2.0 * math.pi * 0.2 / math.sqrt(0.96)
    assert found["log_decrement"].item() == pytest.approx(decrement, rel=1e-13)
    slow = natural_modes(ns.Structure([[1.0]], [[4.0]], damping=[[5.0]]))
    np.testing.assert_allclose(slow["eigenvalue"], [-1.0, -4.0], rtol=1e-14)
    assert np.isnan(slow["log_decrement"]).all()


@pytest.mark.parametrize("n", [5, 200])
def test_a_floating_structure_has_rigid_motions_once(n):
    """Masses between springs without walls, in two planes: two motions without a force."""
    one = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    one[0, 0] = one[-1, -1] = 1.0
    found = natural_modes(ns.Structure(np.eye(2 * n), np.kron(np.eye(2), one)), count=6)
    exact = 2.0 * np.sin(np.repeat(np.arange(3), 2) * math.pi / (2 * n))
    np.testing.assert_allclose(found["natural_frequency"], exact, rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("n", [4, 18, 60])
def test_a_floating_shaft_that_turns(n):
    """Displacements and tilts ask for no force; a tilted rod goes around at Ip/Id of the speed.

    It bends by (frequency over that of bending) squared, here 1e-6 of its tilt.
    """
    beam = Beam(1.5 / n, 0.05)
    modes = natural_modes(shaft([beam] * n), 300.0, count=6)
    assert (modes["natural_frequency"].values[:4] == 0.0).all()
    mass, radius = n * beam.mass, 0.025
    polar, across = mass * radius**2 / 2, mass * (radius**2 / 4 + 1.5**2 / 12)
    assert modes["natural_frequency"].values[4] == pytest.approx(300.0 * polar / across, rel=1e-5)
    assert modes["direction"].values[4] == "forward"


@pytest.mark.parametrize("n", [4, 18, 60])
def test_a_soft_support_is_no_floating_one(n):
    """A frequency a millionth of that of an element: rounding leaves it four digits."""
    held = [Bearing([f"{i}x", f"{i}y"], 1.0) for i in (0, n)]
    beam = Beam(1.5 / n, 0.05)
    modes = natural_modes(shaft([beam] * n, bearings=held), count=4)
    exact = math.sqrt(2.0 / (n * beam.mass))
    np.testing.assert_allclose(modes["natural_frequency"].values[:2], exact, rtol=1e-4)


def pinned(n, beam, length=1.5):
    """A shaft of n elements on pinned ends, which may tilt."""
    free = shaft([Beam(length / n, **beam)] * n)
    return free.fixed(["0x", "0y", f"{n}x", f"{n}y"])


def timoshenko(beam, number, speed, length=1.5):
    """Frequencies of a turning shaft on pinned ends, forward positive, from its two equations.

    With the deflection W sin(b z) and the slope P cos(b z) of a section, b = number pi/length:
    (k G A b^2 - rho A w^2) W = k G A b P from the forces, and from the moments
    (E I b^2 + k G A - rho I (w^2 - 2 speed w)) P = k G A b W. Without shear k G A is infinite.
    """
    one = Beam(1.0, **beam)
    b = number * mpmath.pi / length
    rho_a, rho_i = one.density * one.area, one.density * one.second_moment * one.rotary_inertia
    bent = one.youngs_modulus * one.second_moment
    if not one.shear:
        # b W = P: (E I b^4 - rho I b^2 (w^2 - 2 speed w)) W = rho A w^2 W
        terms = [rho_a + rho_i * b**2, -2 * rho_i * b**2 * speed, -bent * b**4]
    else:
        sheared = 12 * bent / one.shear_ratio
        terms = [
            rho_a * rho_i,
            -2 * rho_a * rho_i * speed,
            -(rho_a * (bent * b**2 + sheared) + sheared * b**2 * rho_i),
            2 * sheared * b**2 * rho_i * speed,
            sheared * b**2 * bent * b**2,
        ]
    roots = mpmath.polyroots(terms[::-1], maxsteps=200, extraprec=200, asc=True)
    real = sorted((float(each.real) for each in roots), key=abs)
    return np.array(real[:2])


BEAMS = {
    "Euler and Bernoulli": {"diameter": 0.06, "shear": False, "rotary_inertia": False},
    "Rayleigh": {"diameter": 0.2, "shear": False},
    "Timoshenko": {"diameter": 0.2},
    "hollow": {"diameter": 0.24, "inner_diameter": 0.16, "poissons_ratio": 0.27},
}


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize("speed", [0.0, 700.0])
def test_a_pinned_shaft_converges_to_the_exact_one(name, speed):
    """Errors of the third pair of modes fall by 16 with each halving; with shear, which is constant
    in an element, by 4. They come from above.
    """
    exact = np.sort(np.abs(timoshenko(BEAMS[name], 3, speed)))
    errors = []
    for n in (12, 24, 48):
        modes = natural_modes(pinned(n, BEAMS[name]), speed, count=6)
        errors.append(np.sort(modes["natural_frequency"].values)[4:6] / exact - 1.0)
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (np.array(errors) > 0.0).all()
    assert rates == pytest.approx(4.0 if "shear" in BEAMS[name] else 2.0, abs=0.05)
    assert np.max(errors[-1]) < (1e-5 if "shear" in BEAMS[name] else 1e-3)


def test_forward_and_backward_whirl_of_a_pinned_shaft():
    """The faster of two modes of a turning shaft is forward in all its nodes."""
    modes = natural_modes(pinned(10, BEAMS["Timoshenko"]), 500.0, count=4)
    assert modes["direction"].values.tolist() == ["backward", "forward"] * 2
    np.testing.assert_allclose(np.abs(modes["whirl"]), 1.0, rtol=1e-9)


def test_sparse_and_dense_shafts_are_one():
    beams, held = (
        [Beam(0.1, 0.05)] * 30,
        [Bearing(["0x", "0y"], 1e7, 50.0), Bearing(["30x", "30y"], 2e7)],
    )
    dense, sparse = (shaft(beams, bearings=held, sparse=each) for each in (False, True))
    left, right = (natural_modes(each, 300.0, count=6)["eigenvalue"] for each in (dense, sparse))
    np.testing.assert_allclose(left, right, rtol=1e-11)


def test_an_overhung_disc_on_springs_that_bind():
    """Modes of a shaft clamped at one end in the limit of a massless shaft, by its flexibility.

    The stiffness of a clamped beam at its end is exact in the element, so a shaft without mass
    and a disc are the four equations of Stodola's rotor.
    """
    beam = Beam(0.5, 0.03, density=1e-9, shear=False, rotary_inertia=False)
    disc = ns.structures.Disc(1, 8.0, 0.04, 0.075)
    rotor = shaft([beam], discs=[disc]).fixed(["0x", "0y", "0rx", "0ry"])
    speed = 400.0
    bent = beam.youngs_modulus * beam.second_moment
    k11, k12, k22 = 12 * bent / 0.5**3, -6 * bent / 0.5**2, 4 * bent / 0.5
    # (k11 - m w^2)(k22 - Id w^2 + Ip speed w) = k12^2
    terms = np.polymul([-8.0, 0.0, k11], [-0.04, 0.075 * speed, k22])
    terms[-1] -= k12**2
    exact = sorted(
        float(each.real) for each in mpmath.polyroots(terms.tolist()[::-1], extraprec=100, asc=True)
    )
    modes = natural_modes(rotor, speed)
    found = modes["damped_frequency"] * np.where(modes["direction"] == "forward", 1.0, -1.0)
    np.testing.assert_allclose(sorted(found.values), exact, rtol=1e-9)


def test_what_cannot_be_computed_is_refused():
    with pytest.raises(ns.ModelError, match="mass: coordinates without inertia, 1y"):
        natural_modes(ns.Structure(np.diag([1.0, 0.0]), np.eye(2), coordinates=["1x", "1y"]))
    with pytest.raises(ns.ModelError, match="mass is singular"):
        natural_modes(ns.Structure(np.ones((2, 2)), np.eye(2)))
    with pytest.raises(ns.OptionError, match="count = 0 must be"):
        natural_modes(chain(4), count=0)


def test_forward_is_the_sense_in_which_the_shaft_turns():
    """The mirror image of a shaft that turns the other way has the same words."""
    disc = ns.Structure(
        np.eye(2), 4.0 * np.eye(2), gyroscopic=[[0.0, 0.3], [-0.3, 0.0]], coordinates=["1x", "1y"]
    )
    words = [natural_modes(disc, speed)["direction"].values.tolist() for speed in (5.0, -5.0)]
    assert words[0] == words[1] and set(words[0]) == {"forward", "backward"}


@pytest.mark.parametrize("n", [4, 30])
@pytest.mark.parametrize("speed", [0.0, 300.0])
def test_without_damping_the_ratio_is_zero_without_a_sign(n, speed):
    held = [ns.structures.Bearing([f"{i}x", f"{i}y"], [[2e6, 0.0], [0.0, 1e6]]) for i in (0, n)]
    disc = ns.structures.Disc.from_geometry(n // 2, 0.02, 0.2, 0.02)
    rotor = ns.structures.shaft(
        [ns.structures.Beam(0.6 / n, 0.02)] * n, discs=[disc], bearings=held
    )
    found = natural_modes(rotor, speed, count=4)
    diagram = ns.structures.campbell(rotor, [0.0, speed + 50.0, 2.0 * speed + 100.0], count=2)
    decays = [found["damping_ratio"], found["log_decrement"], diagram["damping_ratio"]]
    decays += [diagram["critical_damping_ratio"], found["eigenvalue"].real]
    for each in decays:
        assert each.size == 0 or not each.values.any()
    for each in decays[:-1]:
        assert not np.signbit(each.values).any()
    assert speed == 0.0 or diagram.sizes["critical"]


@pytest.mark.parametrize("n", [6, 30])
@pytest.mark.parametrize("beta", [1e-18, 1e-14, 1e-9, -1e-14])
def test_the_least_damping_is_known_to_its_digits(n, beta):
    """Of damping in proportion to the stiffness the ratio is beta omega / 2, of either sign.

    Rounding of an eigenvalue is that of the largest one, 1e4 to 1e6 times these, or 1e-12 of them;
    as much of other modes is in a vector, whose share in the loss is as large.
    """
    held = [ns.structures.Bearing([f"{i}x", f"{i}y"], [[2e6, 0.0], [0.0, 1e6]]) for i in (0, n)]
    beam = ns.structures.shaft([ns.structures.Beam(0.6 / n, 0.02)] * n, bearings=held)
    mass, _, stiffness = beam.at_speed(0.0)
    found = natural_modes(ns.Structure(mass, stiffness, damping=beta * stiffness), count=4)
    ratio = found["damping_ratio"] / (0.5 * beta * found["natural_frequency"])
    np.testing.assert_allclose(ratio, 1.0, rtol=1e-9)


@pytest.mark.parametrize("cross", [1e-9, 1e-7, 1e-5])
def test_the_least_cross_stiffness_drives_one_whirl_and_damps_the_other(cross):
    """With z = x + i y: z'' + (4 - i cross) z = 0, so the growth of one is the decay of the other.

    Vectors of eigenvalues so near each other are known to EPS 4 / cross, of which the balance of
    powers has the square.
    """
    found = natural_modes(ns.Structure(np.eye(2), [[4.0, cross], [-cross, 4.0]]))
    exact = cross / 4.0 * (1.0 - cross**2 / 128.0)  # imaginary part of the root, in series
    np.testing.assert_allclose(np.sort(found["eigenvalue"].values.real), [-exact, exact],
                               rtol=1e-9)  # fmt: skip


def test_growth_without_any_feed_stays():
    """Where gyroscopic moments just fail to hold what falls, powers are in balance all the same.

    x'' + g y' - x = 0, y'' - g x' - y = 0: the eigenvalues are (+-i g +- sqrt(4 - g^2)) / 2.
    """
    g = 2.0 * np.sqrt(1.0 - 1e-8)
    falling = ns.Structure(np.eye(2), -np.eye(2), gyroscopic=[[0.0, g], [-g, 0.0]])
    found = natural_modes(falling, 1.0)["eigenvalue"].values
    np.testing.assert_allclose(np.sort(found.real), [-1e-4, 1e-4], rtol=1e-6)
