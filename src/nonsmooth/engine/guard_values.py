"""What guards are at one instant: their values beside the terms that make them up.

Nothing here is zero but by a measure: rounding of the terms, or what a guard changes by in the
motion that has led there.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.zeros import ALWAYS_ZERO

__all__ = [
    "CLEARLY",
    "NOTHING",
    "fill_extent",
    "guard_exceeds",
    "guard_holds",
    "is_nothing",
    "must_fire",
    "nearly_zero",
    "some_zero",
    "sum_of_terms",
]

NOTHING = 1e-12  # part of what a guard changes by in a window that is nothing
CLEARLY = 1e-9  # a guard above this part of its terms is not zero by construction
_ANYWHERE_NEAR = 1e-5  # a guard above this part of its terms is not zero in any sense


@kernel
def sum_of_terms(affine, m, row, z, extent):
    """Value of a row at z, and the sum of the sizes of its terms."""
    total, size = 0.0, 0.0
    for i in range(z.size):
        total += affine[m, row, i] * z[i]
        size += abs(affine[m, row, i]) * extent[i]
    return total, size


@kernel
def fill_extent(n, affine, wiring, m, z, extent):
    """Sizes of the coordinates: of those solved for, the terms that make up the solution.

    A ring that rests at zero on a rotor of size one is known to the rounding of the one.
    """
    n_exits = wiring.shape[1] - 1
    for i in range(z.size):
        extent[i] = abs(z[i])
    for i in range(n):
        if (wiring[m, 0, at.IMPLICIT] >> i) & 1:
            for j in range(z.size):
                extent[i] += abs(affine[m, at.relation_row(n_exits, i), j] * z[j])


@kernel
def guard_holds(affine, m, g, z, extent, tolerance):
    """Whether a guard is not negative, as far as the tolerance tells."""
    value, size = sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)
    return value >= -tolerance * size


@kernel
def guard_exceeds(affine, m, g, z, extent, share):
    """Whether a guard is above a part of its terms."""
    value, size = sum_of_terms(affine, m, at.guard_row(g, 0), z, extent)
    return value > share * size


@kernel
def is_nothing(affine, m, g, z, scale):
    """Whether a guard is nothing beside what it changes by in a while."""
    row, value = at.guard_row(g, 0), 0.0
    for i in range(z.size):
        value += affine[m, row, i] * z[i]
    return abs(value) <= NOTHING * _change(affine, m, row, scale)


@kernel
def nearly_zero(affine, m, g, z, extent, scale):
    """Whether a guard is small beside its terms, or beside what it will change by."""
    row = at.guard_row(g, 0)
    value, size = sum_of_terms(affine, m, row, z, extent)
    change = _change(affine, m, row, scale)
    return abs(value) <= CLEARLY * size or abs(value) <= NOTHING * change


@kernel
def some_zero(affine, wiring, m, z, extent, scale):
    """Whether a guard of mode m is anywhere near zero, or below: its derivatives may count."""
    for g in range(wiring[m, 0, at.N_EXITS]):
        row = at.guard_row(g, 0)
        value, size = sum_of_terms(affine, m, row, z, extent)
        if value <= _ANYWHERE_NEAR * (size + _change(affine, m, row, scale)):
            return True
    return False


@kernel
def _change(affine, m, row, scale):
    """Bound of what a row changes by while the coordinates move as far as the scale says."""
    change = 0.0
    for i in range(scale.size):
        change += abs(affine[m, row, i]) * scale[i]
    return change


@kernel
def must_fire(affine, m, g, z, extent, order, tolerance):
    """Whether a guard is negative in the sense of its first derivative that is not zero.

    order[g] counts the zeros known by construction on entry; those that the tolerance
    declares to be zero are added.
    """
    if order[g] == ALWAYS_ZERO:
        return False
    for r in range(order[g], at.DERIVATIVES):
        value, size = sum_of_terms(affine, m, at.guard_row(g, r), z, extent)
        if abs(value) > tolerance * size:
            order[g] = r
            return value < 0.0
    order[g] = ALWAYS_ZERO
    return False
