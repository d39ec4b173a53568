"""Stick and slip of a string in torsion, as a mass on a belt: its cycle is known in closed form."""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth.structures import DryFriction, GapSpring, Stop, machine, reduce
from structures.contact_truth import chain

KINETIC, STATIC, NODES = 2.0, 3.0, 12


def string():
    """A rod in torsion, held at its top by what turns it, with a heavy bit at its end."""
    mass, stiffness = chain(NODES)
    mass[-1, -1] += 3.0
    names = [f"{node}rz" for node in range(1, NODES + 1)]
    return ns.Structure(mass, stiffness, damping=0.05 * stiffness, coordinates=names)


def drilling(speed):
    """The string in its static shape alone, in the frame of what turns it."""
    rock = DryFriction(
        f"{NODES}rz", force=KINETIC, static=STATIC / KINETIC, speed=-speed, name="rock"
    )
    return machine(reduce(string(), f"{NODES}rz", modes=0), [rock])


def slip(speed):
    """Angle and its rates from steady sliding, and when the rate is highest and lowest.

    Slip begins at rest on the rock, where the string pulls with the static torque.
    """
    structure = string()
    shape = np.linalg.solve(structure.stiffness, np.eye(NODES)[-1])
    shape /= shape[-1]
    J, c, k = (
        shape @ matrix @ shape
        for matrix in (structure.mass, structure.damping, structure.stiffness)
    )
    decay = complex(-0.5 * c / J, np.sqrt(k / J - (0.5 * c / J) ** 2))
    x = (c * speed - (STATIC - KINETIC)) / k
    factor = x + 1j * (decay.real * x + speed) / decay.imag
    turn = 2 * np.pi / decay.imag
    lowest = (1.5 * np.pi - np.angle(factor * decay**2)) / decay.imag % turn

    def angle(t, order=0):
        return (factor * decay**order * np.exp(decay * t)).real

    return angle, lowest - 0.5 * turn, lowest


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.6, 0.8])
def test_the_period_of_stick_and_slip(speed):
    angle, peak, lowest = slip(speed)
    end = brentq(lambda t: angle(t, 1) + speed, peak, lowest, xtol=1e-15)
    period = end + (angle(end) - angle(0.0)) / speed
    orbit = ns.find_orbit(drilling(speed))
    # the root of a rate with a slope of order one, to rounding
    assert abs(float(orbit["length"]) / period - 1.0) < 1e-12
    assert orbit["word"].item().split()[:2] in (["stick", "forth"], ["forth", "stick"])
    assert (orbit["multipliers"].values == 0.0).all()  # each stick phase forgets the past


def test_the_speed_at_which_stick_and_slip_ends():
    critical = brentq(lambda speed: speed + slip(speed)[0](slip(speed)[2], 1), 0.5, 3.0, xtol=1e-14)
    branch = ns.continue_orbit(drilling(0.6), "rock_speed", (-3.0, -0.5))
    kinds = branch["special_kind"].values.tolist()
    assert kinds[0] == "grazing"
    assert abs(float(branch["special_value"][0]) + critical) < 1e-9
    steady = drilling(1.01 * critical)
    late = ns.simulate(steady, t_end=400.0)["event_kind"].values
    assert "slide_entry" not in late[1:]


def test_a_contact_along_an_angle_has_a_moment():
    turning = ns.Structure(np.eye(2), np.eye(2), coordinates=["1rz", "1z"])
    parts = {"spring": GapSpring, "friction": DryFriction, "stop": Stop}
    given = {"spring": (0.1, 5.0), "friction": (1.0,), "stop": (0.1, 0.5)}
    for name, units in (("1rz", ("N m", "rad")), ("1z", ("N", "m"))):
        for kind, make in parts.items():
            system = machine(turning, [make(name, *given[kind])])
            output = "stop1_distance" if kind == "stop" else f"{kind}1_force"
            assert system.describe[output].endswith(f"[{units[kind == 'stop']}]")
