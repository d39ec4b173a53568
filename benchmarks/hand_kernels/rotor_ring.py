"""The snubber ring: where it stands, how it moves, and the guards of the rotor against it.

A contact regime is (a, b, ox, oy): a and b count the springs in touch in x and y, ox and oy are
the preload with the sign of the ring's displacement where one spring is in touch, 0 where two are.
a = 0 means no contact. With X = x + ox the ring stands where d = r - s = (a X/(a + mu),
b Y/(b + mu)) has length 1; the force is K mu d + 2 nu2 (a sx', b sy').

Constants of a run: (eta, nu1, nu2, K, load, eps_x, eps_y, delta_x, delta_y, phi0).
"""

from math import copysign, cos, exp, sin, sqrt

from numba import njit

FAST = {"fastmath": {"contract", "nsz", "arcp"}, "nogil": True}
SETTLED = 1e-18  # a ring as near to its centre as this stands there
RELEASE, SWITCH_X, SWITCH_Y, GAP = 0, 1, 2, 3  # what a guard is zero for


@njit(**FAST)
def multiplier(X, Y, a, b):
    """mu with |d| = 1: a (R - 1) where a = b, else Newton's method, monotone from R - 1."""
    R = sqrt(X * X + Y * Y)
    if a == b:
        return a * (R - 1.0)
    mu = R - 1.0
    for _ in range(50):
        u, v = a / (a + mu), b / (b + mu)
        p, q = u * u * X * X, v * v * Y * Y
        step = 0.5 * (p + q - 1.0) / (p / (a + mu) + q / (b + mu))
        mu += step
        if abs(step) < 1e-15:
            break
    return mu


@njit(**FAST)
def ring(x, y, vx, vy, c):
    """mu, d, mu', s' in a contact regime."""
    a, b = c[0], c[1]
    X, Y = x + c[2], y + c[3]
    mu = multiplier(X, Y, a, b)
    A, B = 1.0 / (a + mu), 1.0 / (b + mu)
    d, e = a * X * A, b * Y * B
    rate = (d * a * vx * A + e * b * vy * B) / (d * d * A + e * e * B)
    return mu, d, e, rate, vx - (a * vx - d * rate) * A, vy - (b * vy - e * rate) * B


@njit(**FAST)
def acceleration(t, x, y, vx, vy, c, p):
    """x'' and y'' in the regime c."""
    eta, nu1, nu2, K, load = p[0], p[1], p[2], p[3], p[4]
    phase = p[9] + eta * t
    fx = load * cos(phase) - 2.0 * nu1 * vx - (x - p[5])
    fy = load * sin(phase) - 2.0 * nu1 * vy - (y - p[6])
    if c[0] != 0.0:
        mu, d, e, _, sx, sy = ring(x, y, vx, vy, c)
        fx -= K * mu * d + 2.0 * nu2 * c[0] * sx
        fy -= K * mu * e + 2.0 * nu2 * c[1] * sy
    return fx, fy


@njit(**FAST)
def relaxed(s, delta, rate, t):
    """One coordinate of the free ring and its rate, a time t after it was at s."""
    decay = exp(-rate * t)
    size = abs(s)
    if delta == 0.0 or size <= delta:
        return s * decay, -rate * s * decay
    # one spring in touch, relaxing to -delta, until the other one is met at delta
    excess = (size + delta) * decay
    if excess >= 2.0 * delta:
        return copysign(excess - delta, s), -copysign(rate * excess, s)
    return copysign(0.5 * excess, s), -copysign(0.5 * rate * excess, s)


@njit(**FAST)
def gap(t, x, y, vx, vy, free, p):
    """1 - |r - s| for a ring that left the rotor at free = (sx, sy, time), and its rate."""
    sx = sy = ux = uy = 0.0
    if free[0] != 0.0 or free[1] != 0.0:
        rate = 0.5 * p[3] / p[2]
        sx, ux = relaxed(free[0], p[7], rate, t - free[2])
        sy, uy = relaxed(free[1], p[8], rate, t - free[2])
    d, e = x - sx, y - sy
    D = sqrt(d * d + e * e)
    if D == 0.0:
        return 1.0, 0.0
    return 1.0 - D, -(d * (vx - ux) + e * (vy - uy)) / D


@njit(**FAST)
def switch(count, offset, delta, s, u):
    """The guard of |s| against the preload, and its rate."""
    if delta == 0.0:
        return 1.0, 0.0
    if count == 1.0:
        sign = copysign(1.0, offset)
        return sign * s - delta, sign * u
    sign = copysign(1.0, s)
    return delta - sign * s, -sign * u


@njit(**FAST)
def contact_guards(x, y, vx, vy, fx, fy, c, p):
    """n . F and the two switches with their rates; fx, fy: the acceleration."""
    a, b, nu2 = c[0], c[1], p[2]
    mu, d, e, m1, sx, sy = ring(x, y, vx, vy, c)
    A, B = 1.0 / (a + mu), 1.0 / (b + mu)
    d1, e1 = vx - sx, vy - sy
    # |d| = 1 and d (a + mu) = a X, each differentiated twice
    top = d * (a * fx - 2.0 * d1 * m1) * A + e * (b * fy - 2.0 * e1 * m1) * B + d1 * d1 + e1 * e1
    m2 = top / (d * d * A + e * e * B)
    ux = fx - (a * fx - 2.0 * d1 * m1 - d * m2) * A
    uy = fy - (b * fy - 2.0 * e1 * m1 - e * m2) * B
    force = p[3] * mu + 2.0 * nu2 * (a * d * sx + b * e * sy)
    rate = p[3] * m1 + 2.0 * nu2 * (a * (d1 * sx + d * ux) + b * (e1 * sy + e * uy))
    gx, gx1 = switch(a, c[2], p[7], x - d, sx)
    gy, gy1 = switch(b, c[3], p[8], y - e, sy)
    return force, rate, gx, gx1, gy, gy1


@njit(**FAST)
def guard(which, t, x, y, vx, vy, c, free, p):
    """One guard and its rate, at a point inside a step."""
    if which == GAP:
        return gap(t, x, y, vx, vy, free, p)
    fx, fy = acceleration(t, x, y, vx, vy, c, p)
    f0, f1, x0, x1, y0, y1 = contact_guards(x, y, vx, vy, fx, fy, c, p)
    if which == RELEASE:
        return f0, f1
    if which == SWITCH_X:
        return x0, x1
    return y0, y1


@njit(**FAST)
def settle(x, y, c, p):
    """Write into c the contact regime in which the ring is in equilibrium, the rotor at (x, y)."""
    for trial in range(4):
        a, b = 2.0 - (trial & 1), 2.0 - (trial >> 1)
        if (a == 2.0 and p[7] == 0.0) or (b == 2.0 and p[8] == 0.0):
            continue
        c[0], c[1] = a, b
        c[2] = copysign(p[7], x) if a == 1.0 else 0.0
        c[3] = copysign(p[8], y) if b == 1.0 else 0.0
        _, d, e, _, _, _ = ring(x, y, 0.0, 0.0, c)
        sx, sy = x - d, y - e
        held_x = p[7] == 0.0 or (abs(sx) <= p[7]) == (a == 2.0)
        held_y = p[8] == 0.0 or (abs(sy) <= p[8]) == (b == 2.0)
        if held_x and held_y:
            return
