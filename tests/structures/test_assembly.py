"""Beams in one plane, shafts in torsion and structures of several parts against closed forms."""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth.structures import (
    Beam,
    Bearing,
    Disc,
    RectangularBeam,
    assemble,
    natural_modes,
    plane_beam,
    shaft,
    static_deflection,
    torsional_shaft,
)

LENGTH, WIDTH, HEIGHT = 0.3, 0.02, 0.002
E, RHO, NU = 7.0e10, 2700.0, 0.33
MATERIAL = {"youngs_modulus": E, "density": RHO, "poissons_ratio": NU}
# roots of 1 + cos x cosh x
ROOTS = [
    brentq(lambda x: 1 / np.cosh(x) + np.cos(x), *ends, xtol=1e-15)
    for ends in ((1, 3), (4, 6), (7, 9))
]


def strip(n, height=HEIGHT, **others):
    beam = RectangularBeam(LENGTH / n, width=WIDTH, height=height, **MATERIAL, **others)
    return plane_beam([beam] * n)


def frequencies(structure, count):
    return natural_modes(structure, count=count)["natural_frequency"].values


def test_a_cantilever_of_euler_and_bernoulli():
    """The error of cubic elements is (x/n)^4/720 of the square of a frequency."""
    n = 20
    blade = strip(n, shear=False, rotary_inertia=False).fixed(["0x", "0ry"])
    known = np.array(ROOTS) ** 2 * np.sqrt(E * HEIGHT**2 / (12 * RHO * LENGTH**4))
    found = frequencies(blade, 3)
    bound = (np.array(ROOTS) / n) ** 4 / 1440
    assert (found >= known * (1 - 1e-9)).all()
    assert (found / known - 1 < 1.1 * bound + 1e-9).all()


def test_the_deflection_of_a_deep_cantilever_has_that_of_shear():
    """P L^3/(3 E I) + P L/(kappa G A), with Cowper's coefficient of a rectangle."""
    blade = strip(7, height=0.1).fixed(["0x", "0ry"])
    found = static_deflection(blade, {"7x": 5.0})["displacement"].sel(coordinate="7x")
    kappa, G = 10 * (1 + NU) / (12 + 11 * NU), E / (2 * (1 + NU))
    area = WIDTH * 0.1
    known = 5.0 * (LENGTH**3 / (3 * E * WIDTH * 0.1**3 / 12) + LENGTH / (kappa * G * area))
    assert abs(float(found) / known - 1) < 1e-10


def test_rotary_inertia_of_a_free_beam():
    """A turn about the middle has the energy of a rigid block, m (L^2 + h^2)/12."""
    structure = strip(4, height=0.1)
    z = np.linspace(-LENGTH / 2, LENGTH / 2, 5)
    turn = np.column_stack([z, np.ones(5)]).ravel()
    mass = RHO * WIDTH * 0.1 * LENGTH
    known = mass * (LENGTH**2 + 0.1**2) / 12
    assert abs(turn @ structure.mass @ turn / known - 1) < 1e-12
    assert np.abs(structure.stiffness @ turn).max() < 1e-12 * structure.stiffness.max()


@pytest.mark.parametrize("sparse", [False, True])
def test_a_round_beam_is_a_shaft_in_one_plane(sparse):
    """With discs, bearings and damping; both planes of a shaft that stands still are this one."""
    parts = {
        "discs": [Disc(2, 3.0, 0.01, 0.02)],
        "bearings": [Bearing(["0x"], 1e6, 30.0), Bearing(["4x"], 2e6)],
        "damping": (2.0, 1e-5),
    }
    beams = [Beam(0.1, 0.03, 0.01)] * 4
    whole = shaft(beams, **parts, sparse=sparse)
    across = [name for name in whole.coordinates if name[1:] in ("y", "rx")]
    one = plane_beam(beams, **parts, sparse=sparse)
    for ours, its in zip(one.at_speed(0.0), whole.fixed(across).at_speed(0.0), strict=True):
        assert abs(ours - its).max() == 0.0
    assert one.sparse is sparse


def polar(diameter):
    return np.pi / 32 * diameter**4


def test_a_shaft_in_torsion():
    """One end held: frequencies (k - 1/2) pi c/L, with an error of the phase squared over 24."""
    n, length = 40, 1.3
    held = torsional_shaft([Beam(length / n, 0.04, 0.02, **MATERIAL)] * n).fixed("0rz")
    speed = np.sqrt(E / (2 * (1 + NU)) / RHO)
    phases = (np.arange(1, 4) - 0.5) * np.pi
    found = frequencies(held, 3) * length / speed
    excess = found / phases - 1
    known = (phases / n) ** 2 / 24
    assert np.abs(excess / known - 1).max() < 0.01  # the next term is 1/27 of the phase squared


def test_a_flywheel_and_a_twist():
    """Held at one end, a disc of inertia J at the other: x tan x = I/J; and twist T L/(G I_p)."""
    n, length, diameter, inertia = 60, 0.8, 0.05, 0.02
    disc = Disc(n, 1.0, inertia, inertia)
    held = torsional_shaft([Beam(length / n, diameter, **MATERIAL)] * n, discs=[disc]).fixed("0rz")
    G = E / (2 * (1 + NU))
    own = RHO * polar(diameter) * length
    x = brentq(lambda x: x * np.tan(x) - own / inertia, 1e-3, 1.5, xtol=1e-15)
    found = frequencies(held, 1)[0]
    assert abs(found / (x / length * np.sqrt(G / RHO)) - 1) < 1.1 * (x / n) ** 2 / 24 + 1e-10
    twist = static_deflection(held, {f"{n}rz": 7.0})["displacement"].sel(coordinate=f"{n}rz")
    assert abs(float(twist) / (7.0 * length / (G * polar(diameter))) - 1) < 1e-11


def test_a_free_shaft_turns():
    free = torsional_shaft([Beam(0.1, 0.05)] * 3, discs=[Disc(0, 1.0, 0.1, 0.2)])
    modes = natural_modes(free, count=2)
    assert modes["natural_frequency"].values[0] < 1e-3 * modes["natural_frequency"].values[1]
    total = free.mass.sum()
    known = 0.2 + Beam(0.3, 0.05).density * polar(0.05) * 0.3
    assert abs(total / known - 1) < 1e-13


@pytest.mark.parametrize("sparse", [False, True])
def test_two_shafts_with_gears(sparse):
    """Stiff shafts: both inertias on a mesh, with sqrt(k (r1^2/J1 + r2^2/J2))."""
    mesh, radii, inertias = 1e6, (0.04, 0.06), (1e-3, 4e-3)
    parts = {
        name: torsional_shaft(
            [Beam(1e-3, 0.001)], discs=[Disc(0, 1.0, inertia, inertia)], sparse=sparse
        ).fixed("1rz")
        for name, inertia in zip(("pinion", "wheel"), inertias, strict=True)
    }
    row = np.array([radii[0], -radii[1]])
    teeth = Bearing(["pinion 0rz", "wheel 0rz"], mesh * np.outer(row, row))
    pair = assemble(parts, bearings=[teeth])
    assert pair.sparse is sparse
    assert pair.coordinates == ("pinion 0rz", "wheel 0rz")
    known = np.sqrt(mesh * (row**2 / inertias).sum())
    # what the wires add: their stiffness 8 N m/rad to 1600, their inertia 1e-13 to 1e-3
    own = Beam(1e-3, 0.001)._torsion.stiffness / 1e-3
    assert abs(frequencies(pair, 2)[1] / known - 1) < own / (mesh * radii[0] ** 2) + 1e-9


def test_bearings_and_gyroscopic_matrices_of_parts_stay():
    rotor = shaft([Beam(0.2, 0.05)] * 2, bearings=[Bearing(["0x", "0y"], 1e7, 5.0, name="left")])
    casing = ns.Structure([[5.0]], [[1e6]], coordinates=["1x"])
    both = assemble({"rotor": rotor, "casing": casing})
    for whole, its, other in zip(
        both.at_speed(80.0), rotor.at_speed(80.0), casing.at_speed(80.0), strict=True
    ):
        assert np.array_equal(whole[:-1, :-1], its)
        assert np.array_equal(whole[-1:, -1:], other)
        assert not whole[-1, :-1].any() and not whole[:-1, -1].any()
    assert both.bearings[0].name == "left"


def test_what_is_refused():
    with pytest.raises(ns.ModelError, match="there is none"):
        plane_beam([])
    with pytest.raises(ns.ModelError, match="there is no node 3"):
        torsional_shaft([Beam(0.1, 0.02)] * 2, discs=[Disc(3, 1.0, 1.0, 1.0)])
    with pytest.raises(ns.ModelError, match=r"height = -1 must be positive"):
        RectangularBeam(0.1, 0.1, -1.0)
    with pytest.raises(ns.ModelError, match="parts: there is none"):
        assemble({})
    with pytest.raises(ns.NonsmoothError, match="parts"):
        assemble({"a": 3.0})


@pytest.mark.parametrize("factors", [(-1.0, 0.0), (0.0, -1e-6), (1.0,), (0.0, 1.0, 2.0)])
def test_rayleigh_damping_that_feeds_energy_in_is_refused(factors):
    """In all shafts; two factors are given, neither of them negative."""
    for make in (shaft, plane_beam, torsional_shaft):
        with pytest.raises(ns.OptionError, match=r"damping = .*: (a negative factor|give two)"):
            make([Beam(0.2, 0.05)], damping=factors)
