"""Slaved states that are given by equations, solved together by Newton's method.

The equations are instructions like all others, so their gradients are there: elimination on
them gives the step of Newton's method, and at a solution the gradients of the slaved states.
"""

from __future__ import annotations

from nonsmooth.engine import layout as at
from nonsmooth.engine.dual_series import fill_duals
from nonsmooth.engine.jit import kernel
from nonsmooth.engine.taylor_series import fill_series

__all__ = ["place_point", "settle", "solve_together"]

_MOST_STEPS = 60
_QUADRATIC = 1e-9  # a step of this part of the terms leaves an error of its square
_FAR = 1e300
_MOST_GROWTH = 4.0  # of a step, beside the one before: far from a solution steps may grow
_LEAST = 2.0**-20  # part of a step of Newton's method


@kernel
def place_point(z, series, dual):
    """Registers of the coordinates at z, and directions along each of them."""
    for i in range(z.size):
        series[i, 0] = z[i]
        for block in range(dual.shape[1]):
            for lane in range(at.LANES):
                dual[i, block, 0, lane] = 1.0 if block * at.LANES + lane == i else 0.0


@kernel
def settle(tables, rates, segment, m):
    """Solve the relations of mode m at segment.z, from the present values; False if that fails.

    A step is halved where the next one would be much longer. Only the states that are solved for
    change.
    """
    z, before, last, weight = segment.z, segment.newton[0], segment.newton[1], segment.newton[2]
    n, n_exits = tables.sizes[0], tables.wiring.shape[1] - 1
    implicit, share, size = tables.wiring[m, 0, at.IMPLICIT], 1.0, _FAR
    for count in range(_MOST_STEPS):
        _fill_step(tables, rates, segment, m)
        step, part = _FAR, _FAR
        if solve_together(tables, m, segment.series, segment.dual):
            step, part = _size_of_step(tables, m, segment.series, segment.dual, z, weight, count)
        if step < _MOST_GROWTH * size or part <= _QUADRATIC:
            size, share = step, 1.0
            for i in range(n):
                if (implicit >> i) & 1:
                    row = tables.outlets[m, at.vanishing(n_exits, n, i)]
                    before[i], last[i] = z[i], segment.series[row, 0]
        else:
            share *= 0.5
            if size == _FAR or share < _LEAST:
                return False
        for i in range(n):
            if (implicit >> i) & 1:
                z[i] = before[i] - share * last[i]
        if part <= _QUADRATIC:
            return True
    return False


@kernel
def _fill_step(tables, rates, segment, m):
    """Values of all that mode m computes at segment.z, with derivatives by the states."""
    first, end, slaved = (
        tables.code_rows[m, 0],
        tables.code_rows[m, 2],
        at.explicit(tables.wiring, m),
    )
    place_point(segment.z, segment.series, segment.dual)
    fill_series(
        tables.code, tables.terms, tables.weights, first, end, tables.values, tables.outlets[m],
        slaved, tables.sizes, tables.harmonics, segment.series, 0, 0,
    )  # fmt: skip
    fill_duals(
        tables.code, tables.terms, tables.weights, first, end, tables.values, rates.slot_rates,
        segment.z.size, tables.outlets[m], slaved, tables.sizes, tables.harmonics, rates.harmonics,
        segment.series, segment.dual, 0, 0, at.n_blocks(tables.sizes[0]),
    )  # fmt: skip


@kernel
def solve_together(tables, m, series, dual):
    """Solve the gradients of what vanishes for the states solved for; False where that fails.

    shapes: dual (R, B, orders, LANES), whose order 0 changes in place: register i of what vanishes
    then has the gradient of state i minus its solution, and in series[:, 0] the step back to it
    """
    n, n_exits, outlets = tables.sizes[0], tables.wiring.shape[1] - 1, tables.outlets[m]
    implicit = tables.wiring[m, 0, at.IMPLICIT]
    for j in range(n):
        if not (implicit >> j) & 1:
            continue
        block, lane = j // at.LANES, j % at.LANES
        best, largest = j, 0.0
        for i in range(j, n):
            if (implicit >> i) & 1:
                entry = abs(dual[outlets[at.vanishing(n_exits, n, i)], block, 0, lane])
                if entry > largest:
                    best, largest = i, entry
        if largest == 0.0:
            return False
        pivot = outlets[at.vanishing(n_exits, n, j)]
        _exchange(series, dual, pivot, outlets[at.vanishing(n_exits, n, best)])
        _scale(series, dual, pivot, 1.0 / dual[pivot, block, 0, lane])
        for i in range(n):
            if i != j and (implicit >> i) & 1:
                row = outlets[at.vanishing(n_exits, n, i)]
                _subtract(series, dual, row, dual[row, block, 0, lane], pivot)
    return True


@kernel
def _size_of_step(tables, m, series, dual, z, weight, count):
    """Largest step of a state, beside the terms that made up the solution at first, and now."""
    n, n_exits, outlets = tables.sizes[0], tables.wiring.shape[1] - 1, tables.outlets[m]
    implicit = tables.wiring[m, 0, at.IMPLICIT]
    largest, part = 0.0, 0.0
    for i in range(n):
        if (implicit >> i) & 1:
            row = outlets[at.vanishing(n_exits, n, i)]
            size = 0.0
            for j in range(n):
                size += abs(dual[row, j // at.LANES, 0, j % at.LANES] * z[j])
            step = abs(series[row, 0])
            if not step <= _FAR:
                return _FAR, _FAR
            if count == 0:
                weight[i] = max(size, step)
            if step > 0.0:
                largest = max(largest, step / weight[i] if weight[i] > 0.0 else _FAR)
                part = max(part, step / size if size > 0.0 else _FAR)
    return largest, part


@kernel
def _exchange(series, dual, a, b):
    if a == b:
        return
    series[a, 0], series[b, 0] = series[b, 0], series[a, 0]
    for block in range(dual.shape[1]):
        for lane in range(at.LANES):
            kept = dual[a, block, 0, lane]
            dual[a, block, 0, lane] = dual[b, block, 0, lane]
            dual[b, block, 0, lane] = kept


@kernel
def _scale(series, dual, row, factor):
    series[row, 0] *= factor
    for block in range(dual.shape[1]):
        for lane in range(at.LANES):
            dual[row, block, 0, lane] *= factor


@kernel
def _subtract(series, dual, row, factor, pivot):
    series[row, 0] -= factor * series[pivot, 0]
    for block in range(dual.shape[1]):
        for lane in range(at.LANES):
            dual[row, block, 0, lane] -= factor * dual[pivot, block, 0, lane]
