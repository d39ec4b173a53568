"""The sums of Taylor recurrences, written for vector registers.

They are short, of a length that changes from order to order, and most of what a Taylor step
computes. A compiler makes of them loops whose overhead is longer than the sum; here a sum is a
fixed number of vector instructions, over rows that are zero where it ends. Terms are added in
the order of vectors, so last digits depend on the processor. They exist as compiled code only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from nonsmooth.engine import layout as at

__all__ = ["add_lanes", "add_products", "inner", "set_lanes", "weighted"]

_LENGTH = at.MIRROR - at.LAG  # of a row of settled coefficients, a multiple of LANES
_NEWEST = at.MIRROR + at.ORDER  # where a mirrored row would hold coefficient 0
_FREE = ["reassoc", "contract", "nsz"]  # nothing that the margins rely on
_INDEX = ir.IntType(64)
_REAL = ir.DoubleType()
_VECTOR = ir.VectorType(_REAL, at.LANES)


def _data(context: Any, builder: Any, signature: Any, arguments: Any, i: int) -> Any:
    """Pointer to the numbers of an array argument, which are contiguous."""
    return context.make_array(signature.args[i])(context, builder, arguments[i]).data


def _vector(builder: Any, pointer: Any, offset: Any) -> Any:
    """Pointer to the vector that starts at an offset."""
    return builder.bitcast(builder.gep(pointer, [offset]), _VECTOR.as_pointer())


def _spread(builder: Any, value: Any) -> Any:
    """The vector with a value in every lane."""
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, ir.IntType(32)(0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), at.LANES), None)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), lanes)


def _row_sum(weighing: bool) -> Callable[..., Any]:
    """Code for the sum of a_j b_(k-j) over 0 < j < k, with the weight j or without."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b = (_data(context, builder, signature, arguments, i) for i in (0, 1))
        start = builder.sub(_INDEX(_NEWEST), arguments[2])
        total = None
        for j in range(0, _LENGTH, at.LANES):
            left = builder.load(_vector(builder, a, _INDEX(at.LAG + j)), align=8)
            right = builder.load(_vector(builder, b, builder.add(start, _INDEX(j))), align=8)
            term = builder.fmul(left, right, flags=_FREE)
            if weighing:
                weights = ir.Constant(_VECTOR, [float(j + i) for i in range(at.LANES)])
                term = builder.fmul(term, weights, flags=_FREE)
            total = term if total is None else builder.fadd(total, term, flags=_FREE)
        reduction = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(_REAL, [_REAL, _VECTOR]),
            f"llvm.vector.reduce.fadd.v{at.LANES}f64",
        )
        return builder.call(reduction, [_REAL(-0.0), total], fastmath=_FREE)

    return generate


def _lane_sum(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Code for adding the sum of a_(k-j) b_j over j < k to the lanes of a target."""
    scale, k = arguments[0], arguments[3]
    a, b, target = (_data(context, builder, signature, arguments, i) for i in (1, 2, 4))
    start = builder.sub(_INDEX(_NEWEST), k)
    total = cgutils.alloca_once_value(builder, ir.Constant(_VECTOR, [0.0] * at.LANES))
    with cgutils.for_range(builder, k) as loop:
        factor = builder.load(builder.gep(a, [builder.add(start, loop.index)]))
        lanes = builder.load(
            _vector(builder, b, builder.mul(loop.index, _INDEX(at.LANES))), align=8
        )
        term = builder.fmul(_spread(builder, factor), lanes, flags=_FREE)
        builder.store(builder.fadd(builder.load(total), term, flags=_FREE), total)
    place = _vector(builder, target, _INDEX(0))
    term = builder.fmul(_spread(builder, scale), builder.load(total), flags=_FREE)
    builder.store(builder.fadd(builder.load(place, align=8), term, flags=_FREE), place, align=8)
    return context.get_dummy_value()


def _lane_change(adding: bool) -> Callable[..., Any]:
    """Code for setting the lanes of a target to a multiple of a source, or adding it."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, target = (_data(context, builder, signature, arguments, i) for i in (1, 2))
        lanes = builder.load(_vector(builder, source, _INDEX(0)), align=8)
        lanes = builder.fmul(_spread(builder, arguments[0]), lanes, flags=_FREE)
        place = _vector(builder, target, _INDEX(0))
        if adding:
            lanes = builder.fadd(builder.load(place, align=8), lanes, flags=_FREE)
        builder.store(lanes, place, align=8)
        return context.get_dummy_value()

    return generate


@intrinsic
def inner(context, a, b, k):
    """Sum of a_j b_(k-j) over 0 < j < k.

    shapes: a, b (SERIES_ROW,) rows of Segment.series with coefficients below k settled
    """
    return types.float64(a, b, k), _row_sum(weighing=False)


@intrinsic
def weighted(context, a, b, k):
    """Sum of j a_j b_(k-j) over 0 < j < k; shapes as in `inner`."""
    return types.float64(a, b, k), _row_sum(weighing=True)


@intrinsic
def add_products(context, scale, a, b, k, target):
    """target += scale times the sum of a_(k-j) b_j over j < k, lane by lane.

    shapes: a (SERIES_ROW,) with all coefficients settled, b (k, LANES) or longer,
    target (LANES,)
    """
    return types.void(scale, a, b, k, target), _lane_sum


@intrinsic
def set_lanes(context, scale, source, target):
    """target := scale times source; shapes: both (LANES,)."""
    return types.void(scale, source, target), _lane_change(adding=False)


@intrinsic
def add_lanes(context, scale, source, target):
    """target += scale times source; shapes: both (LANES,)."""
    return types.void(scale, source, target), _lane_change(adding=True)
