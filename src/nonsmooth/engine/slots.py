"""Modal slots of a mode: one per natural motion, sorted by kind for the inner loop.

Of each pair of conjugate motions one is kept with double weight, so that every guard and
state is the real part of a weighted sum of slots.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import allocating, kernel
from nonsmooth.engine.trigonometry import cos_sin

__all__ = ["fill_slots"]

_CONSTANT, _FADING, _REAL, _ROTATION, _DAMPED, _CLUSTER, _DROPPED = 0, 1, 2, 3, 4, 5, 9
_UNIT = 2.220446049250313e-16
_SPREAD = 1.0  # largest spread of a cluster times the length of its segments
_MOST_GROWTH = 32.0  # exponent of a growing motion over one segment
_LASTING = 64.0  # exponent of a decay over a window that leaves a motion worth its look
_LONGEST_TURN = 4.0  # radians of the longest step of the ladder


@allocating
def fill_slots(tables, m, t, v, v_inverse, label, block, norm, doubt):
    """Sort the decoupled motions of mode m into slots and fill its modal sheets.

    shapes: t, v, v_inverse (N, N) complex as from decouple; label, block, norm
    (N,); doubt (N,) error of each eigenvalue in units of rounding
    """
    big_n = t.shape[0]
    kind = np.zeros(big_n, np.int64)
    weight = np.ones(big_n)
    place = np.zeros(big_n, np.int64)
    _classify(tables.wiring[m, 0, at.SLAVED], tables.clock[0], t, v, label, block, norm, kind, weight)
    eigenvalues, rest = tables.spectrum[m], tables.nilpotent[m]
    slots, spans = tables.slots[m], tables.spans[m]
    count = _place_simple(slots, kind, place)
    spans[at.LONGEST] = 1e300
    n_clusters = 0
    for j in range(big_n):
        if kind[j] == _CLUSTER and _is_first(label, j):
            first = count
            for i in range(j, big_n):
                if label[i] == label[j]:
                    place[count] = i
                    count += 1
            cluster = slots[at.CLUSTERS + 3 * n_clusters : at.CLUSTERS + 3 * n_clusters + 3]
            _fill_cluster(eigenvalues, rest, spans, cluster, tables.clock[0], t, place, first, count)
            n_clusters += 1
    slots[at.COUNT] = count
    slots[at.N_CLUSTERS] = n_clusters
    length = min(tables.clock[0], spans[at.LONGEST])
    worst = _fill_spectrum(eigenvalues, t, block, doubt, kind, place, count, length)
    _limit_growth(eigenvalues, spans, count)
    _fill_ladder(tables.ladder[m], eigenvalues, spans, tables.clock[0], count)
    spans[at.FASTEST] = 0.0
    for slot in range(count):
        spans[at.FASTEST] = max(spans[at.FASTEST], abs(eigenvalues[slot]))
    # rounding of the sums, and of eigenvalues over the time that they act; wide enough for
    # what a state inherits from some tens of earlier segments
    spans[at.ROUNDING] = _UNIT * (32.0 + 2.0 * worst)
    _fill_weights(tables, m, v, v_inverse, weight, place, count)
    _fill_series(tables, m, v, weight, place, count)


@kernel
def _place_simple(slots, kind, place):
    count = 0
    for wanted in range(_CLUSTER):
        for j in range(kind.size):
            if kind[j] == wanted:
                place[count] = j
                count += 1
        slots[at.END_CONSTANT + wanted] = count
    return count


@kernel
def _is_first(label, j):
    for i in range(j):
        if label[i] == label[j]:
            return False
    return True


@kernel
def _classify(slaved, window, t, v, label, block, norm, kind, weight):
    """Kind of each motion; conjugate partners are dropped, slaved coordinates are inert."""
    big_n = t.shape[0]
    for j in range(big_n):
        mean = complex(0.0, 0.0)
        members = 0
        largest = 0.0
        for i in range(big_n):
            if label[i] == label[j]:
                mean += t[i, i]
                members += 1
                largest = max(largest, norm[i])
        mean /= members
        margin = 1e-12 * largest  # far above rounding, far below an honest frequency
        paired = abs(mean.imag) > margin if members > 1 else _has_partner(t, block, j)
        if paired and mean.imag < 0.0:
            kind[j] = _DROPPED
            continue
        weight[j] = 2.0 if paired else 1.0
        if members > 1:
            kind[j] = _CLUSTER
        elif paired:
            kind[j] = _ROTATION if abs(mean.real) <= 4.0 * _UNIT * largest else _DAMPED
        else:
            kind[j] = _CONSTANT if mean.real == 0.0 else _REAL
            if -mean.real * window > _LASTING:
                kind[j] = _FADING
        if kind[j] == _CONSTANT and _only_slaved(slaved, v, j):
            kind[j] = _DROPPED


@kernel
def _has_partner(t, block, j):
    """Whether a simple eigenvalue has a conjugate; a real one may carry a rounded phase."""
    for i in range(block.size):
        if i != j and block[i] == block[j]:
            if abs(t[i, i] - t[j, j].conjugate()) < 0.5 * abs(t[j, j].imag):
                return True
    return False


@kernel
def _only_slaved(slaved, v, j):
    for i in range(v.shape[0]):
        if v[i, j] != 0.0 and not (slaved >> i) & 1:
            return False
    return True


@kernel
def _fill_cluster(eigenvalues, rest, spans, cluster, window, t, place, first, end):
    """Mean eigenvalue, nilpotent rest, degree and admissible length of one cluster."""
    size = end - first
    mean = complex(0.0, 0.0)
    for a in range(first, end):
        mean += t[place[a], place[a]]
    mean /= size
    spread = 0.0
    for a in range(first, end):
        spread = max(spread, abs(t[place[a], place[a]] - mean))
        eigenvalues[a] = mean
        for b in range(first, end):
            rest[a, b] = t[place[a], place[b]]
        rest[a, a] -= mean
    length = window
    if spread > 0.0:
        length = min(length, _SPREAD / spread)
        spans[at.LONGEST] = min(spans[at.LONGEST], length)
    # terms beyond the exact chain shrink like (spread * length)^k / k!
    degree = size - 1
    term = 1.0
    while spread > 0.0 and term > 1e-18 and degree < at.MAX_DEGREE:
        degree += 1
        term *= spread * length * (degree / (degree - size + 1.0)) / (degree - size + 1.0)
    cluster[0], cluster[1], cluster[2] = first, size, degree


@kernel
def _fill_spectrum(eigenvalues, t, block, doubt, kind, place, count, length):
    """Eigenvalues of the simple slots; returns the largest phase error in units of rounding."""
    fastest = 0.0
    for slot in range(count):
        j = place[slot]
        if kind[j] == _CONSTANT:
            eigenvalues[slot] = 0.0
        elif kind[j] in (_FADING, _REAL):
            eigenvalues[slot] = t[j, j].real
        elif kind[j] == _ROTATION:
            eigenvalues[slot] = complex(0.0, t[j, j].imag)
        elif kind[j] == _DAMPED:
            eigenvalues[slot] = t[j, j]
        fastest = max(fastest, _phase_error(eigenvalues[slot], block, doubt, j, length))
    return fastest


@kernel
def _limit_growth(eigenvalues, spans, count):
    """Look ahead and segments stay short enough for growing motions to be bounded well."""
    growth = 0.0
    for slot in range(count):
        growth = max(growth, eigenvalues[slot].real)
    spans[at.REACH] = 1e300
    if growth > 0.0:
        spans[at.REACH] = 1.0 / growth
        spans[at.LONGEST] = min(spans[at.LONGEST], _MOST_GROWTH / growth)


@kernel
def _phase_error(eigenvalue, block, doubt, j, length):
    """Relative error of exp(eigenvalue s) over a segment, in units of rounding.

    Decayed motions do not count. Eigenvalues of blocks larger than two come out of an
    iteration and carry errors of the size of the whole block.
    """
    acting = length
    if eigenvalue.real < 0.0:
        acting = min(length, -1.0 / eigenvalue.real)
    members = 0
    for i in range(block.size):
        members += block[i] == block[j]
    return acting * (doubt[j] if members > 2 else abs(eigenvalue))


@kernel
def _fill_weights(tables, m, v, v_inverse, weight, place, count):
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
def _fill_series(tables, m, v, weight, place, count):
    """Weights of the slots in the Taylor coefficients of every guard."""
    series, nilpotent = tables.series, tables.nilpotent[m]
    row = np.zeros(v.shape[0], np.complex128)
    rates = np.zeros(v.shape[0], np.complex128)
    for e in range(tables.wiring[m, 0, at.N_EXITS]):
        for slot in range(count):
            row[slot] = _product(tables.affine[m, at.guard_row(e, 0)], v, place[slot])
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
def _fill_ladder(ladder, eigenvalues, spans, window, count):
    """Factors of the slots for steps of some lengths, a power of two apart.

    The longest step turns the fastest lasting motion by a few radians: that far a Taylor
    polynomial is of use.
    """
    fastest = 0.0
    for slot in range(count):
        rate = eigenvalues[slot]
        fastest = max(fastest, abs(rate.imag))
        if abs(rate.real) * window <= _LASTING:
            fastest = max(fastest, abs(rate.real))
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
