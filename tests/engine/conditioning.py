"""exp(M t) z, and how well double precision can know it, in ball arithmetic.

The condition of component i is the smallest honest one: relative changes of size u of the
single entries of M and z, each with the worst sign, change it by

    u kappa_i,  kappa_i = sum_jk |M_jk| |dy_i/dM_jk| + sum_j |exp(M t)_ij| |z_j| .

Zero entries stay zero, and units of the states do not matter. It is never above the usual
normwise condition (`expm_cond`), and below it by many orders for graded or badly scaled
matrices. All derivatives with respect to entries come from one block exponential: the upper
right block of exp([[M', h z'], [0, M']] t) is the integral of exp(M'(t-s)) h (exp(M s) z)',
whose entry (j, k) is the derivative of h . y with respect to M_jk.
"""

from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat, ctx

_TINY = 1e-290  # below this a decayed motion has fallen out of the range of doubles


class Answer(NamedTuple):
    """Values and their condition numbers in absolute terms, kappa."""

    value: np.ndarray
    kappa: np.ndarray


def exact(rows: np.ndarray) -> arb_mat:
    """Doubles as exact balls."""
    rows = np.asarray(rows, float)
    return arb_mat([[arb(float(x)) for x in row] for row in rows])


def flow(matrix: np.ndarray, start: np.ndarray, time: float, bits: int = 128) -> list[arb]:
    """exp(matrix time) start, each component right to 70 bits or below the range of doubles."""
    while True:
        with ctx.workprec(bits):
            end = (exact(matrix) * arb(time)).exp() * exact(start[:, None])
            values = [end[i, 0] for i in range(len(start))]
            if all(y.rad() <= abs(y.mid()) * arb(2) ** -70 or _tiny(y) for y in values):
                return values
        if bits > 20000:
            raise ArithmeticError("no digits at 20000 bits")
        bits *= 2


def _tiny(y: arb) -> bool:
    return bool(abs(y) < _TINY)


def answer(matrix: np.ndarray, start: np.ndarray, time: float, rows: np.ndarray) -> Answer:
    """The values rows . exp(matrix time) start and their kappas."""
    values, kappas = [], []
    end = flow(matrix, start, time)
    for row in np.asarray(rows, float):
        with ctx.workprec(256):
            total = sum((arb(float(h)) * y for h, y in zip(row, end, strict=True) if h), arb(0))
        values.append(float(total.mid()))
        kappas.append(kappa(matrix, start, time, row))
    return Answer(np.array(values), np.array(kappas))


def kappa(matrix: np.ndarray, start: np.ndarray, time: float, row: np.ndarray) -> float:
    """Absolute condition of row . exp(matrix time) start, right to a per cent."""
    n, bits = len(start), 128
    full = np.zeros((2 * n, 2 * n))
    full[:n, :n] = full[n:, n:] = np.asarray(matrix).T
    size = max(1e-300, np.abs(row).max() * np.abs(start).max())
    # the coupling is linear: scaled to the size of the rest, and back
    scale = max(np.abs(matrix).max(), 1.0 / time) / size
    full[:n, n:] = np.outer(row, start) * scale
    weights = np.abs(matrix)
    while True:
        with ctx.workprec(bits):
            flows = (exact(full) * arb(time)).exp()
            total, radius = 0.0, 0.0
            for j in range(n):
                term = sum((flows[j, i] * arb(float(row[i])) for i in range(n) if row[i]), arb(0))
                total += abs(float(term.mid())) * abs(start[j])
                radius += float(term.rad()) * abs(start[j])
                for k in range(n):
                    if weights[j, k] != 0.0:
                        rate = flows[j, n + k]
                        total += abs(float(rate.mid())) * weights[j, k] / scale
                        radius += float(rate.rad()) * weights[j, k] / scale
        if radius <= 0.01 * total or total < _TINY:
            return total
        bits *= 2


def normwise(matrix: np.ndarray, time: float) -> float:
    """The condition of scipy's expm_cond (Frobenius norms), for comparison only."""
    from scipy.linalg import expm_cond

    with np.errstate(all="ignore"):
        try:
            return float(expm_cond(np.asarray(matrix) * time))
        except ValueError:  # it squares what overflows
            return np.inf
