"""Chain of three masses against a one-sided elastic stop, written out by hand.

    m x1'' = -k x1        - c x1'          + k (x2 - x1) + c (x2' - x1') + A cos(omega tau)
    m x2'' = -k (x2 - x1) - c (x2' - x1')  + k (x3 - x2) + c (x3' - x2')
    m x3'' = -k (x3 - x2) - c (x3' - x2')  - k_stop (x3 - e) H(x3 - e)

Each mode has three damped pairs, z = Re(V w) + steady response, w_j' = lambda_j w_j, scaled so
that x3 = Re(w_1 + w_2 + w_3) + steady.  A crossing maps w by one constant 6 x 6 matrix and a forced
term.  The phase restarts every period.
"""

from math import cos, exp, pi, sin, sqrt

import numpy as np
from numba import njit

from .first_crossing import FAST, polished_zero, safe_step, safe_step_fourth, zero_is_near

REACH = 1.6  # longest step tried at once; tuned, any value is correct
X3 = 2  # z = (x1, x2, x3, x1', x2', x3')


def mode_constants(k_stop, m, k, c, e, A, omega):
    """Eigenvalues, real basis (columns Re w, Im w), its inverse, steady response (cos, sin, 1)."""
    stiffness = np.array([[2 * k, -k, 0], [-k, 2 * k, -k], [0, -k, k + k_stop]]) / m
    damping = np.array([[2 * c, -c, 0], [-c, 2 * c, -c], [0, -c, c]]) / m
    flow = np.block([[np.zeros((3, 3)), np.eye(3)], [-stiffness, -damping]])
    values, vectors = np.linalg.eig(flow)
    upper = values.imag > 0.0
    assert upper.sum() == 3, "underdamped chains only"
    values = values[upper]
    vectors = vectors[:, upper] / vectors[X3, upper]
    basis = np.hstack([vectors.real, -vectors.imag])
    steady = np.linalg.solve(1j * omega * np.eye(6) - flow, np.array([0, 0, 0, A / m, 0, 0]))
    offset = np.linalg.solve(-flow, np.array([0, 0, 0, 0, 0, k_stop * e / m]))
    return values, basis, np.linalg.inv(basis), np.array([steady.real, -steady.imag, offset])


def constants(k_stop, m, k, c, e, A, omega):
    """Arrays for `simulate`, first index the mode (0 free, 1 in contact)."""
    modes = [mode_constants(stiffness, m, k, c, e, A, omega) for stiffness in (0.0, k_stop)]
    lambdas = np.array([values for values, *_ in modes])
    # Rows: lambda, lambda^2, lambda^3 (real, imaginary) and |lambda|^4.
    rates = np.array(
        [
            [v.real, v.imag, (v**2).real, (v**2).imag, (v**3).real, (v**3).imag, abs(v) ** 4]
            for v in lambdas
        ]
    )
    bases = np.array([basis for _, basis, _, _ in modes])
    steadies = np.array([steady for *_, steady in modes])
    # w of the other mode = jump w + forced (cos, sin, 1)
    jumps = np.array([modes[1 - i][2] @ modes[i][1] for i in (0, 1)])
    forced = np.array([modes[1 - i][2] @ (steadies[i] - steadies[1 - i]).T for i in (0, 1)])
    start = np.ascontiguousarray(modes[0][2])
    return rates, bases, steadies, jumps, forced, start


@njit(**FAST)
def simulate(strobes, rates, bases, steadies, jumps, forced, start, e, omega, z0):
    """Fill strobes[i] = z at the end of period i; return the numbers of events and evaluations.

    Starts free, at z0.
    """
    period = 2.0 * pi / omega
    omega2 = omega * omega
    w = np.empty(6)
    old = np.empty(6)
    for i in range(6):
        w[i] = 0.0
        for j in range(6):
            w[i] += start[i, j] * (z0[j] - steadies[0, 0, j] - steadies[0, 2, j])
    mode = 0
    side = 1.0
    rate = rates[0]
    A, B, C = steadies[0, 0, X3], steadies[0, 1, X3], steadies[0, 2, X3]
    steady4 = omega2 * omega2 * sqrt(A * A + B * B)
    M0 = rate[6, 0] * sqrt(w[0] * w[0] + w[3] * w[3])  # the free part of the bound only decays
    M1 = rate[6, 1] * sqrt(w[1] * w[1] + w[4] * w[4])
    M2 = rate[6, 2] * sqrt(w[2] * w[2] + w[5] * w[5])
    tau, c, s = 0.0, 1.0, 0.0
    on_the_guard = False
    events = evaluations = 0
    done = 0
    while done < strobes.shape[0]:
        evaluations += 1
        steady = A * c + B * s
        slope = omega * (B * c - A * s)
        g0 = e - C - steady - (w[0] + w[1] + w[2])
        g1 = -slope
        g2 = omega2 * steady
        g3 = omega2 * slope
        for j in range(3):
            g1 -= rate[0, j] * w[j] - rate[1, j] * w[3 + j]
            g2 -= rate[2, j] * w[j] - rate[3, j] * w[3 + j]
            g3 -= rate[4, j] * w[j] - rate[5, j] * w[3 + j]
        g0, g1, g2, g3 = side * g0, side * g1, side * g2, side * g3
        bound = M0 + M1 + M2 + steady4
        room = period - tau
        reach = min(room, REACH)
        if on_the_guard:
            h = safe_step(g1, g2 / 2.0, g3 / 3.0, bound / 4.0, reach)  # the zero divided out
            on_the_guard = False
        else:
            h = safe_step_fourth(g0, g1, g2, g3, bound, reach)
            if h < room and zero_is_near(g0, g1, g2, h):
                h = polished_zero(g0, g1, g2, g3, h)
                for j in range(3):  # exp(lambda h) to third order
                    dr, di = rate[0, j] * h, rate[1, j] * h
                    rr, ri = 0.5 + dr * (1.0 / 6.0), di * (1.0 / 6.0)
                    rr, ri = 1.0 + dr * rr - di * ri, dr * ri + di * rr
                    rr, ri = 1.0 + dr * rr - di * ri, dr * ri + di * rr
                    old[j] = w[j] * rr - w[3 + j] * ri
                    old[3 + j] = w[j] * ri + w[3 + j] * rr
                tau += h
                c, s = cos(omega * tau), sin(omega * tau)
                for i in range(6):
                    total = forced[mode, i, 0] * c + forced[mode, i, 1] * s + forced[mode, i, 2]
                    for j in range(6):
                        total += jumps[mode, i, j] * old[j]
                    w[i] = total
                mode = 1 - mode
                side = -side
                rate = rates[mode]
                A, B, C = steadies[mode, 0, X3], steadies[mode, 1, X3], steadies[mode, 2, X3]
                steady4 = omega2 * omega2 * sqrt(A * A + B * B)
                M0 = rate[6, 0] * sqrt(w[0] * w[0] + w[3] * w[3])
                M1 = rate[6, 1] * sqrt(w[1] * w[1] + w[4] * w[4])
                M2 = rate[6, 2] * sqrt(w[2] * w[2] + w[5] * w[5])
                on_the_guard = True
                events += 1
                continue
        d0, d1, d2 = exp(rate[0, 0] * h), exp(rate[0, 1] * h), exp(rate[0, 2] * h)
        M0, M1, M2 = M0 * d0, M1 * d1, M2 * d2
        rr, ri = d0 * cos(rate[1, 0] * h), d0 * sin(rate[1, 0] * h)
        w[0], w[3] = w[0] * rr - w[3] * ri, w[0] * ri + w[3] * rr
        rr, ri = d1 * cos(rate[1, 1] * h), d1 * sin(rate[1, 1] * h)
        w[1], w[4] = w[1] * rr - w[4] * ri, w[1] * ri + w[4] * rr
        rr, ri = d2 * cos(rate[1, 2] * h), d2 * sin(rate[1, 2] * h)
        w[2], w[5] = w[2] * rr - w[5] * ri, w[2] * ri + w[5] * rr
        if h < room:
            tau += h
            c, s = cos(omega * tau), sin(omega * tau)
            continue
        tau, c, s = 0.0, 1.0, 0.0
        for i in range(6):
            total = steadies[mode, 0, i] + steadies[mode, 2, i]
            for j in range(6):
                total += bases[mode, i, j] * w[j]
            strobes[done, i] = total
        done += 1
    return events, evaluations
