"""From triangular to block-diagonal form: motions that do not influence each other.

Each coupling between different eigenvalues is eliminated (Bavely and Stewart 1979).
Eigenvalues too close to be told apart without loss stay together in a cluster; rigid-body
chains, critical damping and resonance are such clusters.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.arrays import copy_matrix, set_identity
from nonsmooth.engine.jit import allocating, kernel

__all__ = ["CLOSE", "decouple"]

# Eliminating across a relative gap loses -log10(gap) digits, and more for each neighbour in
# a chain of couplings. A cluster this narrow does not even shorten a window.
CLOSE = 3e-3
_NEIGHBOUR = 0.3  # beyond this relative gap nothing is lost to speak of
_CHAIN = 10.0  # a coupling so much larger than its gap makes a chain
_MOST_CUTS = 1e5  # of a window by a cluster that only its units may have made
_MOST_LOSS = 1000.0  # cancellation between motions from which on the closest are merged


@allocating
def decouple(n, t, v, v_inverse, block, label, horizon):
    """Block-diagonal form: couplings between different clusters eliminated.

    shapes: n states; t, v, v_inverse (N, N) complex, changed in place; label (N,) cluster of
    each coordinate, an output; block (N,) as from triangular_form; horizon is the time over
    which eigenvalues must be told apart
    """
    size = t.shape[0]
    triangular = np.empty((size, size), np.complex128)
    copy_matrix(t, triangular)
    rates = np.zeros((size, size))
    _fill_rates(n, t, v, block, horizon, rates)
    unit = np.zeros((size, size), np.complex128)
    unit_inverse = np.zeros((size, size), np.complex128)
    for i in range(size):
        label[i] = i
    while True:
        copy_matrix(triangular, t)
        set_identity(unit)
        set_identity(unit_inverse)
        first, second, near = _eliminate(t, unit, unit_inverse, label, rates)
        if first < 0 and near and _loss(triangular, unit, unit_inverse, rates) > _MOST_LOSS:
            first, second = _closest(t, unit, label, rates)
        if first < 0:
            break
        _merge(label, first, second)
        _merge(label, _conjugate_of(t, first, block), _conjugate_of(t, second, block))
    _multiply_right(v, unit)
    _multiply_left(unit_inverse, v_inverse)


@kernel
def _eliminate(t, unit, unit_inverse, label, rates):
    """Eliminate column by column; stop at a pair that must be merged.

    returns: the pair, or -1 and -1, and whether there were neighbours at all
    """
    n = t.shape[0]
    near = False
    for j in range(1, n):
        for i in range(j - 1, -1, -1):
            if label[i] == label[j] or t[i, j] == 0.0:
                continue
            gap = t[j, j] - t[i, i]
            separation = abs(gap) / rates[i, j]
            if separation <= CLOSE:
                return i, j, True
            near = near or separation <= _NEIGHBOUR
            x = t[i, j] / gap
            for k in range(i):
                t[k, j] += x * t[k, i]
            for k in range(j + 1, n):
                t[i, k] -= x * t[j, k]
            t[i, j] = 0.0
            for k in range(n):
                unit[k, j] += x * unit[k, i]
                unit_inverse[i, k] -= x * unit_inverse[j, k]
    return -1, -1, near


@kernel
def _fill_rates(n, t, v, block, horizon, rates):
    """Rate by which the gap between each two eigenvalues is measured.

    A coupling is a rate as well: eigenvalues much closer than it belong to a chain, such as
    a rigid body, which moves at that rate whatever their own size. Units decide how large a
    coupling is. Within a block they are balanced, unless a faster motion of the block has
    set them; between blocks of states a chain is assumed where that costs little; forcing
    has units of its own.
    """
    for i in range(t.shape[0]):
        rates[i, i] = max(abs(t[i, i]), 1.0 / horizon)
        for j in range(t.shape[0]):
            if i == j:
                continue
            coupling = abs(t[min(i, j), max(i, j)])
            gap = abs(t[i, i] - t[j, j])
            if coupling <= _CHAIN * gap:
                continue
            if block[i] == block[j]:
                chain = coupling > _fastest(t, block, i) / _CHAIN
            else:
                chain = max(abs(t[i, i]), abs(t[j, j])) <= coupling / _CHAIN
                chain = chain and gap * horizon <= _MOST_CUTS
                chain = chain and _is_state(n, v, i) and _is_state(n, v, j)
            if chain:
                rates[i, i] = max(rates[i, i], coupling)
    for i in range(t.shape[0]):
        for j in range(i + 1, t.shape[0]):
            rates[i, j] = max(rates[i, i], rates[j, j])
            if block[i] == block[j] and abs(t[i, j]) > _fastest(t, block, i) / _CHAIN:
                rates[i, j] = max(rates[i, j], abs(t[i, j]))


@kernel
def _fastest(t, block, i):
    """Largest eigenvalue of the block of coordinate i."""
    fastest = 0.0
    for k in range(t.shape[0]):
        if block[k] == block[i]:
            fastest = max(fastest, abs(t[k, k]))
    return fastest


@kernel
def _is_state(n, v, i):
    """Whether column i of a triangular form belongs to a block of states."""
    for k in range(n):
        if v[k, i] != 0.0:
            return True
    return False


@allocating
def _loss(triangular, unit, unit_inverse, rates):
    """How much larger the motions are than what they add up to, whatever the units.

    The largest of (|U| |U^-1|)_ij over Q_ij, the sum of products of couplings over rates
    along all paths from j to i: the size of the exponential at the time scale of the pair.
    """
    n = triangular.shape[0]
    step = np.zeros((n, n))
    power = np.zeros((n, n))
    paths = np.zeros((n, n))
    for i in range(n):
        power[i, i] = 1.0
        for j in range(i + 1, n):
            step[i, j] = abs(triangular[i, j]) / rates[i, j]
    for p in range(1, n):
        for i in range(n):
            for j in range(n - 1, i, -1):
                total = 0.0
                for k in range(i, j):
                    total += power[i, k] * step[k, j]
                power[i, j] = total / p
            power[i, i] = 0.0
        for i in range(n):
            for j in range(i + 1, n):
                paths[i, j] += power[i, j]
    worst = 0.0
    for i in range(n):
        for j in range(i + 1, n):
            total = 0.0
            for k in range(i, j + 1):
                total += abs(unit[i, k]) * abs(unit_inverse[k, j])
            if paths[i, j] > 0.0:
                worst = max(worst, total / paths[i, j])
    return worst


@kernel
def _closest(t, unit, label, rates):
    """The coupled pair of different clusters with the smallest relative gap, or -1, -1."""
    first, second = -1, -1
    smallest = 1e300
    for i in range(t.shape[0]):
        for j in range(i + 1, t.shape[0]):
            if label[i] != label[j] and unit[i, j] != 0.0:
                separation = abs(t[j, j] - t[i, i]) / rates[i, j]
                if separation < smallest:
                    first, second, smallest = i, j, separation
    return first, second


@kernel
def _merge(label, first, second):
    keep, drop = label[first], label[second]
    for i in range(label.size):
        if label[i] == drop:
            label[i] = keep


@kernel
def _conjugate_of(t, i, block):
    """Coordinate whose eigenvalue is the conjugate of that of i, within the same block."""
    best = i
    distance = abs(t[i, i].imag) * 2.0
    for j in range(t.shape[0]):
        if block[j] == block[i]:
            away = abs(t[j, j] - t[i, i].conjugate())
            if away < distance:
                best, distance = j, away
    return best


@kernel
def _multiply_right(a, b):
    """a := a b for upper triangular b with unit diagonal."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n - 1, -1, -1):
            total = a[i, j]
            for k in range(j):
                total += a[i, k] * b[k, j]
            a[i, j] = total


@kernel
def _multiply_left(a, b):
    """b := a b for upper triangular a with unit diagonal."""
    n = a.shape[0]
    for j in range(n):
        for i in range(n):
            total = b[i, j]
            for k in range(i + 1, n):
                total += a[i, k] * b[k, j]
            b[i, j] = total
