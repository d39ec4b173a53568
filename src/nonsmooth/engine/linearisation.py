"""A Taylor mode at one instant as if it were linear: rows of values with their gradients.

Exits are passed, zeros are counted and tangents are carried across events by rows over
augmented coordinates. A row of a Taylor mode holds the gradient of its function at a point,
and in the column of the coordinate 1 whatever makes its product with the point the value of
the function. So all of that is written once.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.dual_series import fill_duals
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["linearise"]


@kernel
def linearise(tables, slot_rates, harmonic_rates, affine_rates, series, dual, m, z, orders):
    """Rows of rates, relations, guards with their derivatives and resets of a mode at z.

    shapes: z (N,), series and dual as in Segment, the next three as in Rates; the rows of the
    mode in tables.generator and tables.affine are the output, and in affine_rates the rates of
    their values by parameters, in the column of 1. orders = 1 leaves the derivatives of guards
    out, at.DERIVATIVES is all
    """
    n, big_n = tables.sizes[0], z.size
    first, middle, end = tables.code_rows[m]
    outlets, slaved = tables.outlets[m], tables.wiring[m, 0, at.SLAVED]
    for i in range(big_n):
        series[i, 0] = z[i]
        for block in range(dual.shape[1]):
            for lane in range(at.LANES):
                dual[i, block, 0, lane] = 1.0 if block * at.LANES + lane == i else 0.0
    for part in range(min(orders, 2)):  # resets are values at the instant, the others derivatives
        last, high = (end, 0) if part == 0 else (middle, at.TERMS - 1)
        fill_series(
            tables.code, tables.terms, tables.weights, first, last, tables.values, outlets,
            slaved, tables.sizes, tables.harmonics, series, part, high,
        )  # fmt: skip
        fill_duals(
            tables.code, tables.terms, tables.weights, first, last, tables.values, slot_rates,
            big_n, outlets, slaved, tables.sizes, tables.harmonics, harmonic_rates, series, dual,
            part, high,
        )  # fmt: skip
    n_exits = tables.wiring.shape[1] - 1
    affine, generator = tables.affine, tables.generator
    for i in range(n):
        row = generator[m, i]
        if (slaved >> i) & 1:
            row = affine[m, at.relation_row(n_exits, i)]
            _write_rates(affine_rates, m, at.relation_row(n_exits, i), dual[outlets[i]], n, z)
        _write_row(row, series[outlets[i], 0], dual[outlets[i]], 0, 1.0, n, z)
    for e in range(tables.wiring[m, 0, at.N_EXITS]):
        guard = outlets[n + e]
        factor = 1.0
        for r in range(orders):
            row = affine[m, at.guard_row(e, r)]
            _write_row(row, series[guard, r], dual[guard], r, factor, n, z)
            factor *= r + 1.0
        _write_rates(affine_rates, m, at.guard_row(e, 0), dual[guard], n, z)
        for i in range(n):
            if (tables.wiring[m, 1 + e, at.RESETTING] >> i) & 1:
                new = outlets[n + n_exits + e * n + i]
                place = at.reset_row(n_exits, n, e, i)
                _write_row(affine[m, place], series[new, 0], dual[new], 0, 1.0, n, z)
                _write_rates(affine_rates, m, place, dual[new], n, z)


@kernel
def _write_row(row, value, gradient, r, factor, n, z):
    """Gradient of coefficient r times a factor; what is missing to the value goes with the 1.

    shapes: gradient (B, orders, LANES)
    """
    rest = value
    for j in range(z.size):
        if j != n:
            rate = gradient[j // at.LANES, r, j % at.LANES]
            row[j] = factor * rate
            rest -= rate * z[j]
    row[n] = factor * rest


@kernel
def _write_rates(affine_rates, m, place, gradient, n, z):
    """Derivatives by parameters, which the gradient has after those by coordinates."""
    for p in range(affine_rates.shape[0]):
        d = z.size + p
        affine_rates[p, m, place, n] = gradient[d // at.LANES, 0, d % at.LANES]
