"""Steps of the rotor by the method of Dormand and Prince of order 8(5, 3), with dense output.

The coefficients are those that scipy tabulates. Rows of K are the derivatives (vx, vy, ax, ay) of
the stages; row 12 is that at the end of the step, the first one of the next.
"""

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as tableau

from .rotor_ring import FAST, acceleration

A, B, C, D = tableau.A, tableau.B, tableau.C, tableau.D
E3, E5 = tableau.E3, tableau.E5
STAGES, EXTRA = 12, 16


@njit(**FAST)
def stage(K, i, y, h, out):
    """out = y + h sum A[i, j] K[j]"""
    k0 = k1 = k2 = k3 = 0.0
    for j in range(i):
        w = A[i, j]
        if w != 0.0:
            k0 += w * K[j, 0]
            k1 += w * K[j, 1]
            k2 += w * K[j, 2]
            k3 += w * K[j, 3]
    out[0], out[1], out[2], out[3] = y[0] + h * k0, y[1] + h * k1, y[2] + h * k2, y[3] + h * k3


@njit(**FAST)
def derivative(t, z, c, p, row):
    row[0], row[1] = z[2], z[3]
    row[2], row[3] = acceleration(t, z[0], z[1], z[2], z[3], c, p)


@njit(**FAST)
def step(t, y, h, c, p, K, z):
    """One step from y (K[0] is known) to z, with K[12] there."""
    for i in range(1, STAGES):
        stage(K, i, y, h, z)
        derivative(t + C[i] * h, z, c, p, K[i])
    for m in range(4):
        total = 0.0
        for j in range(STAGES):
            total += B[j] * K[j, m]
        z[m] = y[m] + h * total
    derivative(t + h, z, c, p, K[STAGES])


@njit(**FAST)
def error(y, z, h, K, tolerance):
    """The estimate of the step's error over the tolerance, as in scipy."""
    fifth = third = 0.0
    for m in range(4):
        e5 = e3 = 0.0
        for j in range(STAGES):
            e5 += E5[j] * K[j, m]
            e3 += E3[j] * K[j, m]
        scale = tolerance * (1.0 + max(abs(y[m]), abs(z[m])))
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    if fifth == 0.0:
        return 0.0
    return h * fifth / np.sqrt(4.0 * (fifth + 0.01 * third))


@njit(**FAST)
def prepare_dense(t, y, h, c, p, K, z, work, F):
    """Three more stages and the polynomial of order 7."""
    for i in range(STAGES + 1, EXTRA):
        stage(K, i, y, h, work)
        derivative(t + C[i] * h, work, c, p, K[i])
    for m in range(4):
        change = z[m] - y[m]
        F[0, m] = change
        F[1, m] = h * K[0, m] - change
        F[2, m] = 2.0 * change - h * (K[STAGES, m] + K[0, m])
        for i in range(4):
            total = 0.0
            for j in range(EXTRA):
                total += D[i, j] * K[j, m]
            F[3 + i, m] = h * total


@njit(**FAST)
def dense(theta, y, F, m):
    """Component m at the fraction theta of the step."""
    value = 0.0
    for i in range(7):
        value += F[6 - i, m]
        value *= theta if i % 2 == 0 else 1.0 - theta
    return y[m] + value
