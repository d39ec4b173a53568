"""All motions of a mode with their vectors: the slots and the conjugates left out of them.

`Tables` keeps what the loop reads: rows of the inverse of the vectors, and of the vectors
the rows of the states, doubled where a conjugate stands behind them. Here the rest is put
back: weights by the scalar product of a row and its vector, which is one; vectors on the
forcing coordinates, which depend on themselves alone, by inverting that part.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import set_identity, set_zero
from nonsmooth.engine.jit import allocating, kernel

__all__ = ["fill_full_slots"]


@allocating
def fill_full_slots(tables, m, twin, partner, v, v_inverse, generator):
    """Vectors of the full slots of mode m, their inverse, and the generator between them.

    shapes: twin, partner (N,) slot and full slot of the conjugate, outputs; v, v_inverse and
    generator (N, N) complex outputs, v by coordinates and full slots
    returns: the number of full slots
    """
    n, big_n = tables.sizes[0], tables.entry.shape[1]
    slots = tables.slots[m]
    count = slots[at.COUNT]
    _find_partners(tables, m, twin, partner)
    full = count
    for f in range(count):
        full += partner[f] != f
    set_zero(v)
    set_zero(generator)
    slaved = tables.wiring[m, 0, at.SLAVED]
    for f in range(full):
        a = twin[f]
        sign = 1.0 if f < count else -1.0
        weight = 1.0 if partner[f] == f else 0.5
        for i in range(big_n):
            entry = tables.entry[m, a, i]
            v_inverse[f, i] = complex(entry[at.WEIGHT_RE], sign * entry[at.WEIGHT_IM])
            if i < n and not (slaved >> i) & 1:
                value = tables.states[m, i, a] * weight
                v[i, f] = complex(value.real, sign * value.imag)
        for g in range(full):
            if (f < count) == (g < count):
                value = tables.nilpotent[m, a, twin[g]]
                generator[f, g] = complex(value.real, sign * value.imag)
        mean = tables.spectrum[m, a]
        generator[f, f] += complex(mean.real, sign * mean.imag)
    _invert_forcing(n, full, v_inverse, v)
    return full


@kernel
def _find_partners(tables, m, twin, partner):
    """Which slots stand for two: oscillations, and the clusters made of them."""
    slots = tables.slots[m]
    count = slots[at.COUNT]
    full = count
    for f in range(count):
        twin[f], partner[f] = f, f
    for f in range(slots[at.END_REAL], slots[at.END_DAMPED]):
        twin[full], partner[full], partner[f] = f, f, full
        full += 1
    for c in range(slots[at.N_CLUSTERS]):
        first = slots[at.CLUSTERS + 3 * c]
        end = first + slots[at.CLUSTERS + 3 * c + 1]
        if _weight(tables, m, first, end) > 1.5:
            for f in range(first, end):
                twin[full], partner[full], partner[f] = f, f, full
                full += 1


@kernel
def _weight(tables, m, first, end):
    """Weight of a cluster: that of any motion of states in it, one for powers of time."""
    n = tables.sizes[0]
    slaved = tables.wiring[m, 0, at.SLAVED]
    for a in range(first, end):
        if tables.reads[m, a] >= n:
            continue
        total = 0.0
        for i in range(n):
            if not (slaved >> i) & 1:
                entry, value = tables.entry[m, a, i], tables.states[m, i, a]
                total += entry[at.WEIGHT_RE] * value.real - entry[at.WEIGHT_IM] * value.imag
        return total
    return 1.0


@allocating
def _invert_forcing(n, full, v_inverse, v):
    """Rows of v for the forcing coordinates, from the slots that read nothing else."""
    size = v.shape[0] - n
    rows = 0
    work = v[n:, :size].copy()
    inverse = work.copy()
    slot = v_inverse[:size, 0].real.astype("int64")
    for f in range(full):
        reads_states = False
        for i in range(n):
            reads_states = reads_states or v_inverse[f, i] != 0.0
        if not reads_states and rows < size:
            slot[rows] = f
            for i in range(size):
                work[rows, i] = v_inverse[f, n + i]
            rows += 1
    set_identity(inverse)
    _solve(work, inverse)
    for f in range(size):
        for i in range(size):
            v[n + i, slot[f]] = inverse[i, f]


@kernel
def _solve(matrix, right):
    """right := matrix^-1 right by elimination with the largest pivots; matrix is spent."""
    size = matrix.shape[0]
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        for j in range(size):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        factor = 1.0 / matrix[k, k]
        for j in range(size):
            matrix[k, j] *= factor
            right[k, j] *= factor
        for i in range(size):
            factor = matrix[i, k]
            if i == k or factor == 0.0:
                continue
            for j in range(size):
                matrix[i, j] -= factor * matrix[k, j]
                right[i, j] -= factor * right[k, j]
