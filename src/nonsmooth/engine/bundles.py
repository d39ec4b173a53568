"""Bundles: full slots with eigenvalues too close to eliminate what a parameter couples.

Wider than clusters, for two reasons. Motions that have nothing to do with each other may be
coupled by the derivative alone, as two equal oscillators are. And eliminating across a gap
loses digits once more than the motion itself has lost.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.variation_tables import BUNDLES, N_BUNDLES

__all__ = ["fill_bundles"]

_LITTLE = 0.1  # radians or exponent of a gap over a segment: nothing to be told apart by
_NEAR = 0.01  # the same for decays, over their own time
_MOST_LOSS = 1e4  # of digits, as a factor, by eliminating across a gap ...
_WIDEST = 0.3  # ... smaller than this part of the eigenvalues


@kernel
def fill_bundles(tables, rates, m, full, twin, partner, v, v_inverse, generator, label, condition):
    """Group the full slots of mode m and fill their means, spreads and rests.

    shapes: as from `fill_full_slots`; label (N,) output, equal within a bundle;
    condition (N,) scratch
    """
    horizon = min(at.WINDOWS * tables.clock[0], tables.spans[m, at.LONGEST])
    for f in range(full):
        label[f], condition[f] = f, 0.0
        for i in range(v.shape[0]):
            condition[f] += abs(v_inverse[f, i]) * abs(v[i, f])
    for f in range(full):
        for g in range(f):
            loss = condition[f] * condition[g]
            coupled = generator[f, g] != 0.0 or generator[g, f] != 0.0
            if coupled or _near(generator[f, f], generator[g, g], horizon, loss):
                _merge(label, full, f, g)
                _merge(label, full, partner[f], partner[g])
    bundles = rates.bundles[m]
    big_n = label.size
    for f in range(full):
        bundles[BUNDLES + 2 * big_n + f] = twin[f]
    _list_bundles(bundles, label, full, tables.slots[m, at.COUNT], big_n)
    _fill_rests(rates, m, full, generator, label)


@kernel
def _near(one, other, horizon, loss):
    """Whether two eigenvalues belong together."""
    gap = abs(one - other)
    decay = max(0.0, min(-one.real, -other.real))
    if gap * horizon <= _LITTLE or gap <= _NEAR * decay:
        return True
    size = max(abs(one), abs(other))
    return gap <= _WIDEST * size and loss * size > _MOST_LOSS * gap


@kernel
def _merge(label, full, f, g):
    keep, drop = label[f], label[g]
    for h in range(full):
        if label[h] == drop:
            label[h] = keep


@kernel
def _list_bundles(bundles, label, full, count, big_n):
    """Bundles of two and more with a slot among them."""
    n_bundles, filled = 0, 0
    for f in range(count):
        first, size = True, 0
        for g in range(full):
            if label[g] == label[f]:
                size += 1
                first = first and g >= f
        if not first or size == 1:
            continue
        bundles[BUNDLES + 2 * n_bundles] = filled
        bundles[BUNDLES + 2 * n_bundles + 1] = size
        for g in range(full):
            if label[g] == label[f]:
                bundles[BUNDLES + big_n + filled] = g
                filled += 1
        n_bundles += 1
    bundles[N_BUNDLES] = n_bundles


@kernel
def _fill_rests(rates, m, full, generator, label):
    """Mean eigenvalue of each bundle, and what its members have beyond it."""
    big_n = label.size
    bundles = rates.bundles[m]
    for f in range(full):
        for g in range(full):
            same = label[f] == label[g]
            rates.rest[m, f, g] = generator[f, g] if same else complex(0.0, 0.0)
    for b in range(bundles[N_BUNDLES]):
        first = BUNDLES + big_n + bundles[BUNDLES + 2 * b]
        size = bundles[BUNDLES + 2 * b + 1]
        mean = complex(0.0, 0.0)
        for a in range(size):
            mean += generator[bundles[first + a], bundles[first + a]]
        mean /= size
        rates.means[m, b], rates.spreads[m, b] = mean, 0.0
        for a in range(size):
            f = bundles[first + a]
            rates.rest[m, f, f] -= mean
            rates.spreads[m, b] = max(rates.spreads[m, b], abs(rates.rest[m, f, f]))
