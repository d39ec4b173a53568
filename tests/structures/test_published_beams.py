"""Beams that strike stops, against printed numbers of the validation manual of code_aster."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import nonsmooth as ns
from nonsmooth.structures import (
    Beam,
    Force,
    GapSpring,
    RectangularBeam,
    machine,
    plane_beam,
    reduce,
)

INSTANTS = (0.1315, 0.1566)
PRINTED = "-1.85334E-06", "-4.63284E-03"  # displacement and velocity of the end, V5.02.104
GAP, STOP, FORCE, END = 1e-4, 1e8, -1000.0, 0.16


def cantilever():
    """SDNL104: ten elements of Euler and Bernoulli, of 1 m length and 0.1 m radius."""
    element = Beam(0.1, 0.2, youngs_modulus=1e10, density=1e6, shear=False, rotary_inertia=False)
    return plane_beam([element] * 10).fixed(["0x", "0ry"])


def newmark(beam, steps):
    """Displacements and velocities of the end by the trapezoidal rule, as in the manual."""
    M, K, end, h = beam.mass, beam.stiffness, beam.index("10x"), END / steps
    force = np.zeros(beam.size)
    force[end] = FORCE
    closed = K.copy()
    closed[end, end] += STOP
    matrices = {False: K, True: closed}
    loads = {False: force, True: force + STOP * -GAP * np.eye(beam.size)[end]}
    q, v, a, touch, kept = (
        np.zeros(beam.size),
        np.zeros(beam.size),
        np.linalg.solve(M, force),
        0,
        [],
    )
    for _ in range(steps):
        ahead, before = q + h * v + h**2 / 4 * a, v + h / 2 * a
        for _ in range(3):
            matrix, load = matrices[bool(touch)], loads[bool(touch)]
            a = np.linalg.solve(M + h**2 / 4 * matrix, load - matrix @ ahead)
            q = ahead + h**2 / 4 * a
            touch = q[end] < -GAP
        v = before + h / 2 * a
        kept.append((q[end], v[end]))
    return h * np.arange(1, steps + 1), np.transpose(kept)


def test_the_steps_of_the_manual_give_its_digits():
    """So the model is that of the manual, and what is left to ours is the error of these steps."""
    times, (places, speeds) = newmark(cantilever(), 1600)
    found = np.interp(INSTANTS[0], times, places), np.interp(INSTANTS[1], times, speeds)
    assert tuple(f"{each:.5E}" for each in found) == PRINTED


@pytest.mark.slow  # DOP853 takes 5000 steps of the fastest mode
def test_a_cantilever_with_a_stop():
    """Against DOP853, and within the 0.7 % by which the steps of the manual are off."""
    beam = cantilever()
    end, inverse = beam.index("10x"), np.linalg.inv(beam.mass)
    force = FORCE * np.eye(beam.size)[end]

    def rates(t, state):
        q, v = np.split(state, 2)
        load = force - beam.stiffness @ q
        load[end] += STOP * max(-GAP - q[end], 0.0)
        return np.concatenate([v, inverse @ load])

    solved = solve_ivp(
        rates, (0, INSTANTS[-1]), np.zeros(2 * beam.size), method="DOP853", t_eval=INSTANTS,
        rtol=1e-11, atol=1e-16, max_step=2e-4,
    )  # fmt: skip
    struck = machine(
        reduce(beam, "10x", modes=beam.size),
        [GapSpring("10x", GAP, STOP, side="below")],
        [Force("10x", FORCE)],
    )
    run = ns.simulate(struck, times=[0.0, *INSTANTS])
    place, speed = float(run["x10"][1]), float(run["vx10"][2])
    # 1e-11 of a state in each of some thousand steps
    assert abs(place - solved.y[end, 0]) < 1e-8 * GAP
    assert abs(speed - solved.y[beam.size + end, 1]) < 1e-8 * np.abs(solved.y[beam.size :]).max()
    assert abs(place / float(PRINTED[0]) - 1) < 0.01
    assert abs(speed / float(PRINTED[1]) - 1) < 0.01


# SDNL32, V5.02.032: place of the end in mm after 1, 2, ... 12 ms, by the stiffness of the spring.
# The third number of the first row is off: code_aster itself has -4.953 there.
PLACES = {
    18000.0: [-2.66, -4.33, np.nan, -4.78, -3.82, -2.87, -2.71, -3.09, -3.41, -3.36, -2.64, -0.742],
    45000.0: [-2.25, -2.66, -1.96, -1.15, -0.124, -0.364, -2.01, -2.74, -1.89, -0.352, 1.70, 4.99],
}


def test_a_beam_that_swings_onto_a_spring():
    """Ten elements and ten modes with one per cent of damping, as the input of the test has.

    Half a unit of the third digit is 5e-6 m. The steps of the input, central differences of
    h = 1e-5 s, turn a motion of 1e4 rad/s, as the fifth mode is, by (omega h)^2/24 of its phase,
    that is 0.05 rad in 12 ms: 5e-6 m for each 0.1 mm of it.
    """
    n, length, count = 10, 0.783, 10
    square = RectangularBeam(
        length / n, 0.014, 0.014, youngs_modulus=6.7e10, density=2400.0, poissons_ratio=0.0
    )
    beam = plane_beam([square] * n).fixed("0x")
    squares, shapes = eigh(beam.stiffness, beam.mass)
    squares, shapes = np.maximum(squares[:count], 0.0), shapes[:, :count]
    names = [f"mode{i}" for i in range(count)]
    modal = ns.Structure(
        np.eye(count), np.diag(squares), damping=np.diag(0.02 * np.sqrt(squares)), coordinates=names
    )
    end = shapes[beam.index(f"{n}x")]
    turning = [
        -3.8 * (length * int(name[:-1]) / n if name.endswith("x") else 1.0)
        for name in beam.coordinates
    ]
    start = {f"v{name}": v for name, v in zip(names, shapes.T @ beam.mass @ turning, strict=True)}
    for stiffness, places in PLACES.items():
        stop = GapSpring(dict(zip(names, end, strict=True)), 0.0, stiffness, side="below")
        run = ns.simulate(machine(modal, [stop]), start, times=np.arange(13) * 1e-3)
        place = end @ [run[name].values[1:] for name in names]
        assert np.nanmax(np.abs(place - 1e-3 * np.array(places))) < 1e-5
