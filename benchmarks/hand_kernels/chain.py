"""Chain of three masses against a one-sided elastic stop, written out by hand in chain.c."""

import numpy as np

from .compiled import INTEGER, REAL, REALS, Counts, function, library

X3 = 2  # z = (x1, x2, x3, x1', x2', x3')
_simulate = function(library("chain"), "simulate", Counts, REALS, INTEGER, *[REALS] * 7, REAL, REAL)


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


def simulate(strobes, rates, bases, steadies, jumps, forced, start, e, omega, z0):
    """Fill strobes[i] = z at the end of period i; numbers of events and evaluations.

    Starts free, at z0.
    """
    arrays = rates, bases, steadies, jumps, forced, start, z0
    counts = _simulate(strobes, len(strobes), *arrays, e, omega)
    return counts.events, counts.evaluations
