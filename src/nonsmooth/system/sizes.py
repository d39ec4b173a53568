"""How large the terms are that make up the value of an expression.

A value far below that size is what rounding leaves of terms that cancel. A value that is small
for other reasons, such as a force over a stiffness of 1e9, is as large as its size.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from nonsmooth.system.value_tape import ValueTape

__all__ = ["sizes_of"]

# Functions that pass on what is left of terms that cancel in their argument.
_THROUGH_ZERO = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "abs", "min", "max"})


def sizes_of(tape: ValueTape, values: Sequence[Any]) -> list[Any]:
    """Sizes of the terms of the expressions of a tape, from the values of all their parts."""
    with np.errstate(all="ignore"):
        sizes = [np.abs(value) for value in values]
        for register, call, arguments in tape.calls:
            parts = [sizes[i] for i in arguments]
            inner = [values[i] for i in arguments]
            sizes[register] = _combined(call.function, parts, inner, sizes[register])
    return [sizes[i] for i in tape.results]


def _combined(function: str, parts: list[Any], inner: list[Any], value: Any) -> Any:
    """Size of a call from the sizes and values of its arguments, and from its own value."""
    if function in ("+", "neg"):
        return reduce(np.add, parts)
    if function == "*":
        return reduce(np.multiply, parts)
    if function == "/":
        return np.divide(parts[0], np.abs(inner[1]))
    if function == "sqrt":
        return np.sqrt(parts[0])
    if function == "**":
        return np.where(np.greater(inner[1], 0.0), np.power(parts[0], inner[1]), value)
    if function == "log":
        return np.maximum(value, np.divide(parts[0], np.abs(inner[0])))
    return reduce(np.maximum, parts, value) if function in _THROUGH_ZERO else value
