"""Bundles: full slots with eigenvalues too close to eliminate what a parameter couples.

Wider than clusters, for two reasons. Motions that have nothing to do with each other may be
coupled by the derivative alone, as two equal oscillators are. And eliminating across a gap
loses digits once more than the motion itself has lost, where the time is shorter than the gap
takes to be felt: over a short part of its period, slow forcing is a constant.
"""

from __future__ import annotations

from nonsmooth.engine.jit import kernel
from nonsmooth.engine.variation_tables import BUNDLES, N_BUNDLES

__all__ = ["fill_bundles", "group_slots"]

_LITTLE = 0.25  # radians or exponent of a gap over a time: nothing to be told apart by


@kernel
def group_slots(full, partner, generator, horizon, label):
    """Group full slots that are close over a time; groups of longer times stay together.

    shapes: partner and generator as from `fill_full_slots`; label (N,), equal
    within a bundle, changed in place
    returns: whether any have been joined
    """
    joined = False
    for f in range(full):
        for g in range(f):
            if label[f] == label[g]:
                continue
            coupled = generator[f, g] != 0.0 or generator[g, f] != 0.0
            if coupled or abs(generator[f, f] - generator[g, g]) * horizon <= _LITTLE:
                _merge(label, full, f, g)
                _merge(label, full, partner[f], partner[g])
                joined = True
    return joined


@kernel
def fill_bundles(full, count, twin, generator, label, bundles, rest, means, spreads):
    """List the bundles of a frame with their means, spreads and rests.

    shapes: twin, generator, label as above, count the slots without conjugates; the outputs
    are those of one frame and mode in `Rates`
    """
    big_n = label.size
    for f in range(full):
        bundles[BUNDLES + 2 * big_n + f] = twin[f]
    _list_bundles(bundles, label, full, count, big_n)
    _fill_rests(bundles, rest, means, spreads, full, generator, label)


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
def _fill_rests(bundles, rest, means, spreads, full, generator, label):
    """Mean eigenvalue of each bundle, and what its members have beyond it."""
    big_n = label.size
    for f in range(full):
        for g in range(full):
            same = label[f] == label[g]
            rest[f, g] = generator[f, g] if same else complex(0.0, 0.0)
    for b in range(bundles[N_BUNDLES]):
        first = BUNDLES + big_n + bundles[BUNDLES + 2 * b]
        size = bundles[BUNDLES + 2 * b + 1]
        mean = complex(0.0, 0.0)
        for a in range(size):
            mean += generator[bundles[first + a], bundles[first + a]]
        mean /= size
        means[b], spreads[b] = mean, 0.0
        for a in range(size):
            f = bundles[first + a]
            rest[f, f] -= mean
            spreads[b] = max(spreads[b], abs(rest[f, f]))
