"""Certified steps towards the first zero of a guard, shared by the hand kernels.

With g0, g1, g2 the guard and its first two derivatives now, and M >= max(0, -g''') from now on,

    g(h) >= g0 + g1 h + g2 h^2/2 - M h^3/6,

so no zero is passed while the right-hand side is positive.  On 0 <= h <= H the cubic lies above the
parabola with curvature g2 - M H/3, whose first zero is a square root away; a second, smaller H
tightens it.  A caller that limits its step to about a radian of the motion gets a tight first H.
"""

from math import sqrt

from numba import njit

# contract, nsz and arcp keep every comparison meaningful; reassociation and no-NaN would not.
FAST = {"fastmath": {"contract", "nsz", "arcp"}, "error_model": "numpy"}


@njit(**FAST)
def parabola_zero(g0, g1, curvature, limit):
    """First positive zero of g0 + g1 h + curvature h^2/2 for g0 > 0; `limit` if later or never."""
    discriminant = g1 * g1 - 2.0 * curvature * g0
    if discriminant < 0.0:
        return limit
    denominator = sqrt(discriminant) - g1
    if 2.0 * g0 >= limit * denominator:
        return limit
    return 2.0 * g0 / denominator


@njit(**FAST)
def safe_step(g0, g1, g2, M, limit):
    """A step h <= limit before which a guard with g0 > 0 has no zero."""
    third = M * (1.0 / 3.0)
    h = parabola_zero(g0, g1, g2 - third * limit, limit)
    if h >= limit:
        return limit
    H = min(limit, 1.5 * h)
    return parabola_zero(g0, g1, g2 - third * H, H)


@njit(**FAST)
def sag(g3, M4, H):
    """Curvature lost: g3 h^3/6 - M4 h^4/24 >= -sag h^2/2 on [0, H] (concave over h^2)."""
    return max(0.0, H * (M4 * H * (1.0 / 12.0) - g3 * (1.0 / 3.0)))


@njit(**FAST)
def safe_step_fourth(g0, g1, g2, g3, M4, limit):
    """The same with a bound M4 on the fourth derivative; it pays where several frequencies mix."""
    h = parabola_zero(g0, g1, g2 - sag(g3, M4, limit), limit)
    if h >= limit:
        return limit
    H = min(limit, 1.5 * h)
    return parabola_zero(g0, g1, g2 - sag(g3, M4, H), H)


@njit(**FAST)
def safe_step_from_zero(g1, g2, M, limit):
    """The same for a guard that rises from zero, divided by h: g/h >= g1 + g2 h/2 - M h^2/6."""
    return min(limit, 2.0 * g1 / (sqrt(0.25 * g2 * g2 + (2.0 / 3.0) * M * g1) - 0.5 * g2))


@njit(**FAST)
def safe_step_from_double_zero(g2, M, limit):
    """The same for a guard that leaves zero tangentially: g/h^2 >= g2/2 - M h/6."""
    return min(limit, 3.0 * g2 / M)


@njit(**FAST)
def zero_is_near(g0, g1, g2, h):
    """Whether a safe step, short enough for a Taylor finish, ends at a zero and not a near miss."""
    return h < CLOSE and g1 * g1 > 2.0 * g0 * g2


@njit(**FAST)
def polished_zero(g0, g1, g2, g3, h):
    """Two Newton corrections of a nearby zero h on the cubic Taylor polynomial of the guard."""
    for _ in range(2):
        g = g0 + h * (g1 + h * (0.5 * g2 + h * (g3 / 6.0)))
        h -= g / (g1 + h * (g2 + 0.5 * h * g3))
    return h


CLOSE = 3e-5  # the neglected terms of order h^4 in a zero and h^4 in a rate are then below rounding
