"""Ground mole, a drifting oscillator against a visco-elastic slider with friction, by hand.

    f = b + a cos(omega tau + pi/2),  F = 2 xi y + q,  contact where p = q + g
    no contact:   p' = y   y' = f      q' = -q/(2 xi)       v' = 0               until p - q = g
    contact:      p' = q'  y' = f - F  q' = y               v' = 0               until F = 0 or 1
    progression:  p' = q'  y' = f - 1  q' = (1 - q)/(2 xi)  v' = (F - 1)/(2 xi)  until F = 1

With c = cos(omega tau + pi/2), s = sin(omega tau + pi/2) the forced motion is taken off: in flight
and progression U = y - (a/omega) s and P = p + (a/omega^2) c are polynomials in time, in contact
q = Re w + A c + B s + b with w' = (-xi + i W) w.  The phase restarts every period.
Underdamped slider (xi < 1) only.
"""

from math import cos, exp, pi, sin, sqrt

from numba import njit

from .first_crossing import (
    FAST,
    polished_zero,
    safe_step,
    safe_step_from_double_zero,
    safe_step_from_zero,
    zero_is_near,
)

NO_CONTACT, CONTACT, PROGRESSION = 0, 1, 2
NOTHING, UPPER, LOWER, OPENING = 0, 1, 2, 3  # which guard is zero at the start of a segment
TOUCHING = 1e-12  # a gap as small as this is none
REACH = 1.25  # longest step tried at once; tuned, any value is correct


@njit(**FAST)
def simulate(strobes, a, b, xi, omega, g, p, y, q, v):
    """Fill strobes[i] = (p, y, q, v) at the end of period i; count events and evaluations.

    Starts inside the gap (p < q + g), or where it is closed (p = q + g).
    """
    period = 2.0 * pi / omega
    rate = 1.0 / (2.0 * xi)
    rate2 = rate * rate
    rate3 = rate2 * rate
    a1 = a / omega
    a2 = a1 / omega
    W = sqrt(1.0 - xi * xi)
    detuning = 1.0 - omega * omega
    damping = 2.0 * xi * omega
    scale = a / (detuning * detuning + damping * damping)
    A = scale * detuning
    B = scale * damping
    # The force of the slider: F = Re((1 + 2 xi lambda) w) + FA c + FB s + b.
    FA = A + damping * B
    FB = B - damping * A
    turn_r = 1.0 - 2.0 * xi * xi
    turn_i = 2.0 * xi * W  # |turn| = 1: undamped part of 1 + 2 xi lambda
    steady3 = omega * omega * omega * sqrt(FA * FA + FB * FB)
    wr = wi = M = 0.0

    mode = NO_CONTACT
    at_zero = NOTHING
    tau, c, s = 0.0, 0.0, 1.0
    U = y - a1 * s
    P = p + a2 * c
    pushed = 0.0  # q at the start of the progression, or at the last strobe in it
    if p - q - g > -TOUCHING:
        F = 2.0 * xi * y + q
        if F < 0.0:
            at_zero = OPENING
        elif F > 1.0:
            mode = PROGRESSION
            P = 0.0
            pushed = q
            q -= 1.0
        else:
            mode = CONTACT
            wr = q - B - b
            wi = -(y + omega * A + xi * wr) / W
            wr, wi = turn_r * wr - turn_i * wi, turn_r * wi + turn_i * wr
            M = sqrt(wr * wr + wi * wi)
    events = evaluations = 0
    done = 0
    while done < strobes.shape[0]:
        room = period - tau
        reach = min(room, REACH)
        evaluations += 1
        if mode == NO_CONTACT:
            fading = rate * q
            g0 = q + g - P + a2 * c
            g1 = -fading - U - a1 * s
            g2 = fading * rate - b - a * c
            bound = a * omega + max(0.0, rate3 * q)
            if at_zero == NOTHING:
                h = safe_step(g0, g1, g2, bound, reach)
            elif at_zero == OPENING:
                h = safe_step_from_zero(g1, g2, bound, reach)
            else:
                h = safe_step_from_double_zero(g2, bound, reach)
            if at_zero == NOTHING and h < room and zero_is_near(g0, g1, g2, h):
                h = polished_zero(g0, g1, g2, a * omega * s - rate3 * q, h)
                tau += h
                y = U + b * h
                c, s = -sin(omega * tau), cos(omega * tau)
                y += a1 * s
                q *= exp(-rate * h)
                p = q + g
                events += 1
                if 2.0 * xi * y + q > 1.0:
                    mode = PROGRESSION
                    U = y - a1 * s
                    P = a2 * c
                    pushed = q
                    q -= 1.0
                else:
                    mode = CONTACT
                    wr = q - A * c - B * s - b
                    wi = -(y - omega * (B * c - A * s) + xi * wr) / W
                    wr, wi = turn_r * wr - turn_i * wi, turn_r * wi + turn_i * wr
                    M = sqrt(wr * wr + wi * wi)
                continue
            at_zero = NOTHING
            q *= exp(-rate * h)
            P += h * (U + 0.5 * b * h)
            U += b * h
        elif mode == CONTACT:
            steady = FA * c + FB * s
            slope = omega * (FB * c - FA * s)
            F0 = wr + steady + b
            F1 = slope - xi * wr - W * wi
            F2 = (xi * xi - W * W) * wr + 2.0 * xi * W * wi - omega * omega * steady
            bound = M + steady3
            h = safe_step(F0, F1, F2, bound, reach)
            if at_zero == UPPER:
                up = safe_step_from_zero(-F1, -F2, bound, reach)
            else:
                up = safe_step(1.0 - F0, -F1, -F2, bound, reach)
            side = 1.0
            if up < h:
                h = up
                side = -1.0
                F0, F1, F2 = 1.0 - F0, -F1, -F2
            if at_zero == NOTHING and h < room and zero_is_near(F0, F1, F2, h):
                # Higher rates: the free part by its equation, the steady part by its phase.
                rate_2 = F2 + side * omega * omega * steady
                rate_3 = -2.0 * xi * rate_2 - (F1 - side * slope)
                F3 = rate_3 - side * omega * omega * slope
                F4 = -2.0 * xi * rate_3 - rate_2 + side * omega * omega * omega * omega * steady
                h = polished_zero(F0, F1, F2, F3, h)
                tau += h
                F1 = side * (F1 + h * (F2 + h * (0.5 * F3 + h * (F4 / 6.0))))
                c, s = -sin(omega * tau), cos(omega * tau)
                # F and F' are known at the crossing: they give q and y. F' = 2 xi (f - F) + y.
                F0 = 0.0 if side > 0.0 else 1.0
                y = F1 - 2.0 * xi * (b + a * c - F0)
                q = F0 - 2.0 * xi * y
                U = y - a1 * s
                events += 1
                if side > 0.0:
                    mode = NO_CONTACT
                    at_zero = LOWER
                    P = q + g + a2 * c
                else:
                    mode = PROGRESSION
                    at_zero = UPPER
                    P = a2 * c
                    pushed = q
                    q -= 1.0
                continue
            at_zero = NOTHING
            decay = exp(-xi * h)
            rc, rs = decay * cos(W * h), decay * sin(W * h)
            wr, wi = wr * rc - wi * rs, wr * rs + wi * rc
            M *= decay
        else:  # progression; q holds q - 1, P the travelled way x
            y0 = U + a1 * s
            g0 = 2.0 * xi * y0 + q
            g1 = 2.0 * xi * (b - 1.0 + a * c) - rate * q
            g2 = rate2 * q - 2.0 * xi * a * omega * s
            bound = 2.0 * xi * a * omega * omega + max(0.0, rate3 * q)
            if at_zero == NOTHING:
                h = safe_step(g0, g1, g2, bound, reach)
            else:
                h = safe_step_from_zero(g1, g2, bound, reach)
            if at_zero == NOTHING and h < room and zero_is_near(g0, g1, g2, h):
                h = polished_zero(g0, g1, g2, -2.0 * xi * a * omega * omega * c - rate3 * q, h)
                tau += h
                c, s = -sin(omega * tau), cos(omega * tau)
                P += h * (U + 0.5 * (b - 1.0) * h)
                q = 1.0 + q * exp(-rate * h)
                y = rate * (1.0 - q)
                v += P - a2 * c - (q - pushed)
                mode = CONTACT
                at_zero = UPPER
                events += 1
                wr = q - A * c - B * s - b
                wi = -(y - omega * (B * c - A * s) + xi * wr) / W
                wr, wi = turn_r * wr - turn_i * wi, turn_r * wi + turn_i * wr
                M = sqrt(wr * wr + wi * wi)
                continue
            at_zero = NOTHING
            q *= exp(-rate * h)
            P += h * (U + 0.5 * (b - 1.0) * h)
            U += (b - 1.0) * h
        if h < room:
            tau += h
            c, s = -sin(omega * tau), cos(omega * tau)
            continue
        tau, c, s = 0.0, 0.0, 1.0
        if mode == NO_CONTACT:
            p, y = P, U + a1
            strobes[done, 2] = q
        elif mode == CONTACT:
            # undo the turn; |turn| = 1
            hr, hi = turn_r * wr + turn_i * wi, turn_r * wi - turn_i * wr
            strobes[done, 2] = hr + B + b
            p = strobes[done, 2] + g
            y = -xi * hr - W * hi - omega * A
        else:
            v += P - (q + 1.0 - pushed)
            P, pushed = 0.0, q + 1.0
            strobes[done, 2] = pushed
            p, y = pushed + g, U + a1
        strobes[done, 0] = p
        strobes[done, 1] = y
        strobes[done, 3] = v
        done += 1
    return events, evaluations
