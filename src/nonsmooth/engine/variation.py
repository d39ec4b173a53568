"""Columns of derivatives along a segment of an exact mode, in closed form.

A column u moves as u' = M u + M_p z, with M_p = dM/dp for the column of a parameter p and
zero for that of an initial state. The homogeneous part moves as the state does. What M_p
adds is, but for a motion of the frame (see `variation_setup`), a coupling of slots with
close eigenvalues: s R exp(lambda s) of a slot with itself, and a Taylor series in a common
frame for a bundle, in steps over which its members part by a radian at most.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.bundle_series import force_bundles
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.short_series import SHORT, force_shortly, slave_shortly
from nonsmooth.engine.trigonometry import cos_sin

__all__ = ["advance_columns", "augmented_columns"]


@kernel
def augmented_columns(n, powers, time, frequency_rates, z, columns):
    """Fill what a column has beyond the states: the derivatives of 1, powers and harmonics.

    shapes: frequency_rates (P, K) as Rates.harmonics, z (N,) augmented coordinates at that
    time, columns (C, N), the last P of them by parameters
    """
    first = columns.shape[0] - frequency_rates.shape[0]
    for c in range(columns.shape[0]):
        for i in range(n, z.size):
            columns[c, i] = 0.0
        for k in range(frequency_rates.shape[1] if c >= first else 0):
            i = n + 1 + powers + 2 * k
            angle = time * frequency_rates[c - first, k]
            columns[c, i], columns[c, i + 1] = -angle * z[i + 1], angle * z[i]


@kernel
def advance_columns(tables, rates, scratch, m, z, s, columns, out):
    """States of the columns after a time s in mode m; slaved states follow their relation.

    shapes: z (N,) augmented coordinates at the start; columns (C, N) there, completed by
    `augmented_columns`, the last P of them by the chosen parameters; out (C, n) or wider,
    may be `columns` itself
    """
    n, big_n = tables.sizes[0], z.size
    n_rates = rates.chosen.size
    first = columns.shape[0] - n_rates
    entry, reads, slots, states = tables.entry, tables.reads, tables.slots, tables.states
    count = slots[m, at.COUNT]
    factors, turns, moved = scratch.factors, scratch.turns, scratch.moved
    _fill_factors(tables.spectrum, tables.nilpotent, slots, m, s, factors, turns, scratch.spare)
    for c in range(first):
        _read_slots(entry, reads, m, count, n, columns[c], scratch.slots)
        _move(slots, m, factors, turns, scratch.slots, moved)
        for i in range(n):
            out[c, i] = _real_product(states[m, i], moved, count)
    if n_rates == 0:
        return
    short = s * rates.growth[m, 0] <= SHORT
    k = 0
    while k + 1 < rates.longest.shape[0] and rates.longest[k + 1, m] >= s:
        k += 1
    if short:
        added, slaved = scratch.added, tables.wiring[m, 0, at.SLAVED]
        force_shortly(
            tables.generator[m], rates.generator, m, rates.growth[m], z, s, added,
            scratch.series, scratch.column,
        )  # fmt: skip
        slave_shortly(n, tables.sizes[5], slaved, tables.affine[m], rates.affine, m, added)
    else:
        _read_slots(entry, reads, m, count, big_n, z, scratch.start)
        _move(slots, m, factors, turns, scratch.start, scratch.end)
        for p in range(n_rates):
            for j in range(count):
                scratch.forced[p, j] = s * rates.couplings[k, p, m, j, j] * scratch.end[j]
        force_bundles(
            rates.bundles[k, m], rates.means[k, m], rates.spreads[k, m], rates.rest[k, m],
            rates.couplings[k], m, s, scratch.start, scratch.sums, scratch.terms,
            scratch.spare, scratch.forced,
        )  # fmt: skip
    for p in range(n_rates):
        column = scratch.column
        for i in range(big_n):
            column[i] = columns[first + p, i]
        if not short:
            _leave_frame(n, rates.frame[k, p, m], z, column)
        _read_slots(entry, reads, m, count, big_n, column, scratch.slots)
        _move(slots, m, factors, turns, scratch.slots, moved)
        if not short:
            for j in range(count):
                moved[j] += scratch.forced[p, j]
        for i in range(n):
            value = _real_product(states[m, i], moved, count)
            if short:
                value += scratch.added[1 + p, i]
            else:
                value += _real_product(rates.lift[k, p, m, i], scratch.end, count)
            out[first + p, i] = value


@kernel
def _leave_frame(n, frame, z, column):
    for i in range(n):
        for j in range(z.size):
            column[i] -= frame[i, j] * z[j]


@kernel
def _real_product(weights, slots, count):
    total = 0.0
    for j in range(count):
        total += weights[j].real * slots[j].real - weights[j].imag * slots[j].imag
    return total


@kernel
def _read_slots(entry, reads, m, count, end, column, slots):
    """Slots of a column whose entries from ``end`` on are zero."""
    for j in range(count):
        re, im = 0.0, 0.0
        for i in range(reads[m, j], end):
            re += entry[m, j, i, at.WEIGHT_RE] * column[i]
            im += entry[m, j, i, at.WEIGHT_IM] * column[i]
        slots[j] = complex(re, im)


@kernel
def _fill_factors(spectrum, nilpotent, slots, m, s, factors, turns, spare):
    """Factors of simple slots, and matrices of clusters, for a time s."""
    for j in range(slots[m, at.END_DAMPED]):
        factors[j] = _exponential(spectrum[m, j], s)
    for c in range(slots[m, at.N_CLUSTERS]):
        first = slots[m, at.CLUSTERS + 3 * c]
        end = first + slots[m, at.CLUSTERS + 3 * c + 1]
        factor = _exponential(spectrum[m, first], s)
        for b in range(first, end):
            for a in range(first, end):
                factors[a] = turns[a, b] = factor if a == b else 0.0
            for d in range(1, slots[m, at.CLUSTERS + 3 * c + 2] + 1):
                for a in range(first, end):
                    total = complex(0.0, 0.0)
                    for k in range(first, end):
                        total += nilpotent[m, a, k] * factors[k]
                    spare[a] = total * (s / d)
                for a in range(first, end):
                    factors[a] = spare[a]
                    turns[a, b] += spare[a]


@kernel
def _exponential(eigenvalue, s):
    decay = math.exp(eigenvalue.real * s)
    cos, sin = cos_sin(eigenvalue.imag * s)
    return complex(decay * cos, decay * sin)


@kernel
def _move(slots, m, factors, turns, start, end):
    """Slots at the end of the segment from those at its start."""
    for j in range(slots[m, at.END_DAMPED]):
        end[j] = factors[j] * start[j]
    for c in range(slots[m, at.N_CLUSTERS]):
        low = slots[m, at.CLUSTERS + 3 * c]
        high = low + slots[m, at.CLUSTERS + 3 * c + 1]
        for a in range(low, high):
            total = complex(0.0, 0.0)
            for b in range(low, high):
                total += turns[a, b] * start[b]
            end[a] = total
