"""Weights of the slots in everything read from them: states, guards, and the ladder of steps."""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import allocating, kernel
from nonsmooth.engine.trigonometry import cos_sin

__all__ = ["LASTING", "fill_ladder", "fill_series", "fill_weights"]

LASTING = 64.0  # exponent of a decay over a window up to which a motion counts as lasting
_LONGEST_TURN = 4.0  # radians of the longest step of the ladder


@kernel
def fill_weights(tables, m, v, v_inverse, weight, place, count):
    """Weights between augmented coordinates and slots, slots and states."""
    big_n = v.shape[0]
    n, n_exits = tables.sizes[0], tables.sizes[5]
    entry, affine = tables.entry, tables.affine[m]
    slaved = tables.wiring[m, 0, at.SLAVED]
    for slot in range(count):
        j = place[slot]
        tables.reads[m, slot] = big_n
        for i in range(big_n - 1, -1, -1):
            entry[m, slot, i, at.WEIGHT_RE] = v_inverse[j, i].real
            entry[m, slot, i, at.WEIGHT_IM] = v_inverse[j, i].imag
            entry[m, slot, i, at.WEIGHT_SIZE] = abs(v_inverse[j, i])
            if v_inverse[j, i] != 0.0:
                tables.reads[m, slot] = i
        for i in range(n):
            value = v[i, j]
            if (slaved >> i) & 1:
                value = _product(affine[at.relation_row(n_exits, i)], v, j)
            tables.states[m, i, slot] = value * weight[j]


@allocating
def fill_series(tables, m, v, weight, place, count):
    """Weights of the slots in the Taylor coefficients of every guard, and of its factors."""
    series, nilpotent = tables.series, tables.nilpotent[m]
    row = np.zeros(v.shape[0], np.complex128)
    rates = np.zeros(v.shape[0], np.complex128)
    n, n_exits = tables.sizes[0], tables.sizes[5]
    for e in range(series.shape[1]):
        place_of_row = at.guard_row(e, 0)
        if e >= n_exits:
            place_of_row = at.factor_row(n_exits, n, e - n_exits)
        elif e >= tables.wiring[m, 0, at.N_EXITS]:
            continue
        for slot in range(count):
            row[slot] = _product(tables.affine[m, place_of_row], v, place[slot])
            row[slot] *= weight[place[slot]]
            series[m, e, slot, at.BY_NOISE] = abs(row[slot])
        factorial = 1.0
        for k in range(at.TERMS):
            for slot in range(count):
                series[m, e, slot, at.BY_RE + k] = row[slot].real / factorial
                series[m, e, slot, at.BY_IM + k] = -row[slot].imag / factorial
            _differentiate(tables.spectrum[m], nilpotent, row, rates, count)
            factorial *= k + 1.0
        for slot in range(count):
            series[m, e, slot, at.BY_SIZE] = abs(row[slot]) / factorial


@kernel
def fill_ladder(ladder, eigenvalues, spans, window, count):
    """Factors of the slots for steps of some lengths, a power of two apart.

    The longest step turns the fastest lasting motion by a few radians: that far a Taylor
    polynomial is of use.
    """
    fastest = 0.0
    for slot in range(count):
        if abs(eigenvalues[slot].real) * window <= LASTING:
            fastest = max(fastest, abs(eigenvalues[slot]))
    step = window
    while step * fastest > _LONGEST_TURN:
        step *= 0.5
    spans[at.RUNG] = step
    for rung in range(at.RUNGS):
        for slot in range(count):
            decay = math.exp(eigenvalues[slot].real * step)
            cos, sin = cos_sin(eigenvalues[slot].imag * step)
            ladder[rung, slot, at.RE] = decay * cos
            ladder[rung, slot, at.IM] = decay * sin
            ladder[rung, slot, at.SIZE] = decay
        step *= 0.5


@kernel
def _product(row, v, j):
    total = complex(0.0, 0.0)
    for i in range(row.size):
        total += row[i] * v[i, j]
    return total


@kernel
def _differentiate(eigenvalues, rest, row, rates, count):
    """row := row L with L the block-diagonal matrix of the slots; rates is scratch."""
    for b in range(count):
        rates[b] = row[b] * eigenvalues[b]
        for a in range(count):
            rates[b] += row[a] * rest[a, b]
    for b in range(count):
        row[b] = rates[b]
