"""From a program and parameter values to tables: everything the loop needs, in numba.

A sweep pays this once per parameter value, so nothing here is Python.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_matrix, set_zero
from nonsmooth.engine.jit import allocating, entry, kernel
from nonsmooth.engine.modal import decouple, triangular_form
from nonsmooth.engine.slots import fill_slots
from nonsmooth.engine.status import Status
from nonsmooth.engine.tape import run_tape
from nonsmooth.engine.zeros import fill_orders

__all__ = ["set_up"]

_OK = int(Status.COMPLETED)
_NOT_FINITE = int(Status.NOT_FINITE)
# Without a true period, time is cut into windows of about this many radians of the
# fastest oscillation, a compromise between restarts and the accuracy of long arguments.
_WINDOW_RADIANS = 32.0


@partial(entry, allocates=True)
def set_up(program, parameters, tables):
    """Fill the tables of a program for one set of parameter values.

    status: COMPLETED, NOT_FINITE, NOT_CONVERGED or ILL_CONDITIONED, with the mode where
    it happened (-1: clock)
    """
    slots = np.zeros(parameters.size + program.constants.size + program.tape.shape[0])
    run_tape(parameters, program.constants, program.tape, slots)
    mode = _fill_matrices(program, slots, tables)
    if mode >= 0:
        return _NOT_FINITE, mode
    _fill_guards(tables.generator, tables.affine, tables.wiring)
    big_n = tables.generator.shape[1]
    t = np.zeros((big_n, big_n), np.complex128)
    v = np.zeros((big_n, big_n), np.complex128)
    v_inverse = np.zeros((big_n, big_n), np.complex128)
    norm = np.zeros(big_n)
    label = np.zeros(big_n, np.int64)
    if program.period_slot >= 0:
        tables.clock[0], tables.clock[1] = slots[program.period_slot], 1.0
    else:
        tables.clock[0] = _natural_window(tables.generator, t, v, v_inverse, norm)
        tables.clock[1] = 0.0
    if not _count_turns(tables.clock, tables.harmonics):
        return _NOT_FINITE, -1
    for m in range(tables.generator.shape[0]):
        status = triangular_form(tables.generator[m], t, v, v_inverse, norm)
        if status == _OK:
            decouple(t, v, v_inverse, label, norm, tables.clock[0])
            status = fill_slots(tables, m, t, v, v_inverse, label, norm)
        if status != _OK:
            return status, m
    fill_orders(tables.sizes[0], tables.affine, tables.wiring)
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
    for k in range(n_frequencies):
        harmonics[0, k] = slots[program.frequency_slots[k]]
    for m in range(generator.shape[0]):
        for j in range(1, powers + 1):
            generator[m, n + j, n + j - 1] = float(j)
        for k in range(n_frequencies):
            c = n + 1 + powers + 2 * k
            generator[m, c, c + 1] = -harmonics[0, k]
            generator[m, c + 1, c] = harmonics[0, k]
        if not (_finite(generator[m]) and _finite(affine[m])):
            return m
    return -1


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


@allocating
def _natural_window(generator, t, v, v_inverse, norm):
    """Power of two near _WINDOW_RADIANS of the fastest oscillation or growth of any mode.

    Decay does not count: however fast, its exponential stays accurate.
    """
    fastest = 0.0
    for m in range(generator.shape[0]):
        triangular_form(generator[m], t, v, v_inverse, norm)
        for i in range(t.shape[0]):
            fastest = max(fastest, abs(t[i, i].imag), t[i, i].real)
    if fastest == 0.0:
        return 64.0
    return 2.0 ** np.rint(math.log2(_WINDOW_RADIANS / fastest))
