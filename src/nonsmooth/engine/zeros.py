"""What is zero by construction after an event, and to which order.

After an event the fired guard is zero, slaved relations hold, and a reset may keep more.
A guard of the next mode may therefore start at zero together with some of its
derivatives. Whether it does follows from linear algebra on the directions that are left
free, and is never measured from rounded values: the mole, for example, separates with a
guard that is zero to second order.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_matrix, set_identity
from nonsmooth.engine.jit import allocating, kernel

__all__ = [
    "ALWAYS_ZERO",
    "OPEN",
    "STILL_ZERO",
    "fill_orders",
    "push_exit",
    "push_relations",
    "push_reset",
    "start_directions",
    "zero_order",
]

ALWAYS_ZERO = 99  # order of a guard that stays zero
STILL_ZERO = 98  # likewise, at the start of a segment that no event began
OPEN = -1  # order that has to be worked out along the path
# A sum counts as zero below this part of its terms: a remainder of rounding, taken for an
# honest small number, would count as large in the next product.
_ROUNDING = 1e-12


@allocating
def fill_orders(n, code_rows, affine, wiring):
    """Orders of zero for every exit taken alone, the usual case.

    shapes: code_rows, affine, wiring as in Tables; the orders in wiring are the output. Those that
    concern a mode with curved exits depend on the state and stay open
    """
    big_n = affine.shape[2]
    basis, scale = np.zeros((2, big_n, big_n)), np.zeros(big_n)
    for m in range(affine.shape[0]):
        for e in range(wiring[m, 0, at.N_EXITS]):
            target = wiring[m, 1 + e, at.TARGET]
            if target < 0:
                continue
            if at.has_code(code_rows, m) or at.has_code(code_rows, target):
                for g in range(wiring[target, 0, at.N_EXITS]):
                    wiring[m, 1 + e, at.ORDERS + g] = OPEN
                continue
            start_directions(n, affine, wiring, m, e, scale, basis)
            push_exit(n, affine, wiring, m, e, basis)
            for g in range(wiring[target, 0, at.N_EXITS]):
                wiring[m, 1 + e, at.ORDERS + g] = zero_order(affine, target, g, scale, basis)


@kernel
def start_directions(n, affine, wiring, m, e, scale, basis):
    """Directions of augmented coordinates that are free when exit e of mode m fires.

    shapes: scale (N,), how far each coordinate moves, zero where that is not known; basis
    (2, N, N); the columns of basis[0] span the directions. e = -1 stands for a start, where
    only the relations of slaved states hold
    """
    big_n = affine.shape[2]
    set_identity(basis[0])
    push_relations(n, affine, wiring, m, basis)
    if e < 0:
        return
    row = at.guard_row(e, 0)
    least = _least_influence(affine, m, row, scale)
    pivot = -1
    largest = 0.0
    for j in range(big_n):
        value = abs(_influence(affine, m, row, basis, j, scale, least))
        if value > largest:
            pivot, largest = j, value
    if pivot < 0:
        return
    at_pivot = _product(affine, m, row, basis, 0, pivot)
    for j in range(big_n):
        if j != pivot:
            factor = _influence(affine, m, row, basis, j, scale, least) / at_pivot
            for i in range(big_n):
                term = factor * basis[0, i, pivot]
                rest = basis[0, i, j] - term
                basis[0, i, j] = rest if abs(rest) > _ROUNDING * abs(term) else 0.0
    for i in range(big_n):
        basis[0, i, pivot] = 0.0


@kernel
def push_exit(n, affine, wiring, m, e, basis):
    """Carry the free directions through the reset of an exit and the target's relations."""
    push_reset(n, affine, wiring, m, e, basis)
    push_relations(n, affine, wiring, wiring[m, 1 + e, at.TARGET], basis)


@kernel
def push_reset(n, affine, wiring, m, e, basis):
    """Carry the free directions through the reset of an exit."""
    n_exits = wiring.shape[1] - 1
    copy_matrix(basis[0], basis[1])
    for i in range(n):
        if (wiring[m, 1 + e, at.RESETTING] >> i) & 1:
            row = at.reset_row(n_exits, n, e, i)
            for j in range(basis.shape[1]):
                basis[0, i, j] = _product(affine, m, row, basis, 1, j)


@kernel
def push_relations(n, affine, wiring, m, basis):
    """Carry the free directions onto the relations of the slaved states of a mode."""
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[m, 0, at.SLAVED] >> i) & 1:
            for j in range(basis.shape[1]):
                row = at.relation_row(n_exits, i)
                basis[0, i, j] = _product(affine, m, row, basis, 0, j)


@kernel
def zero_order(affine, m, g, scale, basis):
    """How many derivatives of guard g of mode m, from its value on, are zero by construction.

    shapes: scale and basis as in start_directions
    returns: 0 when the value itself is free, ALWAYS_ZERO when all are zero
    """
    for r in range(at.DERIVATIVES):
        row = at.guard_row(g, r)
        least = _least_influence(affine, m, row, scale)
        for j in range(basis.shape[1]):
            if _influence(affine, m, row, basis, j, scale, least) != 0.0:
                return r
    return ALWAYS_ZERO


@kernel
def _least_influence(affine, m, row, scale):
    """Change of a row below which a coordinate has no say in it.

    A gradient taken beside the surface, not on it, has entries that are nothing but the
    distance: those of v in x (1 + v) at x = 1e-17.
    """
    total = 0.0
    for i in range(scale.size):
        total += abs(affine[m, row, i]) * scale[i]
    return _ROUNDING * total


@kernel
def _influence(affine, m, row, basis, j, scale, least):
    """Product of a row and a direction; zero where it is nothing beside the other directions."""
    value = _product(affine, m, row, basis, 0, j)
    return 0.0 if scale[j] > 0.0 and abs(value) * scale[j] < least else value


@kernel
def _product(affine, m, row, basis, layer, j):
    """Product of a row and a direction; what only rounding has left over is zero."""
    total, size = 0.0, 0.0
    for i in range(affine.shape[2]):
        term = affine[m, row, i] * basis[layer, i, j]
        total += term
        size += abs(term)
    return total if abs(total) > _ROUNDING * size else 0.0
