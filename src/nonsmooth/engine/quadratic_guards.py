"""Taylor polynomials of guards that are quadratic in what a linear mode moves.

Such a guard is a linear part and products of two factors, which are linear too: each is a sum
over the slots, as linear guards are. Where f and g have the coefficients f_k and g_k from here on,
bounded by F_k and G_k for all time to come, their product has the coefficients
f_0 g_k + ... + f_k g_0, and the next one is at most F_0 G_6 + ... + F_6 G_0.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.jit import inlined, kernel

__all__ = ["read_products"]

_UNIT = 8.0 * 2.220446049250313e-16  # of the product and of the sum
_MOST_TAKEN = 0.25  # as for linear guards


@kernel
def read_products(tables, segment, m, g, order):
    """Taylor coefficients of a guard with products, bound and margin, into scan."""
    factors, scan = segment.factors, segment.scan[g]
    n_exits = tables.sizes[5]
    whole = factors[factors.shape[0] - 1]  # the linear part, to which the products are added
    _read_factor(tables, segment, m, g, whole)
    bound = whole[at.LASTING + at.TERMS]
    faded, margin = whole[at.FADED + at.TERMS], whole[at.DOUBT]
    share = whole[at.FADED]  # of what fades in the guard, at most
    first, last = tables.product_rows[m, g, 0], tables.product_rows[m, g, 1]
    for k in range(first, last):
        for factor in tables.products[k]:
            _read_factor(tables, segment, m, n_exits + factor, factors[factor])
    for k in range(first, last):
        f, h = factors[tables.products[k, 0]], factors[tables.products[k, 1]]
        for i in range(at.TERMS):
            for j in range(at.TERMS - i):
                lasting = f[at.LASTS_IN + i] * h[at.LASTS_IN + j]
                whole[at.LASTS_IN + i + j] += lasting
                both = (f[at.LASTS_IN + i] + f[at.FADES_IN + i]) * (
                    h[at.LASTS_IN + j] + h[at.FADES_IN + j]
                )
                whole[at.FADES_IN + i + j] += both - lasting
        for i in range(at.TERMS + 1):
            j = at.TERMS - i
            lasting = f[at.LASTING + i] * h[at.LASTING + j]
            bound += lasting
            faded += (f[at.LASTING + i] + f[at.FADED + i]) * (
                h[at.LASTING + j] + h[at.FADED + j]
            ) - lasting
        size_f, size_h = f[at.LASTING] + f[at.FADED], h[at.LASTING] + h[at.FADED]
        share += size_f * size_h - f[at.LASTING] * h[at.LASTING]
        margin += _doubt(f, h, 0) + _UNIT * abs(_whole(f, 0) * _whole(h, 0))
        bound += f[at.LASTING + at.TERMS] * h[at.DOUBT] + h[at.LASTING + at.TERMS] * f[at.DOUBT]
    total = whole[at.LASTS_IN] + whole[at.FADES_IN]
    taken = share + whole[at.FADES_IN]
    # what fades may go altogether, but it is zero by its own account only where it is known
    apart = order == 0 and 0.0 < taken <= _MOST_TAKEN * total
    for k in range(at.TERMS):
        scan[k] = whole[at.LASTS_IN + k]
        if not apart:
            scan[k] += whole[at.FADES_IN + k]
    if order == 0:
        # what rounding may be off by grows with the factors on the way: not the margin of now
        for k in range(first, last):
            f, h = factors[tables.products[k, 0]], factors[tables.products[k, 1]]
            for i in range(1, at.TERMS):
                scan[i] -= _doubt(f, h, i)
    scan[at.BOUND] = bound if apart else bound + faded
    scan[at.MARGIN] = margin
    scan[at.TAKEN_OFF], scan[at.FADING] = 0.0, 0.0
    if apart:
        scan[0] = total
        scan[at.TAKEN_OFF], scan[at.FADING] = taken, share


@inlined
def _whole(factor, k):
    """Coefficient of a factor, what lasts and what fades together."""
    return factor[at.LASTS_IN + k] + factor[at.FADES_IN + k]


@inlined
def _doubt(f, h, k):
    """What the errors of two factors make of a coefficient of their product."""
    return (abs(_whole(f, k)) + f[at.DOUBT]) * h[at.DOUBT] + abs(_whole(h, k)) * f[at.DOUBT]


@kernel
def _read_factor(tables, segment, m, row, factor):
    """Coefficients of a sum over slots, what lasts and what fades apart, and their bounds.

    shapes: factor (FACTOR,) an output
    """
    slots, series, now = tables.slots, tables.series, segment.now
    fading, lasting = slots[m, at.END_CONSTANT], slots[m, at.END_FADING]
    for k in range(at.FACTOR):
        factor[k] = 0.0
    for j in range(slots[m, at.COUNT]):
        re, im, size = now[j, at.RE], now[j, at.IM], now[j, at.SIZE]
        value, bound = at.LASTS_IN, at.LASTING
        if fading <= j < lasting:
            value, bound = at.FADES_IN, at.FADED
        for k in range(at.TERMS):
            by_re, by_im = series[m, row, j, at.BY_RE + k], series[m, row, j, at.BY_IM + k]
            factor[value + k] += by_re * re + by_im * im
            factor[bound + k] += (abs(by_re) + abs(by_im)) * size
        factor[bound + at.TERMS] += series[m, row, j, at.BY_SIZE] * size
        factor[at.DOUBT] += series[m, row, j, at.BY_NOISE] * now[j, at.NOISE]
