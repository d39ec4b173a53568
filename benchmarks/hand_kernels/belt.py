"""Block on a belt with dry friction and a harmonic force, written out by hand.

    x'' + x = F cos(omega tau) - F_c sign(x' - v_b)

While the block slips x = Re w + A cos(omega tau) - side F_c with w' = i w. It sticks where the
force that friction would have to bear, F cos(omega tau) - x, is within F_c, and goes with the belt
until it is not.
"""

from math import cos, pi, sin, sqrt

from numba import njit

from .first_crossing import FAST, polished_zero, safe_step, safe_step_from_zero, zero_is_near

REACH = 1.25  # longest step tried at once; tuned, any value is correct


@njit(**FAST)
def simulate(strobes, F_c, v_b, F, omega, x, v):
    """Fill strobes[i] = (x, x') at the end of period i; count events and evaluations."""
    period = 2.0 * pi / omega
    omega2 = omega * omega
    A = F / (1.0 - omega2)
    slip3 = omega2 * omega2 * abs(A)  # of the belt's guard, whose own part is one power lower
    stick3 = omega2 * omega * F
    tau, c, s = 0.0, 1.0, 0.0
    events = evaluations = done = 0
    side = 1.0 if v > v_b else -1.0
    sticking, on_the_guard, double_zero = False, False, False
    wr, wi = x - A + side * F_c, -v
    M = sqrt(wr * wr + wi * wi)
    while done < strobes.shape[0]:
        room = period - tau
        reach = min(room, REACH)
        evaluations += 1
        if sticking:
            # the two limits of friction are looked at together: pull is F cos - x
            pull = F * c - x
            rate, second = -F * omega * s - v_b, -F * omega2 * c
            third = F * omega2 * omega * s
            up = safe_step(F_c - pull, -rate, -second, stick3, reach)
            down = safe_step(F_c + pull, rate, second, stick3, reach)
            way = 1.0 if up <= down else -1.0
            h = min(up, down)
            g0, g1, g2, g3 = F_c - way * pull, -way * rate, -way * second, -way * third
            if h < room and zero_is_near(g0, g1, g2, h):
                h = polished_zero(g0, g1, g2, g3, h)
                tau += h
                x += v_b * h
                c, s = cos(omega * tau), sin(omega * tau)
                side, sticking = way, False
                wr, wi = x - A * c + side * F_c, -omega * A * s - v_b
                M = sqrt(wr * wr + wi * wi)
                double_zero = True
                events += 1
                continue
            x += v_b * h
            if h < room:
                tau += h
                c, s = cos(omega * tau), sin(omega * tau)
            else:
                tau, c, s = 0.0, 1.0, 0.0
                strobes[done, 0], strobes[done, 1] = x, v_b
                done += 1
            continue
        steady, slope = A * c, -omega * A * s
        g0 = side * (-wi + slope - v_b)
        g1 = side * (-wr - omega2 * steady)
        g2 = side * (wi - omega2 * slope)
        if double_zero:  # left at the limit of friction: the guard rises with its second derivative
            h = min(reach, 3.0 * g2 / (M + slip3))
            double_zero = False
        elif on_the_guard:
            h = safe_step_from_zero(g1, g2, M + slip3, reach)
            on_the_guard = False
        else:
            h = safe_step(g0, g1, g2, M + slip3, reach)
            if h < room and zero_is_near(g0, g1, g2, h):
                g3 = side * (wr + omega2 * omega2 * steady)
                h = polished_zero(g0, g1, g2, g3, h)
                rc, rs = cos(h), sin(h)
                wr = wr * rc - wi * rs
                tau += h
                c, s = cos(omega * tau), sin(omega * tau)
                x = wr + A * c - side * F_c
                pull = F * c - x
                events += 1
                if abs(pull) < F_c:
                    sticking = True
                    continue
                side = -side
                wr, wi = x - A * c + side * F_c, -omega * A * s - v_b
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
            strobes[done, 0] = wr + A - side * F_c
            strobes[done, 1] = -wi
            done += 1
    return events, evaluations
