"""What parameters add within a bundle: the Taylor series of a motion with its derivatives.

Members w of a bundle with mean eigenvalue mu move as w' = (mu + N) w, their derivatives as
zeta' = (mu + N) zeta + R w. With exp(mu s) taken out, the terms of both series follow from
the ones before; N is nilpotent but for the spread of the eigenvalues, so the series ends,
or converges at once for steps over which the members part by little.
"""

from __future__ import annotations

import math

from nonsmooth.engine.jit import kernel
from nonsmooth.engine.trigonometry import cos_sin
from nonsmooth.engine.variation_tables import BUNDLES, N_BUNDLES

__all__ = ["force_bundles"]

_NEGLIGIBLE = 1e-18  # next term of a series, beside the largest
_GONE = -745.0  # exponent of a decay below the range of numbers


@kernel
def force_bundles(
    bundles, means, spreads, rest, couplings, m, s, start, sums, terms, spare, forced
):
    """Fill the part that parameters add to the slots of all bundles of mode m after time s.

    shapes: the first four are those of the mode in Rates, couplings of all modes; start,
    sums, terms, spare and the output forced (P, N) are those of Columns
    """
    big_n = start.size
    for b in range(bundles[N_BUNDLES]):
        first = BUNDLES + big_n + bundles[BUNDLES + 2 * b]
        size = bundles[BUNDLES + 2 * b + 1]
        for a in range(size):
            f = bundles[first + a]
            twin = bundles[BUNDLES + 2 * big_n + f]
            value = start[twin]
            sums[0, a] = value if twin == f else value.conjugate()
            for p in range(forced.shape[0]):
                sums[1 + p, a] = 0.0
        mean, spread = means[b], spreads[b]
        if (mean.real + spread) * s < _GONE:
            for a in range(size):
                for p in range(forced.shape[0]):
                    sums[1 + p, a] = 0.0
        else:
            steps = math.ceil(max(1.0, spread * s))
            h = s / steps
            decay = math.exp(mean.real * h)
            cos, sin = cos_sin(mean.imag * h)
            factor = complex(decay * cos, decay * sin)
            for _ in range(steps):
                _step(bundles, rest, couplings, m, first, size, h, spread * h, sums, terms, spare)
                for k in range(sums.shape[0]):
                    for a in range(size):
                        sums[k, a] *= factor
        for a in range(size):
            f = bundles[first + a]
            if bundles[BUNDLES + 2 * big_n + f] == f:
                for p in range(forced.shape[0]):
                    forced[p, f] = sums[1 + p, a]


@kernel
def _step(bundles, rest, couplings, m, first, size, h, angle, sums, terms, spare):
    """One step of the series, without the common factor; the angle is spread times h."""
    for k in range(sums.shape[0]):
        for a in range(size):
            terms[k, a] = sums[k, a]
    chain = 2 * size  # motion and derivatives form a chain of at most this length
    degree, bound = 0, 1.0
    while degree < chain - 1 or bound > _NEGLIGIBLE:
        degree += 1
        if degree >= chain:
            beyond = degree - chain + 1.0
            bound *= angle * degree / (beyond * beyond)
        for k in range(sums.shape[0] - 1, -1, -1):  # the motion last: all need its old term
            for a in range(size):
                f = bundles[first + a]
                total = complex(0.0, 0.0)
                for b in range(size):
                    g = bundles[first + b]
                    total += rest[f, g] * terms[k, b]
                    if k > 0:
                        total += couplings[k - 1, m, f, g] * terms[0, b]
                spare[a] = total * (h / degree)
            for a in range(size):
                terms[k, a] = spare[a]
                sums[k, a] += spare[a]
