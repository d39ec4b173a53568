"""A shaft with many modes that rubs a ring, against the algebra of its receptances."""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, Disc, RubRing, Unbalance, machine, reduce, shaft

K, F, GAP, MOMENT = 2e6, 0.05, 1e-4, 2e-4


@pytest.fixture(scope="module")
def small():
    """A disc amid a shaft, in equal bearings that grow stiffer with the speed."""
    table = {"stiffness": [2e6, 3e6], "damping": [2e3, 1.5e3], "speeds": [0.0, 600.0]}
    whole = shaft(
        [Beam(0.3, 0.03)] * 2,
        discs=[Disc(1, 10.0, 0.1, 0.15)],
        bearings=[Bearing([f"{node}x", f"{node}y"], **table) for node in (0, 2)],
        damping=(0.0, 5e-5),
    )
    return reduce(whole, ["1x", "1y"], modes=4)


@pytest.fixture(scope="module")
def rubbing(small):
    ring = RubRing("1x", "1y", GAP, K, friction=F, radius=0.05)
    return machine(small, [ring], [Unbalance("1x", "1y", MOMENT)], Omega=350.0)


def at_the_ring(small):
    return small.basis[[small.structure.index(name) for name in ("1x", "1y")]]


def annular(small, speed):
    """Full annular rubs: complex displacements of the shaft, by a quadratic equation for |z|.

    The ring presses with -K (1 - GAP/|z|)(1 + i F) z on a shaft whose receptance is H.
    """
    mass, damping, stiffness = small.at_speed(speed)
    rows = at_the_ring(small)
    whole = stiffness + 1j * speed * damping - speed**2 * mass
    H = (rows @ np.linalg.solve(whole, rows.T @ [1.0, -1j]))[0]
    a, free = H * K * (1 + 1j * F), H * MOMENT * speed**2
    middle = -2 * GAP * ((1 + a) * a.conjugate()).real
    radii = np.roots([abs(1 + a) ** 2, middle, abs(a * GAP) ** 2 - abs(free) ** 2])
    return [free / (1 + a * (1 - GAP / r)) for r in np.sort(radii[radii.imag == 0].real) if r > GAP]


def deviations(small, speed, z):
    """Eigenvalues of what lies beside an annular rub, in coordinates that turn with the shaft.

    The shaft is the same in all directions, so these are constant; a quarter turn of all modes is
    what the basis makes of a quarter turn of the nodes.
    """
    mass, damping, stiffness = small.at_speed(speed)
    nodes = np.kron(np.eye(small.structure.size // 2), [[0.0, -1.0], [1.0, 0.0]])
    quarter = np.linalg.lstsq(small.basis, nodes @ small.basis, rcond=None)[0]
    rows, along = at_the_ring(small), np.array([z.real, z.imag]) / abs(z)
    share = GAP / abs(z)
    push = [[1.0, -F], [F, 1.0]] @ ((1 - share) * np.eye(2) + share * np.outer(along, along))
    held = stiffness + speed * damping @ quarter - speed**2 * mass + K * rows.T @ push @ rows
    damped = damping + 2 * speed * mass @ quarter
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    return np.linalg.eigvals(
        np.block([[zero, one], [-np.linalg.solve(mass, held), -np.linalg.solve(mass, damped)]])
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("speed", [335.0, 360.0, 385.0])
def test_full_annular_rub_is_that_of_the_receptances(small, rubbing, speed):
    z = annular(small, speed)[-1]
    settled = ns.simulate(rubbing, periods=100, parameters={"Omega": speed})
    orbit = ns.find_orbit(rubbing, settled, parameters={"Omega": speed})
    assert ns.phase_word(ns.simulate(rubbing, orbit, periods=1, parameters={"Omega": speed})) == (
        "contact,forward_slip",
    )
    # the basis of the reduction is exact here but for rounding
    assert abs(complex(float(orbit["x1"]), float(orbit["y1"])) - z) < 1e-8 * GAP
    largest = np.abs(orbit["multipliers"].values).max()
    growth = deviations(small, speed, z).real.max()
    assert np.log(largest) * speed / (2 * np.pi) == pytest.approx(growth, rel=1e-6)


@pytest.mark.slow
def test_it_ends_where_its_two_radii_are_one(small, rubbing):
    settled = ns.simulate(rubbing, periods=100, parameters={"Omega": 385.0})
    near = annular(small, 455.0)[-1]
    start = ns.find_orbit(rubbing, settled, parameters={"Omega": 385.0})
    branch = ns.continue_orbit(
        rubbing, "Omega", (380.0, 500.0), initial=start, parameters={"Omega": 385.0}, direction="up"
    )
    fold = branch["special_value"].values[branch["special_kind"].values == "fold"]
    low, high = 455.0, 480.0  # two radii, and none
    assert near and not annular(small, high)
    while high - low > 1e-10 * low:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if annular(small, middle) else (low, middle)
    assert fold[0] == pytest.approx(low, rel=1e-8)


def test_contact_is_a_word_of_the_names_of_its_cells(rubbing):
    given = {"parameters": {"Omega": 350.0}, "transient": 100, "record": 5, "of": "rub1_force"}
    found = ns.contact_statistics(rubbing, **given)
    cells = ["contact,forward_slip", "contact,backward_slip", "contact,rolling"]
    assert found.equals(ns.contact_statistics(rubbing, contact=cells, **given))
    assert float(found["contact_share"]) == 1.0


def overhung():
    """A disc beside two bearings."""
    rotor = shaft(
        [Beam(0.1, 0.04)] * 8,
        discs=[Disc(8, 25.0, 0.35, 0.65)],
        bearings=[Bearing([f"{node}x", f"{node}y"], 7e6, 150.0) for node in (0, 5)],
    )
    return reduce(rotor, ["8x", "8y"], modes=8)


@pytest.mark.slow
def test_a_shaft_with_many_modes_rolls_in_its_ring():
    """Dry whip ends on a circle with the frequency -Omega R/r: a matter of the receptance there.

    Real part: k (r - gap) presses where the shaft itself would like to be farther out. Imaginary
    part: what the damping takes at that frequency is the friction that keeps it rolling.
    """
    small, omega, radius, k, gap = overhung(), 60.0, 0.02, 1e7, 1e-4
    ring = RubRing("8x", "8y", gap, k, friction=0.3, radius=radius)
    system = machine(small, [ring], Omega=omega, period="2*pi/Omega")
    assert "contact,rolling" in system.mode_names
    mass, damping, stiffness = small.at_speed(omega)
    rows = small.basis[[small.structure.index(name) for name in ("8x", "8y")]]
    circle = np.array([1.0, -1j])  # x + iy of the real part of circle*exp(i w t) turns with w

    def dynamic_stiffness(frequency):
        whole = stiffness + 1j * frequency * damping - frequency**2 * mass
        return 1.0 / (rows @ np.linalg.solve(whole, rows.T @ circle))[0]

    def pressed(r):
        return dynamic_stiffness(-omega * radius / r).real * r + k * (r - gap)

    run = ns.simulate(system, {"x8": 2e-4, "vy8": -0.2}, t_end=20.0)
    assert run.attrs["status"] == "completed"
    assert ns.phase_word(run)[-1] == "contact,rolling"
    r = brentq(pressed, 2.2e-3, 2.5e-3, xtol=1e-16)
    assert float(run["rub1_radius_of_whirl"][-1]) == pytest.approx(r, rel=1e-9)
    friction = dynamic_stiffness(-omega * radius / r).imag * r
    assert float(run["rub1_friction"][-1]) == pytest.approx(friction, rel=1e-7)
