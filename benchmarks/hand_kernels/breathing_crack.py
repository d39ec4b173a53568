"""The beam with a breathing, growing crack as one would write it by hand for this one problem.

Closed form in each cell, a fixed number of looks per period at the sign of the deflection,
bisection and some Newton steps where it has changed. A crack that opens and closes between two
looks is missed.
"""

import math

from numba import njit


@njit(nogil=True)
def cell(kappa, xi, eta):
    """Damping, frequency, and amplitudes of cos and sin of the steady motion."""
    stiffness = 1.0 + kappa
    damped = math.sqrt(stiffness - xi * xi)
    away, lag = stiffness - eta * eta, 2.0 * xi * eta
    size = away * away + lag * lag
    return damped, -(eta**2) * lag / size, eta**2 * away / size


@njit(nogil=True)
def state(s, xi, eta, phase, damped, pc, ps, a, b):
    """Deflection and velocity at s after the start of a piece."""
    angle = phase + eta * s
    c, sn = math.cos(angle), math.sin(angle)
    decay = math.exp(-xi * s)
    dc, ds = math.cos(damped * s), math.sin(damped * s)
    u = decay * (a * dc + b * ds) + pc * c + ps * sn
    v = decay * ((b * damped - xi * a) * dc - (a * damped + xi * b) * ds)
    return u, v + eta * (ps * c - pc * sn)


@njit(nogil=True)
def strobes(xi, eta, periods, looks, found):
    """Strobes of the growing crack of Fig. 30, frozen for each period; returns the events."""
    period = 2.0 * math.pi / eta
    u, v, time, events, opened = 0.0, 0.0, 0.0, 0, True
    for k in range(periods):
        crack = 5.0 + 1e-3 * math.exp(time / 54734 - 7.8)
        left = 20.0 - crack
        kappa_open, kappa_closed = 4.245e-3 * left * left * left, 14.327
        phase_time = 0.0
        while True:
            kappa = kappa_open if opened else kappa_closed
            damped, pc, ps = cell(kappa, xi, eta)
            phase = eta * phase_time
            c, sn = math.cos(phase), math.sin(phase)
            a = u - pc * c - ps * sn
            b = (v - eta * (ps * c - pc * sn) + xi * a) / damped
            sign = 1.0 if opened else -1.0
            rest = period - phase_time
            low, crossed = 0.0, False
            step = period / looks
            while low < rest:
                high = min(low + step, rest)
                u, v = state(high, xi, eta, phase, damped, pc, ps, a, b)
                if sign * u < 0.0:
                    crossed = True
                    break
                low = high
            if not crossed:
                break
            for _ in range(20):
                middle = 0.5 * (low + high)
                u, v = state(middle, xi, eta, phase, damped, pc, ps, a, b)
                if sign * u < 0.0:
                    high = middle
                else:
                    low = middle
            s = 0.5 * (low + high)
            for _ in range(3):
                u, v = state(s, xi, eta, phase, damped, pc, ps, a, b)
                s -= u / v
            u, v = state(s, xi, eta, phase, damped, pc, ps, a, b)
            u = 0.0
            phase_time += s
            opened = not opened
            events += 1
        time += period
        found[k, 0], found[k, 1] = u, v
    return events
