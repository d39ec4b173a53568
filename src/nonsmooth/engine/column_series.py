"""Columns of derivatives along a step of a Taylor mode.

The step is as long as the series of the motion allow. A direction that the motion no longer
follows, such as one that has relaxed, may be much faster: the series of its column then fails
within the step, which is passed in pieces, while the motion stays as it is.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.dual_series import fill_duals
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["carry_by_series"]

_SHORTEST = 2.0**-20  # part of a step; shorter pieces are no help
_CONVERGED = 2.0**-40  # last terms of a series beside its largest


@kernel
def carry_by_series(tables, rates, segment, tangent, m, s):
    """Columns after s of the present step, into tangent.now."""
    n, dual = tables.sizes[0], tangent.dual
    if tangent.ready[0] == 0:
        _fill_columns(tables, rates, segment.series, tangent.columns, dual, m)
        tangent.ready[0] = 1
    if _converge(n, tangent.columns.shape[0], dual, s):
        _evaluate(n, dual, s, tangent.now)
        return
    big_n, series, piece = tangent.columns.shape[1], tangent.series, tangent.piece
    passed, length = 0.0, s
    while True:
        while length > _SHORTEST * s and not _converge(n, tangent.columns.shape[0], dual, length):
            length *= 0.5
        if passed + length >= s or passed + length == passed:
            _evaluate(n, dual, s - passed, tangent.now)
            break
        _evaluate(big_n, dual, length, piece)
        passed += length
        for i in range(big_n):
            total = segment.series[i, at.ORDER]
            for k in range(at.ORDER - 1, -1, -1):
                total = total * passed + segment.series[i, k]
            series[i, 0] = total
        fill_series(
            tables.code, tables.terms, tables.weights, tables.code_rows[m, 0],
            tables.code_rows[m, 1], tables.values, tables.outlets[m],
            tables.wiring[m, 0, at.SLAVED], tables.sizes, tables.harmonics, series, 0, at.ORDER,
        )  # fmt: skip
        _fill_columns(tables, rates, series, piece, dual, m)
        length = min(2.0 * length, s - passed)
    tangent.ready[0] = 0  # the series are those of the last piece


@kernel
def _fill_columns(tables, rates, series, columns, dual, m):
    for i in range(columns.shape[1]):
        for c in range(columns.shape[0]):
            dual[i, c // at.LANES, 0, c % at.LANES] = columns[c, i]
    fill_duals(
        tables.code, tables.terms, tables.weights, tables.code_rows[m, 0],
        tables.code_rows[m, 1], tables.values, rates.slot_rates, tables.sizes[0],
        tables.outlets[m], tables.wiring[m, 0, at.SLAVED], tables.sizes, tables.harmonics,
        rates.harmonics, series, dual, 0, at.ORDER,
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
            leading = max(abs(dual[i, block, 0, lane]), abs(dual[i, block, 1, lane]) * s)
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
