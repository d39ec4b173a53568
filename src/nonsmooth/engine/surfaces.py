"""Surfaces at one instant: which cell of a mode holds, and when motion goes on along a surface."""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.guard_values import (
    CLEARLY,
    fill_extent,
    guard_holds,
    must_fire,
    nearly_zero,
)
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.linearisation import differentiate_mode, linearise_mode
from nonsmooth.engine.placement import slaved_agree
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.velocity import fill_scale

__all__ = [
    "cell_that_holds",
    "count_bits",
    "in_cell",
    "is_surface",
    "leaves_both_ways",
    "meeting",
    "onto_surface",
    "over_surface",
    "visit_only",
]


@kernel
def onto_surface(wiring, m, e, visited, spell):
    """The exit onto the surface of exit e where both sides point at it, else e.

    A cell from which the path has left for another mode says nothing of the surfaces of this one.
    """
    onto, target = wiring[m, 1 + e, at.ONTO], wiring[m, 1 + e, at.TARGET]
    if onto < 0 or target < 0 or wiring[m, 1 + e, at.RESETTING] != 0:
        return e
    return onto if visited[target] == spell else e


@kernel
def over_surface(affine, wiring, m, e, z, extent, scale):
    """The exit to the other side, for a state that has jumped over a surface that holds; else e.

    What was never on the surface is not held there: only what arrives at it is.
    """
    if not nearly_zero(affine, m, e, z, extent, scale):
        for k in range(wiring[m, 0, at.N_EXITS], wiring[m, 0, at.N_WAYS]):
            if wiring[m, 1 + k, at.ONTO] == e:
                return k
    return e


@kernel
def is_surface(wiring, families, m, e):
    """Whether an exit leads through a surface to another cell of the same mode."""
    target = wiring[m, 1 + e, at.TARGET]
    return target >= 0 and families[target] == families[m] and wiring[m, 1 + e, at.RESETTING] == 0


@kernel
def visit_only(visited, m):
    """Forget all modes that were visited but one."""
    for k in range(visited.size):
        visited[k] = 0
    visited[m] = 1


@kernel
def cell_that_holds(tables, rates, segment, spell, duration, tolerance):
    """The cell visited in a spell into which motion leads where guards near zero are zero, or -1.

    Cells hand over in a circle where surfaces that are the same but for rounding are crossed: each
    guard is a little on the wrong side in the one or the other. Rates tell which cell it is.
    """
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    extent, scale, order = segment.extent, segment.scale, segment.order
    for m in range(wiring.shape[0]):
        if segment.visited[m] != spell:
            continue
        if wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
            continue
        linearise_mode(tables, rates, segment, m)
        if at.has_code(tables.code_rows, m):
            differentiate_mode(tables, rates, segment, m)
        fill_extent(n, affine, wiring, m, z, extent)
        fill_scale(n, tables.generator, affine, wiring, m, z, duration, scale)
        holds = True
        for g in range(wiring[m, 0, at.N_EXITS]):
            order[g] = 1 if nearly_zero(affine, m, g, z, extent, scale) else 0
            holds = holds and not must_fire(affine, m, g, z, extent, order, tolerance)
        if holds:
            return m
    return -1


@kernel
def meeting(tables, m, z, extent, visited):
    """Exit of mode m onto a meeting of surfaces on which z lies, -1 for none."""
    n, wiring, found, most = tables.sizes[0], tables.wiring, -1, 1
    for e in range(wiring[m, 0, at.N_EXITS], wiring[m, 0, at.N_WAYS]):
        target = wiring[m, 1 + e, at.TARGET]
        if wiring[m, 1 + e, at.RESETTING] != 0 or visited[target] != 0:
            continue
        more = count_bits(wiring[target, 0, at.SLAVED] & ~wiring[m, 0, at.SLAVED])
        if more > most and slaved_agree(n, tables.affine, wiring, target, z, extent, z, 0, CLEARLY):
            found, most = e, more
    return found


@kernel
def in_cell(tables, m, z, extent, tolerance):
    """Whether a state lies within the surfaces of a cell, whatever the exits of its mode say."""
    for g in range(tables.wiring[m, 0, at.N_EXITS]):
        if is_surface(tables.wiring, tables.families, m, g) and not guard_holds(
            tables.affine, m, g, z, extent, tolerance
        ):
            return False
    return True


@kernel
def leaves_both_ways(tables, rates, segment, m, tolerance):
    """Exit of mode m at whose surface a start lies and another cell leaves too, -1 for none.

    segment.order holds the orders of zero that pass_exits has found
    """
    affine, wiring, order = tables.affine, tables.wiring, segment.order
    if wiring[m, 0, at.KIND] != at.FREE:
        return -1
    for g in range(wiring[m, 0, at.N_EXITS]):
        cell = wiring[m, 1 + g, at.TARGET]
        if not 0 < order[g] < at.DERIVATIVES or cell < 0 or cell == m:
            continue
        if tables.families[cell] == tables.families[m]:
            linearise_mode(tables, rates, segment, cell)
            if at.has_code(tables.code_rows, cell):
                differentiate_mode(tables, rates, segment, cell)
            holds = True
            for h in range(wiring[cell, 0, at.N_EXITS]):
                order[h] = 0
                holds = holds and not must_fire(
                    affine, cell, h, segment.z, segment.extent, order, tolerance
                )
            return g if holds else -1
    return -1


@kernel
def count_bits(bits):
    """Number of bits that are set."""
    count = 0
    while bits > 0:
        count += bits & 1
        bits >>= 1
    return count
