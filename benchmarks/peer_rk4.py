"""The soft impact oscillator as it is often swept today: numba, Runge-Kutta with a fixed step.

Whether the mass touches the stop is asked once per step, after it; columns run side by side.
"""

from math import pi, sin

import numpy as np
from numba import njit, prange


@njit
def rates(x, v, t, stiffness, zeta, e, a, omega):
    return v, a * omega * omega * sin(omega * t) - 2.0 * zeta * v - x - stiffness * (x - e)


@njit
def column(strobes, steps, zeta, e, beta, a, omega, x, v):
    h = 2.0 * pi / omega / steps
    stiffness = 0.0
    for done in range(strobes.shape[0]):
        for i in range(steps):
            t = i * h
            x1, v1 = rates(x, v, t, stiffness, zeta, e, a, omega)
            x2, v2 = rates(
                x + 0.5 * h * x1, v + 0.5 * h * v1, t + 0.5 * h, stiffness, zeta, e, a, omega
            )
            x3, v3 = rates(
                x + 0.5 * h * x2, v + 0.5 * h * v2, t + 0.5 * h, stiffness, zeta, e, a, omega
            )
            x4, v4 = rates(x + h * x3, v + h * v3, t + h, stiffness, zeta, e, a, omega)
            x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
            v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
            stiffness = beta if x > e else 0.0
        strobes[done, 0] = x
        strobes[done, 1] = v


@njit(parallel=True)
def sweep(periods, steps, zeta, e, beta, a, omegas):
    """Strobes of every column from the start on, (columns, periods + 1, 2)."""
    found = np.zeros((omegas.size, periods + 1, 2))
    for i in prange(omegas.size):
        column(found[i, 1:], steps, zeta, e, beta, a, omegas[i], 0.0, 0.0)
    return found
