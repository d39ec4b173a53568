"""Bundles: full slots with eigenvalues too close to eliminate what a parameter couples.

Wider than clusters, for two reasons. Motions that have nothing to do with each other may be
coupled by the derivative alone, as two equal oscillators are. And eliminating across a gap
loses digits once more than the motion itself has lost.
"""

from __future__ import annotations

from nonsmooth.engine.jit import kernel
from nonsmooth.engine.variation_tables import BUNDLES, N_BUNDLES

__all__ = ["fill_bundles", "group_slots", "measure_slots"]

_LITTLE = 0.25  # radians or exponent of a gap over a segment: nothing to be told apart by
_NEAR = 0.01  # the same for decays, over their own time
_MOST_LOSS = 1e4  # of digits, as a factor, by eliminating across a gap ...
_WIDEST = 0.3  # ... smaller than this part of the eigenvalues


@kernel
def measure_slots(full, v, v_inverse, condition):
    """Condition of each full slot: how much larger its parts are than what they add up to.

    shapes: v, v_inverse (N, N) as from `fill_full_slots`, condition (N,) output
    """
    for f in range(full):
        condition[f] = 0.0
        for i in range(v.shape[0]):
            condition[f] += abs(v_inverse[f, i]) * abs(v[i, f])


@kernel
def group_slots(full, partner, generator, condition, horizon, label):
    """Group full slots that are close over a time; groups of longer times stay together.

    shapes: partner and generator as from `fill_full_slots`, condition (N,); label (N,),
    equal within a bundle, changed in place
    returns: whether any have been joined
    """
    joined = False
    for f in range(full):
        for g in range(f):
            if label[f] == label[g]:
                continue
            loss = condition[f] * condition[g]
            coupled = generator[f, g] != 0.0 or generator[g, f] != 0.0
            if coupled or _near(generator[f, f], generator[g, g], horizon, loss):
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
