"""All motions of a mode with their vectors: the slots and the conjugates left out of them.

`Tables` keeps what the loop reads: rows of the inverse of the vectors, and of the vectors
the rows of the states, doubled where a conjugate stands behind them. Here the rest is put
back: weights by the scalar product of a row and its vector, which is one; vectors on the
forcing coordinates, which depend on nothing else, by inverting that part.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import set_zero
from nonsmooth.engine.jit import kernel

__all__ = ["fill_full_slots"]


@kernel
def fill_full_slots(tables, m, twin, partner, v, v_inverse, generator):
    """Vectors of the full slots of mode m, their inverse, and the generator between them.

    shapes: twin, partner (N,) slot and full slot of the conjugate, outputs; v, v_inverse and
    generator (N, N) complex outputs, v by coordinates and full slots
    returns: the number of full slots
    """
    n, big_n = tables.sizes[0], tables.entry.shape[1]
    count = tables.slots[m, at.COUNT]
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
            im = tables.entry[m, a, i, at.WEIGHT_IM]
            v_inverse[f, i] = complex(tables.entry[m, a, i, at.WEIGHT_RE], sign * im)
            if i < n and not (slaved >> i) & 1:
                value = tables.states[m, i, a] * weight
                v[i, f] = complex(value.real, sign * value.imag)
        for g in range(full):
            if (f < count) == (g < count):
                value = tables.nilpotent[m, a, twin[g]]
                generator[f, g] = complex(value.real, sign * value.imag)
        mean = tables.spectrum[m, a]
        generator[f, f] += complex(mean.real, sign * mean.imag)
    _invert_forcing(tables, m, full, twin, v_inverse, v)
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
                value = tables.states[m, i, a]
                total += tables.entry[m, a, i, at.WEIGHT_RE] * value.real
                total -= tables.entry[m, a, i, at.WEIGHT_IM] * value.imag
        return total
    return 1.0


@kernel
def _invert_forcing(tables, m, full, twin, v_inverse, v):
    """Rows of v for the forcing coordinates: powers of time by themselves, harmonics in pairs."""
    n, powers = tables.sizes[0], tables.sizes[1]
    reads, c = tables.reads, n + 1 + powers
    for f in range(full):
        for i in range(n, c):
            if reads[m, twin[f]] >= n and v_inverse[f, i] != 0.0:
                v[i, f] = 1.0 / v_inverse[f, i]
    while c < v.shape[0]:
        f, g = -1, -1
        for h in range(full):
            here = v_inverse[h, c] != 0.0 or v_inverse[h, c + 1] != 0.0
            if reads[m, twin[h]] >= n and here:
                f, g = g, h
        determinant = v_inverse[f, c] * v_inverse[g, c + 1] - v_inverse[f, c + 1] * v_inverse[g, c]
        v[c, f], v[c + 1, f] = v_inverse[g, c + 1] / determinant, -v_inverse[g, c] / determinant
        v[c, g], v[c + 1, g] = -v_inverse[f, c + 1] / determinant, v_inverse[f, c] / determinant
        c += 2
