"""Values of some expressions at many points at once.

Expressions share parts, and a question is asked at many points. So their parts are listed once,
arguments first, and each of them is worked out by one call of numpy for all points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.expressions import Call, Expression, Name, Number, to_text
from nonsmooth.system.functions import lookup

__all__ = ["Array", "ValueTape", "table"]

Array = npt.NDArray[np.float64]
_Row = tuple[int, Callable[..., Any], tuple[int, ...]]


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
