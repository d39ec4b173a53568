"""Soft impact oscillator, written out by hand.

    x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(omega tau)

In each mode x = Re w + A cos + B sin + C with w' = (-zeta + i W) w, W^2 = k - zeta^2 and
k = 1 or 1 + beta.  The phase restarts every period, so no digit is lost to a growing tau.
"""

from math import cos, exp, pi, sin, sqrt

from numba import njit

from .first_crossing import FAST, polished_zero, safe_step, safe_step_from_zero, zero_is_near

REACH = 1.25  # longest step tried at once; tuned, any value is correct


@njit(**FAST)
def mode_constants(k, offset, zeta, a, omega):
    """k, |lambda|^3, W, steady response A cos + B sin + C and the bound on its third derivative."""
    drive = a * omega * omega
    detuning = k - omega * omega
    damping = 2.0 * zeta * omega
    scale = drive / (detuning * detuning + damping * damping)
    A = -damping * scale
    B = detuning * scale
    return (
        k,
        k * sqrt(k),
        sqrt(k - zeta * zeta),
        A,
        B,
        offset / k,
        omega * omega * omega * sqrt(A * A + B * B),
    )


@njit(**FAST)
def simulate(strobes, zeta, e, beta, a, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; count events and evaluations."""
    period = 2.0 * pi / omega
    omega2 = omega * omega
    free = mode_constants(1.0, 0.0, zeta, a, omega)
    touching = mode_constants(1.0 + beta, beta * e, zeta, a, omega)
    in_contact = x > e
    k, lambda3, W, A, B, C, steady3 = touching if in_contact else free
    side = -1.0 if in_contact else 1.0
    tau, c, s = 0.0, 1.0, 0.0
    events = evaluations = 0
    on_the_guard = False
    wr = x - A - C
    wi = -(v - omega * B + zeta * wr) / W
    M = lambda3 * sqrt(wr * wr + wi * wi)  # free part of the bound: it only decays
    done = 0
    while done < strobes.shape[0]:
        steady = A * c + B * s
        slope = omega * (B * c - A * s)
        evaluations += 1
        g0 = side * (e - wr - steady - C)
        g1 = side * (zeta * wr + W * wi - slope)
        g2 = side * ((W * W - zeta * zeta) * wr - 2.0 * zeta * W * wi + omega2 * steady)
        room = period - tau
        reach = min(room, REACH)
        if on_the_guard:
            h = safe_step_from_zero(g1, g2, M + steady3, reach)
            on_the_guard = False
        else:
            h = safe_step(g0, g1, g2, M + steady3, reach)
            if h < room and zero_is_near(g0, g1, g2, h):
                # Higher rates: the free part by its equation, the steady part by its phase.
                rate2 = g2 - side * omega2 * steady
                rate3 = -2.0 * zeta * rate2 - k * (g1 + side * slope)
                g3 = rate3 + side * omega2 * slope
                g4 = -2.0 * zeta * rate3 - k * rate2 - side * omega2 * omega2 * steady
                h = polished_zero(g0, g1, g2, g3, h)
                v = -side * (g1 + h * (g2 + h * (0.5 * g3 + h * (g4 / 6.0))))
                tau += h
                c, s = cos(omega * tau), sin(omega * tau)
                in_contact = not in_contact
                k, lambda3, W, A, B, C, steady3 = touching if in_contact else free
                side = -side
                wr = e - A * c - B * s - C
                wi = -(v - omega * (B * c - A * s) + zeta * wr) / W
                M = lambda3 * sqrt(wr * wr + wi * wi)
                on_the_guard = True
                events += 1
                continue
        decay = exp(-zeta * h)
        rc, rs = decay * cos(W * h), decay * sin(W * h)
        wr, wi = wr * rc - wi * rs, wr * rs + wi * rc
        M *= decay
        if h < room:
            tau += h
            c, s = cos(omega * tau), sin(omega * tau)
        else:
            tau, c, s = 0.0, 1.0, 0.0
            strobes[done, 0] = wr + A + C
            strobes[done, 1] = -zeta * wr - W * wi + omega * B
            done += 1
    return events, evaluations
