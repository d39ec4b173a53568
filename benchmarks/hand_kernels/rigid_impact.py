"""Rigid impact oscillator with rest at the wall, written out by hand.

    x'' + x = F cos(omega tau),  x <= sigma,  v+ = -r v-

Between impacts x = Re w + A cos(omega tau) with w' = i w. Rebounds that follow one another under
the push P = F cos(omega tau) - sigma at the wall are over after 2 u/(P (1 - r)); once that is
short, the mass rests until P changes its sign, which is an arc cosine.
"""

from math import acos, cos, pi, sin, sqrt

from numba import njit

from .first_crossing import FAST, polished_zero, safe_step, safe_step_from_zero, zero_is_near

REACH = 1.25  # longest step tried at once; tuned, any value is correct
SHORT = 1e-6  # part of a period that is left to the sum of all rebounds


@njit(**FAST)
def simulate(strobes, F, omega, sigma, r, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; count events and evaluations."""
    period = 2.0 * pi / omega
    omega2 = omega * omega
    A = F / (1.0 - omega2)
    steady3 = omega2 * omega * abs(A)
    tau, c, s = 0.0, 1.0, 0.0
    events = evaluations = 0
    on_the_guard = resting = False
    release = acos(sigma / F) / omega if sigma < F else 0.0
    wr, wi = x - A, -v
    M = sqrt(wr * wr + wi * wi)
    done = 0
    while done < strobes.shape[0]:
        if resting:
            if tau < release:
                tau = release
                c, s = cos(omega * tau), sin(omega * tau)
                wr, wi = sigma - A * c, -omega * A * s
                M = sqrt(wr * wr + wi * wi)
                resting, on_the_guard = False, True
                events += 1
                continue
            strobes[done, 0], strobes[done, 1] = sigma, 0.0
            done += 1
            tau, c, s = 0.0, 1.0, 0.0
            continue
        room = period - tau
        steady, slope = A * c, -omega * A * s
        evaluations += 1
        g0 = sigma - wr - steady
        g1 = wi - slope
        g2 = wr + omega2 * steady
        reach = min(room, REACH)
        if on_the_guard:
            if g1 <= 1e-14 * M:  # left at rest: the guard rises with its third derivative
                h = min(reach, 1e-3)
            else:
                h = safe_step_from_zero(g1, g2, M + steady3, reach)
            on_the_guard = False
        else:
            h = safe_step(g0, g1, g2, M + steady3, reach)
            if h < room and zero_is_near(g0, g1, g2, h):
                g3 = -wi + omega2 * slope
                g4 = -wr - omega2 * omega2 * steady
                h = polished_zero(g0, g1, g2, g3, h)
                u = r * -(g1 + h * (g2 + h * (0.5 * g3 + h * (g4 / 6.0))))
                tau += h
                c, s = cos(omega * tau), sin(omega * tau)
                events += 1
                push = F * c - sigma
                left = 2.0 * u / (push * (1.0 - r)) if push > 0.0 else period
                if left < SHORT * period:
                    resting = True
                    continue
                wr = sigma - A * c
                wi = u - omega * A * s
                M = sqrt(wr * wr + wi * wi)
                on_the_guard = True
                continue
        rc, rs = cos(h), sin(h)
        wr, wi = wr * rc - wi * rs, wr * rs + wi * rc
        if h < room:
            tau += h
            c, s = cos(omega * tau), sin(omega * tau)
        else:
            tau, c, s = 0.0, 1.0, 0.0
            strobes[done, 0] = wr + A
            strobes[done, 1] = -wi
            done += 1
    return events, evaluations
