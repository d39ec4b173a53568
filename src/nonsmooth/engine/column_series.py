"""Columns of derivatives along a step of a Taylor mode.

The step is as long as the series of the motion allow. A direction that the motion no longer
follows, such as one that has relaxed, may be much faster: the series of its column then fails
within the step, which is passed in pieces, while the motion stays as it is.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.dual_series import fill_duals
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["carry_by_series"]

_SHORTEST = 2.0**-20  # part of a step; shorter pieces are no help
_CONVERGED = 2.0**-32  # last term beside the largest; those left out are a seventh of it


@inlined
def carry_by_series(tables, rates, segment, tangent, m, s):
    """Columns after s of the present step, into tangent.now; s may be negative."""
    n, count, dual = tables.sizes[0], tangent.columns.shape[0], tangent.dual
    series, columns = segment.series, tangent.columns
    way, whole = (1.0, s) if s >= 0.0 else (-1.0, -s)
    passed, length = 0.0, whole
    while True:
        if tangent.ready[0] == 0:
            for i in range(columns.shape[1]):
                for c in range(count):
                    dual[i, c // at.LANES, 0, c % at.LANES] = columns[c, i]
            fill_duals(
                tables.code, tables.terms, tables.weights, tables.code_rows[m, 0],
                tables.code_rows[m, 1], tables.values, rates.slot_rates, n,
                tables.outlets[m], at.explicit(tables.wiring, m), tables.sizes, tables.harmonics,
                rates.harmonics, series, dual, 0, at.ORDER, dual.shape[1],
            )  # fmt: skip
            tangent.ready[0] = 1
        while length > _SHORTEST * whole and not _converge(n, count, dual, length):
            length *= 0.5
        if passed + length >= whole:
            _evaluate(n, dual, way * (whole - passed), tangent.now)
            break
        series, columns = tangent.series, tangent.piece
        _evaluate(columns.shape[1], dual, way * length, columns)
        passed += length
        _fill_piece(tables, segment.series, m, way * passed, series)
        tangent.ready[0] = 0
        length = min(2.0 * length, whole - passed)
    if passed > 0.0:
        tangent.ready[0] = 0  # the series are those of the last piece


@kernel
def _fill_piece(tables, whole, m, passed, series):
    """Series of the motion from a point of the step on."""
    for i in range(tables.generator.shape[1]):
        total = whole[i, at.ORDER]
        for k in range(at.ORDER - 1, -1, -1):
            total = total * passed + whole[i, k]
        series[i, 0] = total
    fill_series(
        tables.code, tables.terms, tables.weights, tables.code_rows[m, 0], tables.code_rows[m, 1],
        tables.values, tables.outlets[m], at.explicit(tables.wiring, m), tables.sizes,
        tables.harmonics, series, 0, at.ORDER,
    )  # fmt: skip


@kernel
def _converge(n, count, dual, s):
    """Whether the series of all columns end in nothing after s."""
    to_last = s ** (at.ORDER - 1)
    for c in range(count):
        block, lane = c // at.LANES, c % at.LANES
        for i in range(n):
            last = abs(dual[i, block, at.ORDER, lane]) * s
            last = max(last, abs(dual[i, block, at.ORDER - 1, lane])) * to_last
            leading = abs(dual[i, block, 3, lane]) * s
            leading = max(leading, abs(dual[i, block, 2, lane])) * s
            leading = max(leading, abs(dual[i, block, 1, lane])) * s
            leading = max(leading, abs(dual[i, block, 0, lane]))
            if last > _CONVERGED * leading and last > _CONVERGED * _largest(
                dual[i, block], lane, s
            ):
                return False
    return True


@kernel
def _largest(series, lane, s):
    """Largest term of a series after s.

    shapes: series (ORDER + 1, LANES)
    """
    largest, power = 0.0, 1.0
    for k in range(at.ORDER):
        largest = max(largest, abs(series[k, lane]) * power)
        power *= s
    return largest


@kernel
def _evaluate(count, dual, s, columns):
    """Entries of the columns after s.

    shapes: columns (C, count or more)
    """
    for c in range(columns.shape[0]):
        block, lane = c // at.LANES, c % at.LANES
        for i in range(count):
            total = dual[i, block, at.ORDER, lane]
            for k in range(at.ORDER - 1, -1, -1):
                total = total * s + dual[i, block, k, lane]
            columns[c, i] = total
