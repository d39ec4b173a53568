"""What parameters add over a short time: the Taylor series in the coordinates themselves.

The modal form is exact to rounding of what the slots are made of, which for a short time may
be far more than the little that a parameter has added. Here all digits stay.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel

__all__ = ["SHORT", "fill_growth", "force_shortly", "slave_shortly"]

SHORT = 1.0  # longest time in units of the bound of growth
_NEGLIGIBLE = 1e-18  # next term beside the first
_ROUNDS = 8  # of power iteration; more would spread the units of a chain ever wider


@kernel
def fill_growth(matrix, rate, x, y, growth):
    """A rate b such that terms (matrix s)^k / k! are at most (b s)^k / k!, in some units.

    shapes: matrix (N, N); x, y (N,) scratch; rate > 0 says which times matter; growth (2,)
    output: b, and how far the units are apart

    The largest ratio (|M| x)_i / x_i of any positive x bounds all powers of |M| in the norm
    that has x for its unit (Collatz and Wielandt).
    """
    n = matrix.shape[0]
    for i in range(n):
        x[i] = 1.0
    for k in range(_ROUNDS + 1):
        growth[0], largest, smallest = 0.0, 0.0, 1e300
        for i in range(n):
            y[i] = 0.0
            for j in range(n):
                y[i] += abs(matrix[i, j]) * x[j]
            growth[0] = max(growth[0], y[i] / x[i])
            largest, smallest = max(largest, x[i]), min(smallest, x[i])
        growth[1] = largest / smallest
        for i in range(n if k < _ROUNDS else 0):
            x[i] = x[i] / largest + y[i] / (rate * largest)


@kernel
def force_shortly(matrix, rates, m, growth, z, s, added, terms, spare):
    """Fill what all parameters add, from zero at the start, after a short time s.

    shapes: matrix (N, N) generator of the mode, rates (P, m, N, N) as Rates.generator,
    growth (2,) as from `fill_growth`, z (N,) augmented coordinates at the start; added
    (1 + P, N) output with the motion in its first row; terms (1 + P, N), spare (N,) scratch
    """
    big_n = z.size
    for i in range(big_n):
        for k in range(added.shape[0]):
            added[k, i] = terms[k, i] = 0.0
        added[0, i] = terms[0, i] = z[i]
    # both the motion and the coupling may be small in these units and large in others
    degree, bound = 0, growth[1] * growth[1]
    while degree < 2 * big_n or bound > _NEGLIGIBLE:
        degree += 1
        bound *= growth[0] * s / degree
        for k in range(added.shape[0] - 1, -1, -1):  # the motion last: all need its old term
            for i in range(big_n):
                total = 0.0
                for j in range(big_n):
                    total += matrix[i, j] * terms[k, j]
                    if k > 0:
                        total += rates[k - 1, m, i, j] * terms[0, j]
                spare[i] = total * (s / degree)
            for i in range(big_n):
                terms[k, i] = spare[i]
                added[k, i] += spare[i]


@kernel
def slave_shortly(n, n_exits, slaved, affine, rates, m, added):
    """Put the slaved states on the derivatives of their relations.

    shapes: affine (rows, N) of the mode, rates (P, m, rows, N) as Rates.affine, added as
    from `force_shortly`, changed in place
    """
    for i in range(n):
        if (slaved >> i) & 1:
            row = at.relation_row(n_exits, i)
            for k in range(1, added.shape[0]):
                total = 0.0
                for j in range(added.shape[1]):
                    total += affine[row, j] * added[k, j] + rates[k - 1, m, row, j] * added[0, j]
                added[k, i] = total
