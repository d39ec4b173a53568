"""Jeffcott rotor in a preloaded snubber ring by DOP853, written by hand for this one problem.

    r'' + 2 nu1 r' + (r - eps) + F = load (cos, sin)(phi0 + eta tau)

Steps end at contacts, at releases (n . F = 0) and where |sx| or |sy| passes the preload, for
there the number of dampers changes. Each event is found on the dense output, reached by a step of
its own and polished by the rate of its guard.
"""

from math import pi

import numpy as np
from numba import njit

from .dormand_prince import STAGES, derivative, error, step
from .rotor_events import GOES_ON, NONE, UNDECIDED, calm, in_contact, in_flight, leave, transit
from .rotor_ring import (
    FAST,
    GAP,
    RELEASE,
    contact_guards,
    gap,
    guard,
    relaxed,
    ring,
    settle,
)

STUCK = 2
SHORTEST = 1e-15
AT_ONCE = 1e-12  # a contact as soon as this after a release is none: no regime holds
LARGEST_FACTOR, LEAST_FACTOR, SAFETY = 4.0, 0.2, 0.9


@njit(**FAST)
def regime(c):
    """1 to 5 for the chapter's I to V."""
    if c[0] == 0.0:
        return 1
    return 2 + (1 if c[0] == 1.0 else 0) + (2 if c[1] == 1.0 else 0)


@njit(**FAST)
def all_guards(t, z, row, c, free, p, g):
    """Guards and rates at a point where the derivative is known."""
    if c[0] == 0.0:
        g[0], g[1] = gap(t, z[0], z[1], z[2], z[3], free, p)
    else:
        g[0], g[1], g[2], g[3], g[4], g[5] = contact_guards(
            z[0], z[1], z[2], z[3], row[2], row[3], c, p
        )


@njit(**FAST)
def record(out, t, y, c, free, p):
    """x, y, vx, vy, sx, sy, mu, regime."""
    out[:4] = y
    if c[0] == 0.0:
        rate = 0.5 * p[3] / p[2]
        out[4] = relaxed(free[0], p[7], rate, t - free[2])[0]
        out[5] = relaxed(free[1], p[8], rate, t - free[2])[0]
        out[6] = 0.0
    else:
        mu, d, e, _, _, _ = ring(y[0], y[1], y[2], y[3], c)
        out[4], out[5], out[6] = y[0] - d, y[1] - e, mu
    out[7] = regime(c)


@njit(**FAST)
def begin(y, c, free, p):
    """A ring at rest in its centre, or in equilibrium."""
    c[:] = 0.0
    if y[0] * y[0] + y[1] * y[1] < 1.0:
        return NONE
    settle(y[0], y[1], c, p)
    if guard(RELEASE, 0.0, y[0], y[1], y[2], y[3], c, free, p)[0] < 0.0:
        return leave(0.0, y, c, free, p)[0]
    return NONE


@njit(**FAST)
def reach(which, t, h, y, c, free, p, K, z):
    """The state at an event after a fraction of a step: z; returns its time."""
    step(t, y, h, c, p, K, z)
    t += h
    value, rate = guard(which, t, z[0], z[1], z[2], z[3], c, free, p)
    if abs(value) < 1e-8 * abs(rate):
        late = -value / rate
        for m in range(4):
            z[m] += late * K[STAGES, m]
        t += late
    return t


@njit(**FAST)
def simulate(strobes, log, start, p, tolerance):
    """Fill strobes[i] at the end of period i and log[k] = (period, time in it, from, to).

    Counts of events and steps, and a status: 0, UNDECIDED or STUCK.
    """
    K, F, c, free = np.zeros((16, 4)), np.zeros((7, 4)), np.zeros(4), np.zeros(3)
    y, z, work, g, g_new = start.copy(), np.zeros(4), np.zeros(4), np.zeros(6), np.zeros(6)
    longest = np.array([0.1, 0.02])  # the step that the method would take next: free, in contact
    period = 2.0 * pi / p[0]
    known, events, steps, t, fresh = begin(y, c, free, p), 0, 0, 0.0, True
    done = 0
    while done < strobes.shape[0]:
        touching = 1 if c[0] != 0.0 else 0
        if fresh:
            derivative(t, y, c, p, K[0])
            all_guards(t, y, K[0], c, free, p, g)
            fresh = False
        room = period - t
        last = longest[touching] >= room
        h = room if last else longest[touching]
        step(t, y, h, c, p, K, z)
        steps += 1
        wrong = error(y, z, h, K, tolerance)
        factor = min(LARGEST_FACTOR, max(LEAST_FACTOR, SAFETY * (wrong + 1e-12) ** -0.125))
        if wrong > 1.0:
            longest[touching] = h * min(1.0, factor)
            if h < SHORTEST:
                return events, steps, STUCK
            continue
        if not last or factor < 1.0:
            longest[touching] = h * factor
        all_guards(t + h, z, K[STAGES], c, free, p, g_new)
        if touching:
            which, theta = in_contact(known, g, g_new, t, h, y, z, c, free, p, K, F, work)
        else:
            which, theta = in_flight(known, g, g_new, t, h, y, z, c, free, p, K, F, work)
        if which == NONE:
            y, z, g, g_new = z, y, g_new, g
            K[0] = K[STAGES]
            t, known = t + h, NONE
            if touching == 0:
                calm(t, free, p)
        else:
            before = regime(c)
            t = reach(which, t, theta * h, y, c, free, p, K, z)
            y, z = z, y
            again = which == GAP and known == GAP and theta * h < AT_ONCE
            known, status = transit(which, t, y, c, free, p)
            if again:
                status = UNDECIDED
            if events < log.shape[0]:
                log[events, 0], log[events, 1] = done, t
                log[events, 2], log[events, 3] = before, regime(c)
            events += 1
            if status != GOES_ON:
                return events, steps, status
            fresh, last = True, False
        if last:
            record(strobes[done], t, y, c, free, p)
            done += 1
            t = 0.0
            free[2] -= period
            # a longer run starts from the same numbers as a run that starts here
            fresh = True
    return events, steps, GOES_ON
