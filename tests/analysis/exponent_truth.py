"""Exponents by another route: exact exponentials per piece, events by bisection, QR by numpy.

Nothing of the library is used. Both systems are continuous where they switch, so no saltation.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq


def averages(logarithms: np.ndarray, time_step: float, blocks: int = 20):
    """Mean rates and their standard errors from block averages."""
    count = len(logarithms) // blocks * blocks
    rates = logarithms[:count].reshape(blocks, -1, logarithms.shape[1]).sum(axis=1)
    rates /= count // blocks * time_step
    order = np.argsort(-rates.mean(axis=0))
    return rates.mean(axis=0)[order], rates.std(axis=0, ddof=1)[order] / np.sqrt(blocks)


def exponents(
    generators: dict[int, np.ndarray],
    region: Callable[[float], int],
    level: float,
    z: np.ndarray,
    n: int,
    time_step: float,
    steps: int,
    skipped: int,
):
    """Exponents of z' = generators[region(z[0])] z, of which the first n entries are states.

    Regions meet where z[0] is plus or minus ``level``."""
    whole = {k: expm(g * time_step) for k, g in generators.items()}

    def step(z, columns, h):
        here = region(z[0])
        moved = whole[here] if h == time_step else expm(generators[here] * h)
        if region((moved @ z)[0]) == here:
            return moved @ z, moved[:n, :n] @ columns
        border = level if here == 0 else abs(level) * here

        def beyond(part):
            return (expm(generators[here] * part) @ z)[0] - border

        if here == 0 and (moved @ z)[0] < 0.0:
            border = -level
        # a hair later, so that the region is the next one
        high = min(h, brentq(beyond, 0.0, h, xtol=1e-13) + 1e-11)
        moved = expm(generators[here] * high)
        z, columns = moved @ z, moved[:n, :n] @ columns
        return step(z, columns, h - high) if h - high > 1e-13 else (z, columns)

    columns, rows = np.linalg.qr(np.random.default_rng(1).standard_normal((n, n)))[0], []
    for k in range(steps):
        z, columns = step(z, columns, time_step)
        columns, triangle = np.linalg.qr(columns)
        if k >= skipped:
            rows.append(np.log(np.abs(np.diag(triangle))))
    return averages(np.array(rows), time_step)


def chua(steps: int, skipped: int):
    """Chua's circuit with the parameters of the double scroll."""
    alpha, beta, m0, m1 = 9.0, 100 / 7, -8 / 7, -5 / 7

    def generator(slope, offset):
        g = np.zeros((4, 4))
        g[:3, :3] = [[-alpha * (1 + slope), alpha, 0], [1, -1, 1], [0, -beta, 0]]
        g[0, 3] = -alpha * offset
        return g

    generators = {0: generator(m0, 0.0), 1: generator(m1, m0 - m1), -1: generator(m1, m1 - m0)}
    start = np.array([0.11, 0.02, -0.03, 1.0])

    def region(x):
        return 0 if abs(x) <= 1 else int(np.sign(x))

    return exponents(generators, region, 1.0, start, 3, 0.05, steps, skipped)


def soft_impact(omega, zeta, beta, e, a, periods: int, skipped: int, per_period: int = 64):
    """The soft impact oscillator; sine and cosine of the force are states of their own."""

    def generator(stiffness):
        g = np.zeros((5, 5))  # x, v, sin, cos, 1
        g[0, 1] = 1.0
        g[1] = [-1 - stiffness, -2 * zeta, a * omega**2, 0.0, stiffness * e]
        g[2, 3], g[3, 2] = omega, -omega
        return g

    generators = {0: generator(0.0), 1: generator(beta)}
    start = np.array([0.1, 0.0, 0.0, 1.0, 1.0])
    time_step = 2 * np.pi / omega / per_period
    total = periods + skipped
    return exponents(
        generators, lambda x: int(x > e), e, start, 2, time_step, total * per_period,
        skipped * per_period,
    )  # fmt: skip
