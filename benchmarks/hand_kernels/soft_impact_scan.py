"""Soft impact oscillator by looking often: a second exact solution, to judge the first by.

Shares no step with `soft_impact`: the closed form of each mode is written from the start of the
mode, guards are looked at a fixed number of times per period, a minimum between two looks is sought
where the rate changes its sign, and zeros are found by bisection. Slow, and plain.
"""

from math import cos, exp, pi, sin, sqrt

from numba import njit

LOOKS = 200  # per period: thirty in a period of the stiffer spring
HALVINGS = 60


@njit(nogil=True)
def mode_start(x, v, t0, k, offset, zeta, a, omega):
    """Constants of the solution with the given state at time t0."""
    drive = a * omega * omega
    detuning = k - omega * omega
    damping = 2.0 * zeta * omega
    scale = drive / (detuning * detuning + damping * damping)
    S, C = detuning * scale, -damping * scale
    W = sqrt(k - zeta * zeta)
    rest = offset / k
    p = x - S * sin(omega * t0) - C * cos(omega * t0) - rest
    q = (v - omega * (S * cos(omega * t0) - C * sin(omega * t0)) + zeta * p) / W
    return p, q, S, C, W, rest, t0


@njit(nogil=True)
def state_at(mode, t, zeta, omega):
    p, q, S, C, W, rest, t0 = mode
    h = t - t0
    decay, c, s = exp(-zeta * h), cos(W * h), sin(W * h)
    cf, sf = cos(omega * t), sin(omega * t)
    x = decay * (p * c + q * s) + S * sf + C * cf + rest
    v = decay * ((q * W - zeta * p) * c - (p * W + zeta * q) * s) + omega * (S * cf - C * sf)
    return x, v


@njit(nogil=True)
def first_zero(mode, side, e, left, right, zeta, omega):
    """First time in a look at which side*(e - x) is negative; beyond ``right`` where there is none.

    side*(e - x) is positive, or rises from zero, at ``left``.
    """
    x, v = state_at(mode, right, zeta, omega)
    if side * (e - x) >= 0.0:
        _, before = state_at(mode, left, zeta, omega)
        if not (side * before > 0.0 and side * v < 0.0):
            return right + 1.0
        low, high = left, right  # the rate changes its sign: look at the minimum
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            _, rate = state_at(mode, middle, zeta, omega)
            if side * rate > 0.0:
                low = middle
            else:
                high = middle
        x, _ = state_at(mode, high, zeta, omega)
        if side * (e - x) >= 0.0:
            return right + 1.0
        right = high
    low, high = left, right
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        x, _ = state_at(mode, middle, zeta, omega)
        if side * (e - x) < 0.0:
            high = middle
        else:
            low = middle
    return high


@njit(nogil=True)
def simulate(strobes, zeta, e, beta, a, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i."""
    period = 2.0 * pi / omega
    side = -1.0 if x > e else 1.0
    for done in range(strobes.shape[0]):
        t, i = 0.0, 0
        k, offset = (1.0, 0.0) if side > 0.0 else (1.0 + beta, beta * e)
        mode = mode_start(x, v, 0.0, k, offset, zeta, a, omega)
        while i < LOOKS:
            right = period * (i + 1) / LOOKS
            zero = first_zero(mode, side, e, t, right, zeta, omega)
            if zero > right:
                t = right
                i += 1
                continue
            _, v = state_at(mode, zero, zeta, omega)
            side, t = -side, zero
            k, offset = (1.0, 0.0) if side > 0.0 else (1.0 + beta, beta * e)
            mode = mode_start(e, v, zero, k, offset, zeta, a, omega)
        x, v = state_at(mode, period, zeta, omega)
        strobes[done, 0] = x
        strobes[done, 1] = v
