"""A curved mode at one instant as if it were linear: rows of values with their gradients.

Curved is a Taylor mode, or a mode in closed form whose guards or resets are not linear. Exits
are passed, zeros are counted and tangents are carried across events by rows over augmented
coordinates. A row of a curved mode holds the gradient of its function at a point, and in the
column of the coordinate 1 whatever makes its product with the point the value of the function.
So all of that is written once.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.dual_series import fill_duals
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.solved_relations import place_point, solve_together
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["differentiate_mode", "linearise", "linearise_derivatives", "linearise_mode"]


@kernel
def linearise_mode(tables, rates, segment, m):
    """Bring the rows of a curved mode up to date at segment.z; linear ones always are.

    The rows of the derivatives of guards stay behind.
    """
    if at.has_code(tables.code_rows, m):
        linearise(
            tables, rates.slot_rates, rates.harmonics, rates.affine, segment.series,
            segment.dual, m, segment.z,
        )  # fmt: skip


@kernel
def differentiate_mode(tables, rates, segment, m):
    """Rows of the derivatives of guards at segment.z, where those of the values are."""
    linearise_derivatives(
        tables, rates.slot_rates, rates.harmonics, segment.series, segment.dual, m, segment.z
    )


@kernel
def linearise(tables, slot_rates, harmonic_rates, affine_rates, series, dual, m, z):
    """Rows of guards and resets of a mode at z; of a Taylor mode those of its flow too.

    shapes: z (N,), series and dual as in Segment, the next three as in Rates; the rows of the
    mode in tables.generator and tables.affine are the output, and in affine_rates the rates of
    their values by parameters, in the column of 1. Where states are solved for by equations,
    z holds a solution
    """
    n = tables.sizes[0]
    outlets = tables.outlets[m]
    place_point(z, series, dual)
    _fill(tables, slot_rates, harmonic_rates, series, dual, m, tables.code_rows[m, 2], 0, 0)
    n_exits = tables.wiring.shape[1] - 1
    affine = tables.affine
    if tables.kinds[m] == at.TAYLOR:
        _write_flow(tables, affine_rates, series, dual, m, z)
    for e in range(tables.wiring[m, 0, at.N_WAYS]):
        guard, place = outlets[n + e], at.guard_row(e, 0)
        _write_row(affine[m, place], series[guard, 0], dual[guard], 0, 1.0, n, z)
        _write_rates(affine_rates, m, place, 1.0, dual[guard], n, z)
        for i in range(n):
            if (tables.wiring[m, 1 + e, at.RESETTING] >> i) & 1:
                new = outlets[n + n_exits + e * n + i]
                place = at.reset_row(n_exits, n, e, i)
                _write_row(affine[m, place], series[new, 0], dual[new], 0, 1.0, n, z)
                _write_rates(affine_rates, m, place, 1.0, dual[new], n, z)


@kernel
def linearise_derivatives(tables, slot_rates, harmonic_rates, series, dual, m, z):
    """Rows of the time derivatives of guards, where `linearise` has left those of their values."""
    n = tables.sizes[0]
    middle = tables.code_rows[m, 1]
    _fill(tables, slot_rates, harmonic_rates, series, dual, m, middle, 1, at.TERMS - 1)
    for e in range(tables.wiring[m, 0, at.N_EXITS]):
        guard, factor = tables.outlets[m, n + e], 1.0
        for r in range(1, at.DERIVATIVES):
            row = tables.affine[m, at.guard_row(e, r)]
            _write_row(row, series[guard, r], dual[guard], r, factor, n, z)
            factor *= r + 1.0


@kernel
def _fill(tables, slot_rates, harmonic_rates, series, dual, m, last, low, high):
    """Coefficients of some orders with their derivatives in all directions."""
    first, outlets, slaved = (
        tables.code_rows[m, 0],
        tables.outlets[m],
        at.explicit(tables.wiring, m),
    )
    fill_series(
        tables.code, tables.terms, tables.weights, first, last, tables.values, outlets,
        slaved, tables.sizes, tables.harmonics, series, low, high,
    )  # fmt: skip
    fill_duals(
        tables.code, tables.terms, tables.weights, first, last, tables.values, slot_rates,
        tables.generator.shape[1], outlets, slaved, tables.sizes, tables.harmonics,
        harmonic_rates, series, dual, low, high, dual.shape[1],
    )  # fmt: skip


@kernel
def _write_flow(tables, affine_rates, series, dual, m, z):
    """Rows of the rates and of the relations of the slaved states."""
    n, n_exits, outlets = tables.sizes[0], tables.wiring.shape[1] - 1, tables.outlets[m]
    slaved, implicit = at.explicit(tables.wiring, m), tables.wiring[m, 0, at.IMPLICIT]
    if implicit != 0:
        solve_together(tables, m, series, dual)
    for i in range(n):
        place = at.relation_row(n_exits, i)
        row = tables.affine[m, place]
        if (implicit >> i) & 1:
            solved = outlets[at.vanishing(n_exits, n, i)]
            _write_solved(row, dual[solved], implicit, i, n, z)
            _write_rates(affine_rates, m, place, -1.0, dual[solved], n, z)
        if (slaved >> i) & 1:
            _write_rates(affine_rates, m, place, 1.0, dual[outlets[i]], n, z)
        else:
            row = tables.generator[m, i]
        _write_row(row, series[outlets[i], 0], dual[outlets[i]], 0, 1.0, n, z)


@kernel
def _write_solved(row, gradient, implicit, i, n, z):
    """Relation of a state that is solved for: its gradient by all that is not, its value that at z.

    shapes: gradient (B, orders, LANES), where the equations are solved
    """
    rest = z[i]
    for j in range(z.size):
        if j != n:
            row[j] = 0.0
            if not (j < n and (implicit >> j) & 1):
                row[j] = -gradient[j // at.LANES, 0, j % at.LANES]
            rest -= row[j] * z[j]
    row[n] = rest


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
def _write_rates(affine_rates, m, place, sign, gradient, n, z):
    """Derivatives by parameters, which the gradient has after those by coordinates."""
    for p in range(affine_rates.shape[0]):
        d = z.size + p
        for j in range(z.size):
            affine_rates[p, m, place, j] = 0.0
        affine_rates[p, m, place, n] = sign * gradient[d // at.LANES, 0, d % at.LANES]
