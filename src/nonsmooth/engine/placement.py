"""Where a state is put at an event: on the guard that fired, through resets, onto relations."""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_vector
from nonsmooth.engine.guard_values import CLEARLY, sum_of_terms
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.velocity import velocity_of

__all__ = ["apply_reset", "set_fired_zero", "settle_slaved", "slaved_agree", "states_agree"]

_SHARE = 1e-3  # of a coordinate in the rate of a guard, from which it is moved onto its zero


@kernel
def set_fired_zero(n, generator, affine, wiring, m, e, z, extent):
    """Put the state exactly on the fired guard, by the coordinate whose motion has led there.

    Where time has led there, as in cos(w t) + 1e-12 x, the state stays as it is: x would have
    to go far for what a rounding of time does.

    returns: the sum of the sizes of the terms before
    """
    row = at.guard_row(e, 0)
    value, size = sum_of_terms(affine, m, row, z, extent)
    pivot, several = -1, False
    for i in range(z.size):
        if i != n and affine[m, row, i] != 0.0:
            several = pivot >= 0
            pivot = i
            if several:
                break
    if several:
        pivot = _largest_share(n, generator, affine, wiring, m, row, z)
    if 0 <= pivot < n:
        z[pivot] -= value / affine[m, row, pivot]
    return size


@kernel
def _largest_share(n, generator, affine, wiring, m, row, z):
    """State with the largest share in the rate of a guard; -1 where it has next to none."""
    pivot = -1
    largest, total = 0.0, 0.0
    for i in range(z.size):
        if i != n and affine[m, row, i] != 0.0:
            share = abs(affine[m, row, i] * velocity_of(n, generator, affine, wiring, m, z, i))
            total += share
            if i < n and share > largest:
                pivot, largest = i, share
    return pivot if largest >= _SHARE * total else -1


@kernel
def apply_reset(n, affine, wiring, m, e, z, extent, spare):
    """Apply the reset of an exit, all new values from the state before."""
    bits = wiring[m, 1 + e, at.RESETTING]
    if bits == 0:
        return
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        spare[i] = z[i]
        if (bits >> i) & 1:
            spare[i] = sum_of_terms(affine, m, at.reset_row(n_exits, n, e, i), z, extent)[0]
    copy_vector(spare, z, n)


@kernel
def states_agree(n, affine, wiring, target, segment, jumping, fired, scaled, tolerance):
    """Whether the slaved states of the target, in segment.spare, agree with their relations at z.

    jumping: bits of those that may jump; scaled: whether segment.scale is known
    """
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[target, 0, at.SLAVED] >> i) & 1 and not (jumping >> i) & 1:
            row, before = at.relation_row(n_exits, i), segment.spare[i]
            value, size = sum_of_terms(affine, target, row, segment.z, segment.extent)
            # the root of the fired guard leaves a little more than the tolerance
            allowed = max(tolerance, CLEARLY) * (size + abs(before) + fired)
            for j in range(segment.z.size if scaled else 0):
                allowed += CLEARLY * abs(affine[target, row, j]) * segment.scale[j]
            if abs(value - before) > allowed:
                return False
    return True


@kernel
def settle_slaved(n, affine, wiring, m, z, extent):
    """Put the slaved states of a mode on their relations."""
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[m, 0, at.SLAVED] >> i) & 1:
            z[i] = sum_of_terms(affine, m, at.relation_row(n_exits, i), z, extent)[0]


@kernel
def slaved_agree(n, affine, wiring, m, z, extent, given, left_out, tolerance):
    """Whether the slaved states of a mode, as they were given, agree with their relations.

    left_out: bits of those that were not given, which agree in any case
    """
    n_exits = wiring.shape[1] - 1
    for i in range(n):
        if (wiring[m, 0, at.SLAVED] >> i) & 1 and not (left_out >> i) & 1:
            value, size = sum_of_terms(affine, m, at.relation_row(n_exits, i), z, extent)
            if abs(value - given[i]) > tolerance * (size + abs(given[i])):
                return False
    return True
