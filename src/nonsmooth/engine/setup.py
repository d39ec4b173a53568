"""From a program and parameter values to tables: everything the loop needs, in numba.

A sweep pays this once per parameter value, so nothing here is Python.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_matrix, copy_vector, set_zero
from nonsmooth.engine.decoupling import decouple
from nonsmooth.engine.jit import allocating, entry, kernel
from nonsmooth.engine.layout import counted_tables_at
from nonsmooth.engine.linear_flow import augmented
from nonsmooth.engine.linearisation import linearise
from nonsmooth.engine.refinement import refine, worth_refining
from nonsmooth.engine.signals import fill_chains, fill_first_pieces
from nonsmooth.engine.slots import fill_slots
from nonsmooth.engine.status import Status
from nonsmooth.engine.tape import run_tape
from nonsmooth.engine.triangular import triangular_form
from nonsmooth.engine.window import natural_window
from nonsmooth.engine.zeros import fill_orders

__all__ = ["set_up"]

_OK = int(Status.COMPLETED)
_NOT_FINITE = int(Status.NOT_FINITE)
_LEAST_HORIZON = 1e-4  # of the longest time between knots: a jump written as a steep piece


@partial(entry, allocates=True)
def set_up(program, parameters, stack):
    """Fill the tables of a program for some sets of parameter values.

    shapes: parameters (k, p), stack of k tables
    status: COMPLETED, NOT_FINITE or NOT_CONVERGED, with the mode where it happened (-1: clock) and
    the number of sets that are done
    """
    for row in range(parameters.shape[0]):
        status, mode = _set_up_one(program, parameters[row], counted_tables_at(stack, row))
        if status != _OK:
            return status, mode, row
    return _OK, 0, parameters.shape[0]


@allocating
def _set_up_one(program, parameters, tables):
    """Fill the tables for one set; returns status and mode as `set_up`."""
    slots = tables.values
    run_tape(parameters, program.constants, program.tape, slots)
    for term in range(tables.weights.size):
        tables.weights[term] = slots[program.terms[term, 1]]
    mode = _fill_matrices(program, slots, tables)
    if mode >= 0:
        return _NOT_FINITE, mode
    _fill_guards(tables.generator, tables.affine, tables.wiring)
    if program.period_slot < 0:
        _linearise_at_rest(program, tables)
    n_modes, big_n = tables.generator.shape[0], tables.generator.shape[1]
    t = np.zeros((n_modes, big_n, big_n), np.complex128)
    v = np.zeros((n_modes, big_n, big_n), np.complex128)
    v_inverse = np.zeros((n_modes, big_n, big_n), np.complex128)
    block = np.zeros((n_modes, big_n), np.int64)
    norm = np.zeros((n_modes, big_n))
    doubt = np.zeros(big_n)
    label = np.zeros(big_n, np.int64)
    for m in range(n_modes):
        status = triangular_form(tables.generator[m], t[m], v[m], v_inverse[m], block[m], norm[m])
        if status != _OK:
            return status, m
    window = slots[program.period_slot] if program.period_slot >= 0 else natural_window(t)
    _set_clock(tables.clock, window, program.period_slot >= 0, program.spacing)
    if not _count_turns(tables.clock, tables.harmonics):
        return _NOT_FINITE, -1
    horizon = tables.clock[at.HORIZON]
    for m in range(n_modes):
        if tables.kinds[m] != at.EXACT:
            continue
        copy_vector(norm[m], doubt, big_n)
        decouple(tables.sizes[0], t[m], v[m], v_inverse[m], block[m], label, horizon)
        if worth_refining(t[m], block[m], norm[m], window):
            refine(tables.generator[m], t[m], v[m], v_inverse[m], label)
            for i in range(big_n):
                doubt[i] = abs(t[m, i, i])
        fill_slots(tables, m, t[m], v[m], v_inverse[m], label, block[m], norm[m], doubt)
    fill_orders(tables.sizes[0], tables.code_rows, tables.affine, tables.wiring)
    return _OK, 0


@kernel
def _fill_matrices(program, slots, tables):
    """Generators, guards, relations and resets; returns the mode of a bad number or -1."""
    n, powers, n_frequencies = program.sizes[0], program.sizes[1], program.sizes[2]
    n_exits = program.sizes[5]
    generator, affine, harmonics = tables.generator, tables.affine, tables.harmonics
    for m in range(generator.shape[0]):
        copy_matrix(program.wiring[m], tables.wiring[m])
        set_zero(generator[m])
        set_zero(affine[m])
        set_zero(tables.nilpotent[m])
    _scatter(program.flow, slots, generator)
    for row in range(program.relations.shape[0]):
        term = program.relations[row]
        place = at.relation_row(n_exits, term[1])
        affine[term[0], place, term[2]] += slots[term[3]]
    for row in range(program.guards.shape[0]):
        term = program.guards[row]
        affine[term[0], at.guard_row(term[1], 0), term[2]] += slots[term[3]]
    for row in range(program.resets.shape[0]):
        term = program.resets[row]
        place = at.reset_row(n_exits, n, term[1], term[2])
        affine[term[0], place, term[3]] += slots[term[4]]
    for row in range(program.factors.shape[0]):
        term = program.factors[row]
        affine[term[0], at.factor_row(n_exits, n, term[1]), term[2]] += slots[term[3]]
    for k in range(n_frequencies):
        harmonics[0, k] = slots[program.frequency_slots[k]]
    for m in range(generator.shape[0]):
        for j in range(1, powers + 1):
            generator[m, n + j, n + j - 1] = float(j)
        for k in range(n_frequencies):
            c = n + 1 + powers + 2 * k
            generator[m, c, c + 1] = -harmonics[0, k]
            generator[m, c + 1, c] = harmonics[0, k]
        fill_chains(generator[m], at.first_of_signals(program.sizes), program.sizes[7])
        if not (_finite(generator[m]) and _finite(affine[m])):
            return m
    return -1


@allocating
def _linearise_at_rest(program, tables):
    """How fast Taylor modes are near the rest state, for the window of a system without period.

    Where they have no finite rates there, they have no say in it. Cells on surfaces have none at
    all: they move as those beside them do, and where the gradient of a surface vanishes, as that
    of y - sin(y) at zero, what rounding leaves of their rates would count as 1e8 radians a second.
    """
    big_n = tables.generator.shape[1]
    z = np.zeros(big_n)
    no_rates, no_rows = np.zeros((0, 0)), np.zeros((0, 0, 0, 0))
    series = np.zeros((program.sizes[6], at.SERIES_ROW))
    dual = np.zeros((program.sizes[6], at.n_blocks(big_n), at.TERMS, at.LANES))
    n = program.sizes[0]
    for i in range(n):
        if program.rest_slots[i] >= 0:
            z[i] = tables.values[program.rest_slots[i]]
    augmented(n, program.sizes[1], 0.0, tables.harmonics, 0, 0.0, z)
    fill_first_pieces(tables.signals, tables.knots, at.first_of_signals(tables.sizes), z)
    for m in range(tables.kinds.size):
        if tables.kinds[m] == at.TAYLOR and tables.wiring[m, 0, at.KIND] == at.FREE:
            linearise(tables, no_rates, no_rates, no_rows, series, dual, m, z)
            if not _finite(tables.generator[m]):
                for i in range(n):
                    for j in range(big_n):
                        tables.generator[m, i, j] = 0.0


@kernel
def _finite(matrix):
    total = 0.0
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            total += abs(matrix[i, j])
    return math.isfinite(total)


@kernel
def _scatter(rows, slots, matrices):
    for row in range(rows.shape[0]):
        matrices[rows[row, 0], rows[row, 1], rows[row, 2]] += slots[rows[row, 3]]


@kernel
def _fill_guards(generator, affine, wiring):
    """Rows of the time derivatives of every guard: h, h M, h M M, ..."""
    big_n = generator.shape[1]
    for m in range(generator.shape[0]):
        for e in range(wiring[m, 0, at.N_EXITS]):
            for r in range(1, at.DERIVATIVES):
                for j in range(big_n):
                    total = 0.0
                    for i in range(big_n):
                        total += affine[m, at.guard_row(e, r - 1), i] * generator[m, i, j]
                    affine[m, at.guard_row(e, r), j] = total


@kernel
def _set_clock(clock, window, is_period, spacing):
    """Window, longest segment, and the time over which eigenvalues are told apart.

    A piece of a signal that is short beside an oscillation has large third derivatives: told
    apart from the oscillation, its motion would be a difference of large numbers.
    """
    clock[at.WINDOW], clock[at.IS_PERIOD] = window, 1.0 if is_period else 0.0
    clock[at.LASTS] = min(at.WINDOWS * window, spacing[1])
    clock[at.HORIZON] = min(window, max(spacing[0], _LEAST_HORIZON * spacing[1]))


@kernel
def _count_turns(clock, harmonics):
    """Turns of each harmonic in a window; False when the window is no length."""
    if not (math.isfinite(clock[0]) and clock[0] > 0.0):
        return False
    for k in range(harmonics.shape[1]):
        turns = harmonics[0, k] * clock[0] / (2.0 * math.pi)
        whole = np.rint(turns)
        # the period is a rounded quotient, so a whole number comes out off by some ulps
        harmonics[1, k] = whole if abs(turns - whole) <= 1e-14 * max(1.0, whole) else turns
    return True
