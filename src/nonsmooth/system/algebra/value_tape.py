"""Values of some expressions at many points at once, and the sizes of the terms in them.

Expressions share parts, and a question is asked at many points. So their parts are listed once,
arguments first, and each of them is worked out by one call of numpy for all points.

A value far below the size of its terms is what rounding leaves of terms that cancel. A value that
is small for other reasons, such as a force over a stiffness of 1e9, is as large as its size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.text.expressions import Call, Expression, Name, Number, to_text
from nonsmooth.system.text.functions import lookup

__all__ = ["Array", "ValueTape", "sizes_of", "table"]

Array = npt.NDArray[np.float64]
_Row = tuple[int, Callable[..., Any], tuple[int, ...]]

# Functions that pass on what is left of terms that cancel in their argument.
_THROUGH_ZERO = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "abs", "min", "max"})


class ValueTape:
    """Instructions for the values of some expressions; each part of them has a register.

    ``names`` are what values are needed for, by their registers; the rate of a signal is one of
    them. ``calls`` are all other parts, arguments first, with their registers.
    """

    def __init__(self, nodes: Iterable[Expression]) -> None:
        self._nodes = tuple(nodes)  # kept, so that their numbers stay their own
        self.names: dict[str, int] = {}
        self.calls: list[tuple[int, Call, tuple[int, ...]]] = []
        self._rows: list[_Row] = []
        self._registers: list[Any] = []  # with the numbers in their places
        self._known: dict[int, int] = {}
        self.results = [self._place(node) for node in self._nodes]

    def values(self, point: Mapping[str, Any]) -> list[Any]:
        """Values of the expressions; inf or nan where they have none."""
        registers = self.run(point)
        return [registers[i] for i in self.results]

    def run(self, point: Mapping[str, Any]) -> list[Any]:
        """Values of all parts by their registers."""
        registers = self._registers.copy()
        for name, i in self.names.items():
            registers[i] = point[name]
        with np.errstate(all="ignore"):
            for i, function, arguments in self._rows:
                registers[i] = function(*[registers[k] for k in arguments])
        return registers

    def _place(self, node: Expression) -> int:
        """Register of a part."""
        if id(node) not in self._known:
            self._known[id(node)] = self._new(node)
        return self._known[id(node)]

    def _new(self, node: Expression) -> int:
        if isinstance(node, Number):
            return self._constant(node.value)
        if isinstance(node, Name) and node.name == "pi":
            return self._constant(math.pi)
        if isinstance(node, Name) or node.function == "rate":
            name = to_text(node)
            if name not in self.names:
                self.names[name] = self._constant(math.nan)
            return self.names[name]
        arguments = tuple([self._place(argument) for argument in node.arguments])
        register = self._constant(math.nan)
        self._rows.append((register, lookup(node.function).evaluate, arguments))
        self.calls.append((register, node, arguments))
        return register

    def _constant(self, value: float) -> int:
        self._registers.append(value)
        return len(self._registers) - 1


def table(rows: Sequence[Any], count: int) -> Array:
    """Values at some points, a row for each expression; nan in place of what is not finite."""
    found = np.empty((len(rows), count))
    for i, row in enumerate(rows):
        found[i] = row
    found[~np.isfinite(found)] = np.nan
    return found


# ---------------------------------------------------------------- sizes of terms


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
