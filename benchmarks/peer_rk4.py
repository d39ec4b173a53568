"""The soft impact oscillator as it is often swept today: C, Runge-Kutta with a fixed step.

Whether the mass touches the stop is asked once per step, after it; columns run side by side.
"""

import numpy as np
from crowd import spread
from hand_kernels import soft_impact_rk4


def sweep(periods, steps, zeta, e, beta, a, omegas, threads):
    """Strobes of every column from the start on, (columns, periods + 1, 2)."""
    found = np.zeros((omegas.size, periods + 1, 2))

    def column(i):
        soft_impact_rk4.simulate(found[i, 1:], steps, zeta, e, beta, a, omegas[i], 0.0, 0.0)

    spread(column, omegas.size, threads)
    return found
