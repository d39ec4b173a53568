"""How large the terms are that make up the value of an expression.

A value far below that size is what rounding leaves of terms that cancel. A value that is small
for other reasons, such as a force over a stiffness of 1e9, is as large as its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from nonsmooth.system.evaluate import evaluate_shared
from nonsmooth.system.expressions import Call, Expression

__all__ = ["size_at"]

# Functions that pass on what is left of terms that cancel in their argument.
_THROUGH_ZERO = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "abs", "min", "max"})


def size_at(node: Expression, point: Mapping[str, float]) -> float:
    """Size of the terms of an expression; nan where it has no value."""
    try:
        return _size(node, point, {}, {})
    except (ArithmeticError, TypeError, ValueError):
        return math.nan


def _size(
    node: Expression,
    point: Mapping[str, float],
    values: dict[int, float],
    sizes: dict[int, float],
) -> float:
    """The same, with the values and sizes of parts that are shared."""
    if not isinstance(node, Call):
        return abs(_value(node, point, values))
    if id(node) not in sizes:
        parts = [_size(argument, point, values, sizes) for argument in node.arguments]
        sizes[id(node)] = _combined(node, parts, point, values)
    return sizes[id(node)]


def _combined(
    node: Call, parts: list[float], point: Mapping[str, float], values: dict[int, float]
) -> float:
    """Size of a call from those of its arguments."""
    value = abs(_value(node, point, values))
    first = parts[0] if parts else 0.0
    if node.function in ("+", "neg"):
        return sum(parts)
    if node.function == "*":
        return math.prod(parts)
    if node.function == "/":
        return first / abs(_value(node.arguments[1], point, values))
    if node.function == "sqrt":
        return math.sqrt(first)
    if node.function == "**":
        power = _value(node.arguments[1], point, values)
        return float(first**power) if power > 0.0 else value
    if node.function == "log":
        return max(value, first / abs(_value(node.arguments[0], point, values)))
    return max(value, *parts) if node.function in _THROUGH_ZERO else value


def _value(node: Expression, point: Mapping[str, float], values: dict[int, float]) -> float:
    with np.errstate(all="ignore"):
        return float(evaluate_shared(node, point, values, lambda _: None))
