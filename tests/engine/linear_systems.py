"""Linear systems for tests: as texts for the package, as matrices for the truth."""

import mpmath
import numpy as np

import nonsmooth as ns

DIGITS = 50


def linear_system(matrix, forcing=None, frequency=None):
    """x' = A x + forcing cos(frequency t) as a system of one mode without exits."""
    n = len(matrix)
    states = [f"x{i}" for i in range(n)]
    flow = {}
    for i in range(n):
        terms = [f"({float(matrix[i][j])!r})*x{j}" for j in range(n) if matrix[i][j] != 0]
        if forcing is not None and forcing[i] != 0:
            terms.append(f"({float(forcing[i])!r})*cos({float(frequency)!r}*t)")
        flow[f"x{i}"] = " + ".join(terms) or "0"
    return ns.System(states=states, modes={"m": ns.Mode(flow)})


def computed(system, start, time):
    """States at a time, by the package."""
    initial = {f"x{i}": float(value) for i, value in enumerate(start)}
    run = ns.simulate(system, initial, times=[0.0, time])
    return np.array([float(run[name][-1]) for name in system.states])


def truth(matrix, start, time, forcing=None, frequency=None):
    """States at a time and the norm of the exponential, by mpmath at 50 digits."""
    n = len(matrix)
    size = n if forcing is None else n + 2
    with mpmath.workdps(DIGITS):
        full = mpmath.zeros(size)
        for i in range(n):
            for j in range(n):
                full[i, j] = mpmath.mpf(float(matrix[i][j]))
        state = [mpmath.mpf(float(value)) for value in start]
        if forcing is not None:
            for i in range(n):
                full[i, n] = mpmath.mpf(float(forcing[i]))
            full[n, n + 1] = -mpmath.mpf(float(frequency))
            full[n + 1, n] = mpmath.mpf(float(frequency))
            state += [mpmath.mpf(1), mpmath.mpf(0)]
        flow = mpmath.expm(full * mpmath.mpf(float(time)), method="taylor")
        end = flow * mpmath.matrix(state)
        sizes = [mpmath.fsum(abs(flow[i, j] * state[j]) for j in range(size)) for i in range(n)]
        return np.array([float(end[i]) for i in range(n)]), np.array([float(s) for s in sizes])
