"""Modal slots of a mode: one per natural motion, sorted by kind for the inner loop.

Of each pair of conjugate motions one is kept with double weight, so that every guard and
state is the real part of a weighted sum of slots.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import allocating, kernel
from nonsmooth.engine.weights import LASTING, fill_ladder, fill_series, fill_weights

__all__ = ["fill_slots"]

_CONSTANT, _FADING, _REAL, _ROTATION, _DAMPED, _CLUSTER, _DROPPED = 0, 1, 2, 3, 4, 5, 9
_UNIT = 2.220446049250313e-16
_SPREAD = 1.0  # largest spread of a cluster times the length of its segments
_MOST_RADIANS = 1024.0  # of the fastest oscillation in one segment
_MOST_GROWTH = 32.0  # exponent of a growing motion over one segment


@allocating
def fill_slots(tables, m, t, v, v_inverse, label, block, norm, doubt):
    """Sort the decoupled motions of mode m into slots and fill its tables.

    shapes: t, v, v_inverse (N, N) complex as from decouple; label, block, norm
    (N,); doubt (N,) error of each eigenvalue in units of rounding
    """
    big_n = t.shape[0]
    kind = np.zeros(big_n, np.int64)
    weight = np.ones(big_n)
    place = np.zeros(big_n, np.int64)
    window = tables.clock[0]
    slaved = tables.wiring[m, 0, at.SLAVED]
    _classify(slaved, window, t, v, label, block, norm, kind, weight)
    eigenvalues, rest = tables.spectrum[m], tables.nilpotent[m]
    slots, spans = tables.slots[m], tables.spans[m]
    count = _place_simple(slots, kind, place)
    spans[at.LONGEST] = _longest(t, window)
    n_clusters = 0
    for j in range(big_n):
        if kind[j] == _CLUSTER and _is_first(label, j):
            first = count
            for i in range(j, big_n):
                if label[i] == label[j]:
                    place[count] = i
                    count += 1
            cluster = slots[at.CLUSTERS + 3 * n_clusters : at.CLUSTERS + 3 * n_clusters + 3]
            longest = tables.clock[at.LASTS]
            _fill_cluster(eigenvalues, rest, spans, cluster, longest, t, place, first, count)
            n_clusters += 1
    slots[at.COUNT] = count
    slots[at.N_CLUSTERS] = n_clusters
    length = min(tables.clock[at.LASTS], spans[at.LONGEST])
    worst = _fill_spectrum(eigenvalues, t, block, doubt, kind, place, count, length)
    _limit_growth(eigenvalues, spans, count)
    fill_ladder(tables.ladder[m], eigenvalues, spans, window, count)
    spans[at.FASTEST] = 0.0
    for slot in range(count):
        spans[at.FASTEST] = max(spans[at.FASTEST], abs(eigenvalues[slot]))
    # rounding of the sums, and of eigenvalues over the time that they act; wide enough for
    # what a state inherits from some tens of earlier segments
    spans[at.ROUNDING] = _UNIT * (32.0 + 2.0 * worst)
    fill_weights(tables, m, v, v_inverse, weight, place, count)
    fill_series(tables, m, v, weight, place, count)


@kernel
def _longest(t, window):
    """Longest segment: long arguments lose digits, and a search has so many looks at most."""
    fastest = 0.0
    for i in range(t.shape[0]):
        if abs(t[i, i].real) * window <= LASTING:
            fastest = max(fastest, abs(t[i, i].imag))
    return _MOST_RADIANS / fastest if fastest > 0.0 else 1e300


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
            if -mean.real * window > LASTING:
                kind[j] = _FADING
        if kind[j] == _CONSTANT and _only_slaved(slaved, v, j):
            kind[j] = _DROPPED


@kernel
def _has_partner(t, block, j):
    """Whether a simple eigenvalue has a conjugate; a real one may carry a rounded phase."""
    for i in range(block.size):
        near = abs(t[i, i] - t[j, j].conjugate()) < 0.5 * abs(t[j, j].imag)
        if near and i != j and block[i] == block[j]:
            return True
    return False


@kernel
def _only_slaved(slaved, v, j):
    for i in range(v.shape[0]):
        if v[i, j] != 0.0 and not (slaved >> i) & 1:
            return False
    return True


@kernel
def _fill_cluster(eigenvalues, rest, spans, cluster, longest, t, place, first, end):
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
    length = longest
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
