"""Taylor polynomial of a guard at the current point, and how far it is surely positive.

With the Taylor coefficients a_0 ... a_5 of a guard and a bound B of the size of the next
one from here on,

    g(s + u) >= a_0 + a_1 u + ... + a_5 u^5 - B u^6 .

The right-hand side is a polynomial, and on [0, h] it lies in the convex hull of its
Bernstein coefficients. Where all of them are positive no root lies in [0, h]; otherwise
none lies before the place where the hull reaches zero.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.quadratic_guards import read_products

__all__ = ["NEARLY_ZERO", "REMAINDER", "falls_alone", "read_guard", "safe_step"]

# The step tried first is so short that the bounded term is at most this part of the rest.
REMAINDER = 0.5
_MOST_HALVINGS = 200
NEARLY_ZERO = 1.5  # margins below which a guard counts as zero
# Fading motions take off up to this part of a guard; with the margin, which is at most two
# thirds of it, something must be left.
_MOST_TAKEN = 0.25
_MOST_LEFT_OUT = 4.0  # parts of a guard: what fades from below only helps, but is not seen


@inlined
def read_guard(tables, segment, m, g, order):
    """Taylor coefficients of a guard, bound of the next one, rounding margin, into scan.

    order is that of its known zero at the current point, 0 where there is none
    """
    if tables.products.shape[0] > 0 and tables.product_rows[m, g, 1] > 0:
        read_products(tables, segment, m, g, order)
        return
    slots, scan = tables.slots, segment.scan
    fading, lasting = slots[m, at.END_CONSTANT], slots[m, at.END_FADING]
    a0, a1, a2, a3, a4, a5, bound, margin = _sum_series(
        tables, segment, m, g, 0, fading, lasting, slots[m, at.COUNT]
    )
    scan[g, 0], scan[g, 1], scan[g, 2] = a0, a1, a2
    scan[g, 3], scan[g, 4], scan[g, 5] = a3, a4, a5
    scan[g, at.BOUND], scan[g, at.MARGIN] = bound, margin
    scan[g, at.TAKEN_OFF], scan[g, at.FADING] = 0.0, 0.0
    if lasting > fading:
        _add_fading(tables, segment, m, g, order, fading, lasting)


@inlined
def _add_fading(tables, segment, m, g, order, fading, lasting):
    """Add motions that fade within a fraction of any step, or take off what they may take.

    Where the guard has a zero of order r, the part of c exp(-u) beyond it is at least
    min(0, c_r u^r) with its coefficient c_r, because Taylor's polynomials of a decay lie on
    either side of it in turn. So only this coefficient counts, and a relaxation at a rate
    of 30,000 does not hold up the search. Where that would take too much, all is added.
    """
    scan = segment.scan
    b0, b1, b2, b3, b4, b5, more, doubt = _sum_series(
        tables, segment, m, g, fading, lasting, lasting, lasting
    )
    value, taken, size = 0.0, 0.0, 0.0
    for j in range(fading, lasting):
        term = tables.series[m, g, j, order] * segment.now[j, at.RE]
        term += tables.series[m, g, j, at.BY_IM + order] * segment.now[j, at.IM]
        value += term
        size += abs(term)
        if term > 0.0:
            taken += term
    scan[g, at.MARGIN] += doubt
    if order == 0 and taken == size and _nothing_lasts(scan[g]):
        scan[g, 0] = taken  # all that is there fades, and from above: it never reaches zero
        scan[g, at.MARGIN] = 0.0
        return
    total = scan[g, order] + value
    apart = taken <= _MOST_TAKEN * total and size <= _MOST_LEFT_OUT * total
    if apart and (order > 0 or total > NEARLY_ZERO * scan[g, at.MARGIN]):
        scan[g, order] = total
        scan[g, at.TAKEN_OFF], scan[g, at.FADING] = taken, size
    else:
        scan[g, 0], scan[g, 1], scan[g, 2] = scan[g, 0] + b0, scan[g, 1] + b1, scan[g, 2] + b2
        scan[g, 3], scan[g, 4], scan[g, 5] = scan[g, 3] + b3, scan[g, 4] + b4, scan[g, 5] + b5
        scan[g, at.BOUND] += more


@kernel
def _nothing_lasts(scan):
    """Whether a guard has no part but those that fade."""
    lasts = scan[at.BOUND]
    for k in range(at.TERMS):
        lasts += abs(scan[k])
    return lasts == 0.0


@inlined
def _sum_series(tables, segment, m, g, first, pause, resume, end):
    """Sums over the slots from first to end, without those from pause to resume."""
    series, now = tables.series, segment.now
    a0, a1, a2, a3, a4, a5, bound, margin = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(first, end - (resume - pause)):
        j = k if k < pause else k + (resume - pause)
        re, im = now[j, at.RE], now[j, at.IM]
        a0 += series[m, g, j, 0] * re + series[m, g, j, at.BY_IM] * im
        a1 += series[m, g, j, 1] * re + series[m, g, j, at.BY_IM + 1] * im
        a2 += series[m, g, j, 2] * re + series[m, g, j, at.BY_IM + 2] * im
        a3 += series[m, g, j, 3] * re + series[m, g, j, at.BY_IM + 3] * im
        a4 += series[m, g, j, 4] * re + series[m, g, j, at.BY_IM + 4] * im
        a5 += series[m, g, j, 5] * re + series[m, g, j, at.BY_IM + 5] * im
        bound += series[m, g, j, at.BY_SIZE] * now[j, at.SIZE]
        margin += series[m, g, j, at.BY_NOISE] * now[j, at.NOISE]
    return a0, a1, a2, a3, a4, a5, bound, margin


@inlined
def safe_step(a0, a1, a2, a3, a4, a5, bound, h):
    """Length up to which a_0 + ... + a_5 u^5 - bound u^6 is surely positive, at most h.

    a_0 is positive
    """
    h2 = h * h
    h4 = h2 * h2
    a1, a2, a3, a4, a5 = a1 * h, a2 * h2, a3 * h2 * h, a4 * h4, a5 * h4 * h
    last = bound * (h4 * h2)
    safe = 0.0
    for _ in range(_MOST_HALVINGS):
        if last <= REMAINDER * (a0 + abs(a1) + abs(a2)):
            # rise of the Bernstein coefficients above a_0
            b1 = a1 * (1 / 6)
            b2 = a1 * (1 / 3) + a2 * (1 / 15)
            b3 = a1 * (1 / 2) + a2 * (1 / 5) + a3 * (1 / 20)
            b4 = a1 * (2 / 3) + a2 * (2 / 5) + a3 * (1 / 5) + a4 * (1 / 15)
            b5 = a1 * (5 / 6) + a2 * (2 / 3) + a3 * (1 / 2) + a4 * (1 / 3) + a5 * (1 / 6)
            b6 = a1 + a2 + a3 + a4 + a5 - last
            if a0 + min(min(min(b1, b2), min(b3, b4)), min(b5, b6)) > 0.0:
                return h
            # the hull falls from (0, a_0) along its steepest chord
            steepest = min(min(min(6.0 * b1, 3.0 * b2), min(2.0 * b3, 1.5 * b4)), min(1.2 * b5, b6))
            safe = max(safe, -a0 / steepest * h)
        h *= 0.5
        if h <= safe:
            break
        a1, a2, a3, a4, a5 = 0.5 * a1, 0.25 * a2, 0.125 * a3, 0.0625 * a4, 0.03125 * a5
        last *= 0.015625
    return safe


@inlined
def falls_alone(a1, a2, a3, a4, a5, bound, u):
    """Whether the rate of a guard stays below half of itself on [0, u], given a_1 < 0."""
    change = 6.0 * bound * u + 5.0 * abs(a5)
    change = change * u + 4.0 * abs(a4)
    change = change * u + 3.0 * abs(a3)
    change = change * u + 2.0 * abs(a2)
    return change * u <= -0.5 * a1
