"""A motion along a given word: legs of given length in given modes, and exits between them.

Nothing is searched here. A leg goes on for as long as it is told, whether or not a guard crosses
zero on the way, and where the next leg begins is told too. What comes back is what a solver needs
to close the gaps between legs: where each leg ends, the guard that should vanish there, and the
derivatives of both by the state at its start, by its two instants and by parameters. Durations
may be negative by a little, so that an orbit can be followed beyond the point where a leg vanishes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_vector, set_zero
from nonsmooth.engine.jit import entry, kernel
from nonsmooth.engine.layout import Floats
from nonsmooth.engine.leg_flow import enter_leg, go_on
from nonsmooth.engine.linearisation import linearise_mode
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.tangent import complete_columns, push_columns, relate_columns
from nonsmooth.engine.velocity import fill_velocity

__all__ = ["LegResults", "allocate_leg_results", "pass_legs"]


class LegResults(NamedTuple):
    """What legs come to; L legs, P parameters, e exits at most."""

    starts: Floats  # (L, n) states at the start, slaved ones on their relations
    ends: Floats  # (L, n) states just before the exits
    nexts: Floats  # (L, n) states behind them
    start_rates: Floats  # (L, n) rates of the states at the start
    end_rates: Floats  # (L, n) and at the end
    flow: Floats  # (L, n + P, n) columns of derivatives of the end by start and parameters
    jump: Floats  # (L, n + P, n) the same of the state behind the exits, by that at the end
    jump_rate: Floats  # (L, n) what the state behind the exits changes by when the leg lasts longer
    guard: Floats  # (L,) guard of the first exit at the end, nan without one
    guard_row: Floats  # (L, n + P) its derivatives by the state at the end and by parameters
    guard_rate: Floats  # (L,) its rate
    others: Floats  # (L, e) all guards of the mode at the end
    passed: Floats  # (L, PATH) guard of each exit, where it is passed
    spare: Floats  # (N,)


def allocate_leg_results(
    n: int, n_rates: int, n_exits: int, big_n: int, count: int, path: int
) -> LegResults:
    """Room for the results of some legs."""
    return LegResults(
        starts=np.zeros((count, n)),
        ends=np.zeros((count, n)),
        nexts=np.zeros((count, n)),
        start_rates=np.zeros((count, n)),
        end_rates=np.zeros((count, n)),
        flow=np.zeros((count, n + n_rates, n)),
        jump=np.zeros((count, n + n_rates, n)),
        jump_rate=np.zeros((count, n)),
        guard=np.zeros(count),
        guard_row=np.zeros((count, n + n_rates)),
        guard_rate=np.zeros(count),
        others=np.zeros((count, n_exits)),
        passed=np.zeros((count, path)),
        spare=np.zeros(big_n),
    )


@entry
def pass_legs(
    tables, rates, scratch, segment, tangent, modes, paths, states, begins, ends, results
):
    """Pass each leg from its own start, and the exits at its end.

    shapes: modes (L,); paths (L, PATH) exits in order, -1 for none; states (L, n) at the starts;
    begins, ends (L,) instants at which legs begin and end; tangent with n + P columns; results as
    `LegResults`, the output
    returns: the number of legs passed, fewer than all where one of them fails
    """
    window = tables.clock[0]
    for k in range(modes.size):
        number = math.floor(begins[k] / window)
        phase = begins[k] - number * window
        duration = ends[k] - begins[k]
        if not _pass_leg(
            tables, rates, scratch, segment, tangent, modes[k], paths[k], states[k], number,
            phase, duration, k, results,
        ):  # fmt: skip
            return k
    return modes.size


@kernel
def _pass_leg(
    tables, rates, scratch, segment, tangent, m, path, state, number, phase, duration, k, results
):
    n = tables.sizes[0]
    if not enter_leg(tables, rates, segment, tangent, m, state, number, phase):
        return False
    velocity = tangent.velocity
    copy_vector(segment.z, results.starts[k], n)
    fill_velocity(n, tables.generator, tables.affine, tables.wiring, m, segment.z, velocity)
    copy_vector(velocity, results.start_rates[k], n)
    number, phase, arrived = go_on(
        tables, rates, scratch, segment, tangent, m, number, phase, duration
    )
    if not arrived:
        return False
    z = segment.z
    linearise_mode(tables, rates, segment, m)
    fill_velocity(n, tables.generator, tables.affine, tables.wiring, m, z, velocity)
    copy_vector(z, results.ends[k], n)
    copy_vector(velocity, results.end_rates[k], n)
    for c in range(tangent.columns.shape[0]):
        copy_vector(tangent.columns[c], results.flow[k, c], n)
    _read_guards(tables, rates, m, path[0], z, velocity, tangent.columns, k, results)
    return _pass_path(tables, rates, segment, tangent, m, path, number, phase, k, results)


@kernel
def _read_guards(tables, rates, m, e, z, velocity, columns, k, results):
    """All guards at the end of a leg, and the derivatives of the one that should vanish."""
    n, affine = tables.sizes[0], tables.affine
    for g in range(results.others.shape[1]):
        results.others[k, g] = math.nan
        if g < tables.wiring[m, 0, at.N_EXITS]:
            results.others[k, g] = _product(affine[m], at.guard_row(g, 0), z)
    results.guard[k], results.guard_rate[k] = math.nan, math.nan
    _set_zero(results.guard_row[k])
    if e < 0:
        return
    row = at.guard_row(e, 0)
    results.guard[k] = _product(affine[m], row, z)
    results.guard_rate[k] = _product(affine[m], row, velocity)
    for i in range(n):
        results.guard_row[k, i] = affine[m, row, i]
    for p in range(rates.chosen.size):
        change = _product(rates.affine[p, m], row, z)
        for i in range(n, z.size):  # what the forcing at this instant has of the parameter
            change += affine[m, row, i] * columns[n + p, i]
        results.guard_row[k, n + p] = change


@kernel
def _pass_path(tables, rates, segment, tangent, m, path, number, phase, k, results):
    """Pass exits at one instant, with their own derivatives; False where states do not settle."""
    n, n_exits, z = tables.sizes[0], tables.wiring.shape[1] - 1, segment.z
    columns, moved = tangent.columns, results.spare
    copy_vector(tangent.velocity, moved, z.size)
    set_zero(columns)
    for c in range(n):
        columns[c, c] = 1.0
    complete_columns(tables, rates, tangent, number, phase, z)
    _set_zero(results.passed[k])
    for step in range(path.size):
        e = path[step]
        if e < 0:
            break
        results.passed[k, step] = _product(tables.affine[m], at.guard_row(e, 0), z)
        push_columns(tables, rates, segment, tangent, m, e)
        _reset_both(tables, m, e, z, moved, segment.spare)
        target = tables.wiring[m, 1 + e, at.TARGET]
        if target < 0:
            return False
        m = target
        if tables.wiring[m, 0, at.IMPLICIT] != 0 and not settle(tables, rates, segment, m):
            return False
        linearise_mode(tables, rates, segment, m)
        _relate_both(n, n_exits, tables, m, z, moved)
        relate_columns(tables, rates, segment, tangent, m)
    copy_vector(z, results.nexts[k], n)
    copy_vector(moved, results.jump_rate[k], n)
    for c in range(columns.shape[0]):
        copy_vector(columns[c], results.jump[k, c], n)
    return True


@kernel
def _reset_both(tables, m, e, z, moved, spare):
    """Apply a reset to the coordinates, and its derivative to their rates."""
    n, n_exits = tables.sizes[0], tables.wiring.shape[1] - 1
    bits = tables.wiring[m, 1 + e, at.RESETTING]
    if bits == 0:
        return
    for vector in (z, moved):
        for i in range(n):
            spare[i] = vector[i]
            if (bits >> i) & 1:
                spare[i] = _product(tables.affine[m], at.reset_row(n_exits, n, e, i), vector)
        copy_vector(spare, vector, n)


@kernel
def _relate_both(n, n_exits, tables, m, z, moved):
    """Put slaved states on their relations, and their rates on the derivatives of these."""
    slaved = tables.wiring[m, 0, at.SLAVED]
    for i in range(n):
        if (slaved >> i) & 1:
            row = at.relation_row(n_exits, i)
            z[i] = _product(tables.affine[m], row, z)
            moved[i] = _product(tables.affine[m], row, moved)


@kernel
def _set_zero(vector):
    for i in range(vector.size):
        vector[i] = 0.0


@kernel
def _product(rows, row, vector):
    total = 0.0
    for i in range(vector.size):
        total += rows[row, i] * vector[i]
    return total
