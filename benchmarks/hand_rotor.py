"""The rotor by hand: strobes of a long run, and the columns of a bifurcation diagram.

    python benchmarks/hand_rotor.py

checks the kernel on its own: convergence, the balance of energy, equal counts of events.
"""

from math import pi

import numpy as np
from hand_kernels import rotor

TOLERANCE = 1e-12
NAMES = ("eta", "nu1", "nu2", "K", "eta_m", "rho", "eps_x", "eps_y", "delta_x", "delta_y", "phi0")
SET_A = {
    "eta": 2.442, "nu1": 0.125, "nu2": 0.002, "K": 30.0, "eta_m": 0.0017, "rho": 70.0,
    "eps_x": 0.9, "eps_y": 0.0, "delta_x": 0.1, "delta_y": 0.1, "phi0": 0.0,
}  # fmt: skip
SET_B = SET_A | {
    "eta": 2.5, "nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5,
    "delta_x": 0.05, "delta_y": 0.05,
}  # fmt: skip
NO_LOG = np.empty((0, 4))


def constants(**changes):
    """The kernel's constants for set A with changes."""
    q = SET_A | changes
    load = q["eta_m"] * q["rho"] * q["eta"] ** 2
    head = (q["eta"], q["nu1"], q["nu2"], q["K"], load, q["eps_x"], q["eps_y"])
    return tuple(float(x) for x in (*head, q["delta_x"], q["delta_y"], q["phi0"]))


def strobes(p, periods, start=(0.0, 0.0, 0.0, 0.0), tolerance=TOLERANCE, events=0):
    """(strobes, log of events, count of events, count of steps, status)."""
    points, log = np.empty((periods, 8)), np.zeros((events, 4))
    found = rotor.simulate(points, log, np.array(start, dtype=float), p, tolerance)
    log = log[: found[0]]
    log[:, 1] += 2.0 * pi / p[0] * log[:, 0]
    return points, log[:, 1:], *found
