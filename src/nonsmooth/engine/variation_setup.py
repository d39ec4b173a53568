"""From a program and its tables to the derivatives by some parameters, and their modal form.

In full slots w' = L w, and a column of derivatives, zeta' = L zeta + P w. With Y such that
P + L Y - Y L = R vanishes between bundles, xi = zeta - Y w moves as xi' = L xi + R w: what
couples distant eigenvalues is a motion of the frame, not of the slots. Back in coordinates
Y is `Rates.frame`, a real matrix, and R is `Rates.couplings`.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import set_zero
from nonsmooth.engine.bundles import fill_bundles, group_slots
from nonsmooth.engine.full_slots import fill_full_slots
from nonsmooth.engine.jit import allocating, entry, kernel
from nonsmooth.engine.short_series import SHORT, fill_growth
from nonsmooth.engine.status import Status
from nonsmooth.engine.tape import run_tape
from nonsmooth.engine.tape_rates import run_tape_rates
from nonsmooth.engine.variation_tables import FRAMES

__all__ = ["set_up_rates"]

_OK = int(Status.COMPLETED)
_NOT_FINITE = int(Status.NOT_FINITE)
_SHORTER = 8.0  # from one frame to the next


@partial(entry, allocates=True)
def set_up_rates(program, parameters, tables, rates):
    """Fill the derivatives for the parameter values for which the tables were set up.

    status: COMPLETED, or NOT_FINITE with the place in `rates.chosen` of the parameter by
    which a coefficient has no finite derivative
    """
    slots = np.zeros(parameters.size + program.constants.size + program.tape.shape[0])
    run_tape(parameters, program.constants, program.tape, slots)
    run_tape_rates(
        parameters, program.constants, program.tape, slots, rates.chosen, rates.slot_rates
    )
    for p in range(rates.chosen.size):
        if not _fill_matrices(program, p, rates):
            return _NOT_FINITE, p
    for m in range(tables.generator.shape[0]):
        if program.kinds[m] == at.EXACT:
            _fill_modal(tables, rates, m)
    return _OK, 0


@kernel
def _fill_matrices(program, p, rates):
    """Derivatives of generators and affine rows by parameter p; False where not finite."""
    n, powers, n_exits = program.sizes[0], program.sizes[1], program.sizes[5]
    moved, generator, affine = rates.slot_rates, rates.generator[p], rates.affine[p]
    for m in range(generator.shape[0]):
        set_zero(generator[m])
        set_zero(affine[m])
    for row in range(program.flow.shape[0]):
        term = program.flow[row]
        generator[term[0], term[1], term[2]] += moved[term[3], p]
    for row in range(program.relations.shape[0]):
        term = program.relations[row]
        affine[term[0], at.relation_row(n_exits, term[1]), term[2]] += moved[term[3], p]
    for row in range(program.guards.shape[0]):
        term = program.guards[row]
        affine[term[0], at.guard_row(term[1], 0), term[2]] += moved[term[3], p]
    for row in range(program.resets.shape[0]):
        term = program.resets[row]
        place = at.reset_row(n_exits, n, term[1], term[2])
        affine[term[0], place, term[3]] += moved[term[4], p]
    for k in range(rates.harmonics.shape[1]):
        rate = moved[program.frequency_slots[k], p]
        rates.harmonics[p, k] = rate
        c = n + 1 + powers + 2 * k
        for m in range(generator.shape[0]):
            generator[m, c, c + 1], generator[m, c + 1, c] = -rate, rate
    total = 0.0
    for m in range(generator.shape[0]):
        for i in range(generator.shape[2]):
            for j in range(generator.shape[2]):
                total += abs(generator[m, i, j])
            for row in range(affine.shape[1]):
                total += abs(affine[m, row, i])
    return math.isfinite(total)


@allocating
def _fill_modal(tables, rates, m):
    """Bundles, frame and couplings of mode m."""
    big_n = tables.generator.shape[1]
    whole = np.zeros((3, big_n), np.int64)
    square = np.zeros((5, big_n, big_n), np.complex128)
    line = np.zeros((2, big_n))
    twin, partner, label = whole[0], whole[1], whole[2]
    v, v_inverse, generator = square[0], square[1], square[2]
    full = fill_full_slots(tables, m, twin, partner, v, v_inverse, generator)
    rate = max(tables.spans[m, at.FASTEST], 1.0 / tables.clock[at.HORIZON])
    fill_growth(tables.generator[m], rate, line[0], line[1], rates.growth[m])
    for f in range(full):
        label[f] = f
    for k in range(FRAMES):
        rates.longest[k, m] = 0.0
    horizon = min(tables.clock[at.LASTS], tables.spans[m, at.LONGEST])
    k = 0
    while k == 0 or horizon * rates.growth[m, 0] > SHORT:
        joined = group_slots(full, partner, generator, horizon, label)
        if k == 0 or joined:
            k = min(k, FRAMES - 1)
            rates.longest[k, m] = horizon
            fill_bundles(
                full, tables.slots[m, at.COUNT], twin, generator, label, rates.bundles[k, m],
                rates.rest[k, m], rates.means[k, m], rates.spreads[k, m],
            )  # fmt: skip
            for p in range(rates.chosen.size):
                _fill_frame(tables, rates, k, p, m, full, partner, label, square)
            k += 1
        horizon /= _SHORTER


@kernel
def _fill_frame(tables, rates, k, p, m, full, partner, label, square):
    """Frame k of mode m by parameter p, and the couplings that it leaves."""
    v, v_inverse, generator, y, work = square[0], square[1], square[2], square[3], square[4]
    couplings, frame = rates.couplings[k, p, m], rates.frame[k, p, m]
    _multiply_real(rates.generator[p, m], v, full, work)
    _multiply(v_inverse, work, full, couplings)
    set_zero(y)
    for _ in range(2):  # refined generators have a little below the diagonal
        _eliminate(generator, couplings, label, full, y)
    for f in range(full):
        for g in range(full):
            if label[f] != label[g]:
                couplings[f, g] = 0.0
    _turn_back(tables.sizes[0], full, v, y, v_inverse, frame)
    _multiply_real(frame, v, full, work)
    _fill_lift(tables, rates, p, m, partner, v, work, rates.lift[k, p, m])


@kernel
def _multiply(a, b, full, product):
    for f in range(full):
        for g in range(full):
            total = complex(0.0, 0.0)
            for i in range(b.shape[0]):
                total += a[f, i] * b[i, g]
            product[f, g] = total


@kernel
def _turn_back(n, full, v, y, v_inverse, frame):
    """frame := v y v_inverse in the rows of states; what forcing does depends on itself."""
    set_zero(frame)
    for i in range(n):
        for g in range(full):
            total = complex(0.0, 0.0)
            for f in range(full):
                total += v[i, f] * y[f, g]
            for j in range(frame.shape[1]):
                inverse = v_inverse[g, j]
                frame[i, j] += total.real * inverse.real - total.imag * inverse.imag


@kernel
def _multiply_real(matrix, v, full, product):
    """product := matrix v, matrix real."""
    for i in range(matrix.shape[0]):
        for f in range(full):
            total = complex(0.0, 0.0)
            for k in range(matrix.shape[1]):
                if matrix[i, k] != 0.0:
                    total += matrix[i, k] * v[k, f]
            product[i, f] = total


@kernel
def _eliminate(generator, couplings, label, full, y):
    """Solve couplings + generator y - y generator = 0 between bundles, by substitution."""
    for f in range(full - 1, -1, -1):
        for g in range(full):
            if label[f] == label[g]:
                continue
            total = -couplings[f, g]
            for h in range(full):
                if h != f and generator[f, h] != 0.0:
                    total -= generator[f, h] * y[h, g]
                if h != g and generator[h, g] != 0.0:
                    total += y[f, h] * generator[h, g]
            y[f, g] = total / (generator[f, f] - generator[g, g])


@kernel
def _fill_lift(tables, rates, p, m, partner, v, moved, lift):
    """Slots to states by way of the frame; slaved states follow their relation."""
    n, n_exits, big_n = tables.sizes[0], tables.sizes[5], v.shape[0]
    slaved = tables.wiring[m, 0, at.SLAVED]
    for a in range(tables.slots[m, at.COUNT]):
        weight = 1.0 if partner[a] == a else 2.0
        for i in range(n):
            value = moved[i, a]
            if (slaved >> i) & 1:
                row = at.relation_row(n_exits, i)
                value = complex(0.0, 0.0)
                for j in range(big_n):
                    value += tables.affine[m, row, j] * moved[j, a]
                    value += rates.affine[p, m, row, j] * v[j, a]
            lift[i, a] = value * weight
