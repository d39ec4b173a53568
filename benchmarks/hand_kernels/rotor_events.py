"""Which guard of the rotor is first to turn negative on a step, and what follows from it."""

from math import copysign

from numba import njit

from .dormand_prince import dense, prepare_dense
from .rotor_ring import (
    FAST,
    GAP,
    RELEASE,
    SWITCH_X,
    SWITCH_Y,
    acceleration,
    gap,
    guard,
    relaxed,
    ring,
    settle,
)

NONE, NOWHERE = -1, 2.0
GOES_ON, UNDECIDED = 0, 1
ROUNDING = 1e-9  # a closing speed as small as this is none


@njit(**FAST)
def at(which, theta, t, h, y, F, c, free, p):
    """A guard and its rate at a fraction of the step."""
    x, z, u, v = (
        dense(theta, y, F, 0),
        dense(theta, y, F, 1),
        dense(theta, y, F, 2),
        dense(theta, y, F, 3),
    )
    return guard(which, t + theta * h, x, z, u, v, c, free, p)


@njit(**FAST)
def root(which, low, high, t, h, y, F, c, free, p):
    """The zero between low, where the guard is positive, and high: Newton, kept inside."""
    theta = 0.5 * (low + high)
    for _ in range(80):
        g, rate = at(which, theta, t, h, y, F, c, free, p)
        if g > 0.0:
            low = theta
        else:
            high = theta
        new = theta - g / (rate * h) if rate != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - theta) < 1e-14:
            return new
        theta = new
    return theta


@njit(**FAST)
def positive_after(which, low, high, t, h, y, F, c, free, p):
    """Where a guard that leaves zero at low has become positive; low if it never does."""
    for _ in range(50):
        high = 0.5 * (low + high)
        if at(which, high, t, h, y, F, c, free, p)[0] > 0.0:
            return high
    return low


@njit(**FAST)
def above_tangents(low, g0, r0, high, g1, r1):
    """Whether the tangents at the ends, falling and rising, meet above zero."""
    return g0 * r1 - g1 * r0 + r0 * r1 * (high - low) > 0.0


@njit(**FAST)
def dip(which, low, g0, r0, high, g1, r1, t, h, y, F, c, free, p):
    """Where a guard that falls and rises is negative, NOWHERE if it stays positive."""
    for _ in range(50):
        if above_tangents(low, g0, r0 * h, high, g1, r1 * h):
            break
        theta = 0.5 * (low + high)
        g, rate = at(which, theta, t, h, y, F, c, free, p)
        if g < 0.0:
            return theta
        if rate < 0.0:
            low, g0, r0 = theta, g, rate
        else:
            high, g1, r1 = theta, g, rate
    return NOWHERE


@njit(**FAST)
def piece(which, known, low, g0, r0, high, g1, r1, t, h, y, F, c, free, p):
    """The first zero on a part of the step; `known`: the guard is zero at low by construction."""
    if g1 < 0.0:
        start = positive_after(which, low, high, t, h, y, F, c, free, p) if known else low
        return root(which, start, high, t, h, y, F, c, free, p)
    if not known and r0 < 0.0 < r1:
        bottom = dip(which, low, g0, r0, high, g1, r1, t, h, y, F, c, free, p)
        if bottom != NOWHERE:
            return root(which, low, bottom, t, h, y, F, c, free, p)
    return NOWHERE


@njit(**FAST)
def suspect(known, g0, r0, g1, r1, h):
    return g1 < 0.0 or (not known and r0 < 0.0 < r1 and not above_tangents(0.0, g0, r0, h, g1, r1))


@njit(**FAST)
def in_contact(known, g, g_new, t, h, y, z, c, free, p, K, F, work):
    """(guard, fraction of the step) of the first event of a step in contact."""
    first, found, prepared = NOWHERE, NONE, False
    for which in range(3):
        g0, r0, g1, r1 = g[2 * which], g[2 * which + 1], g_new[2 * which], g_new[2 * which + 1]
        if not suspect(which == known, g0, r0, g1, r1, h):
            continue
        if not prepared:
            prepare_dense(t, y, h, c, p, K, z, work, F)
            prepared = True
        theta = piece(which, which == known, 0.0, g0, r0, 1.0, g1, r1, t, h, y, F, c, free, p)
        if theta < first:
            first, found = theta, which
    return found, first


@njit(**FAST)
def in_flight(known, g, g_new, t, h, y, z, c, free, p, K, F, work):
    """The same for a free rotor; while the ring still moves, in pieces of its own time scale."""
    g0, r0, low, known_gap = g[0], g[1], 0.0, known == GAP
    if free[0] == 0.0 and free[1] == 0.0:
        if not suspect(known_gap, g0, r0, g_new[0], g_new[1], h):
            return NONE, NOWHERE
        prepare_dense(t, y, h, c, p, K, z, work, F)
        theta = piece(GAP, known_gap, low, g0, r0, 1.0, g_new[0], g_new[1], t, h, y, F, c, free, p)
        return (GAP, theta) if theta != NOWHERE else (NONE, theta)
    prepare_dense(t, y, h, c, p, K, z, work, F)
    span, end = 0.5 * p[2] / p[3], free[2]
    while low < 1.0:
        end += span
        span *= 1.5
        high = min(1.0, (end - t) / h)
        if high <= low:
            continue
        g1, r1 = at(GAP, high, t, h, y, F, c, free, p)
        theta = piece(GAP, known_gap, low, g0, r0, high, g1, r1, t, h, y, F, c, free, p)
        if theta != NOWHERE:
            return GAP, theta
        low, g0, r0, known_gap = high, g1, r1, False
    return NONE, NOWHERE


@njit(**FAST)
def on_side(s, count, delta):
    """A ring that stands at its preload to rounding is on the side that its springs say."""
    if delta == 0.0:
        return s
    return copysign(min(abs(s), delta) if count == 2.0 else max(abs(s), delta), s)


@njit(**FAST)
def leave(t, z, c, free, p):
    """The ring is let go where it stands. Undecided where rotor and ring would still approach."""
    _, d, e, _, _, _ = ring(z[0], z[1], z[2], z[3], c)
    free[0], free[1] = on_side(z[0] - d, c[0], p[7]), on_side(z[1] - e, c[1], p[8])
    free[2] = t
    c[0] = c[1] = c[2] = c[3] = 0.0
    opening = gap(t, z[0], z[1], z[2], z[3], free, p)[1]
    if opening > ROUNDING:
        return GAP, GOES_ON
    if opening < -ROUNDING:
        return GAP, UNDECIDED
    # the rates agree: the rate of opening's own rate decides
    rate = 0.5 * p[3] / p[2]
    ux = relaxed(free[0], p[7], rate, 0.0)[1]
    uy = relaxed(free[1], p[8], rate, 0.0)[1]
    fx, fy = acceleration(t, z[0], z[1], z[2], z[3], c, p)
    closing = (z[2] - ux) ** 2 + (z[3] - uy) ** 2 + d * (fx + rate * ux) + e * (fy + rate * uy)
    return GAP, UNDECIDED if closing > 0.0 else GOES_ON


@njit(**FAST)
def transit(which, t, z, c, free, p):
    """Change c (and free) at an event; the guard that is zero from then on, and a status."""
    if which == RELEASE:
        return leave(t, z, c, free, p)
    if which == GAP:
        free[0] = free[1] = 0.0
        settle(z[0], z[1], c, p)
        which = NONE
    else:
        i = which - SWITCH_X
        _, d, e, _, _, _ = ring(z[0], z[1], z[2], z[3], c)
        if c[i] == 2.0:
            s = z[1] - e if which == SWITCH_Y else z[0] - d
            c[i], c[2 + i] = 1.0, copysign(p[7 + i], s)
        else:
            c[i], c[2 + i] = 2.0, 0.0
    if guard(RELEASE, t, z[0], z[1], z[2], z[3], c, free, p)[0] < 0.0:
        return leave(t, z, c, free, p)
    return which, GOES_ON


@njit(**FAST)
def calm(t, free, p):
    """Let the ring stand at its centre once it is as good as there."""
    if free[0] == 0.0 and free[1] == 0.0:
        return
    rate = 0.5 * p[3] / p[2]
    sx = relaxed(free[0], p[7], rate, t - free[2])[0]
    sy = relaxed(free[1], p[8], rate, t - free[2])[0]
    if abs(sx) + abs(sy) < 1e-18:
        free[0] = free[1] = 0.0
