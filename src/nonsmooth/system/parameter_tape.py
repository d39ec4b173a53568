"""The parameter tape: expressions of parameters become instructions on numbered slots."""

from __future__ import annotations

import numpy as np

from nonsmooth.engine import opcodes
from nonsmooth.system.expressions import Call, Expression, Name, Number
from nonsmooth.system.functions import lookup

__all__ = ["ParameterTape"]


class ParameterTape:
    """Collects instructions; equal expressions share a slot.

    Parameters come first, then literals, then one slot for each instruction.
    """

    def __init__(self, parameters: tuple[str, ...]) -> None:
        self.slots: dict[tuple[object, ...], int] = {(p,): i for i, p in enumerate(parameters)}
        self.n_parameters = len(parameters)
        self.literals: dict[float, int] = {}
        self.rows: list[tuple[int, int, int, int]] = []
        self.base = 0
        self._seen: dict[int, Expression] = {}
        self._placed: dict[int, int] = {}

    def collect_literals(self, expression: Expression) -> None:
        """Literals come before instructions, so all of them are collected first."""
        stack = [expression]
        while stack:
            node = stack.pop()
            if isinstance(node, Number):
                self.literals.setdefault(node.value, len(self.literals))
            elif isinstance(node, Name) and node.name == "pi":
                self.literals.setdefault(np.pi, len(self.literals))
            elif isinstance(node, Call) and id(node) not in self._seen:
                self._seen[id(node)] = node  # kept, so that its number stays its own
                stack.extend(node.arguments)

    def finish_literals(self) -> None:
        """Fix the slots of the literals; instructions follow."""
        self.base = self.n_parameters + len(self.literals)

    def slot(self, node: Expression) -> int:
        """Slot that will hold the value of an expression."""
        if isinstance(node, Number):
            return self.n_parameters + self.literals[node.value]
        if isinstance(node, Name):
            if node.name == "pi":
                return self.n_parameters + self.literals[np.pi]
            return self.slots[(node.name,)]  # other names were resolved before
        if id(node) not in self._placed:
            assert id(node) in self._seen  # its literals were collected
            arguments = [self.slot(argument) for argument in node.arguments]
            key = (node.function, *arguments)
            if key not in self.slots:
                self.slots[key] = self._lower(node, arguments)
            self._placed[id(node)] = self.slots[key]
        return self._placed[id(node)]

    def _lower(self, node: Call, arguments: list[int]) -> int:
        if node.function == "where":
            return self._emit(opcodes.SELECT, *arguments)
        if node.function == "clip":
            raised = self._emit(opcodes.MAXIMUM, arguments[0], arguments[1])
            return self._emit(opcodes.MINIMUM, raised, arguments[2])
        code = lookup(node.function).opcode
        assert code is not None
        if len(arguments) <= 2:
            return self._emit(code, *arguments)
        place = arguments[0]
        for argument in arguments[1:]:  # sums, products, min and max of many
            place = self._emit(code, place, argument)
        return place

    def _emit(self, code: int, first: int, second: int = 0, third: int = 0) -> int:
        self.rows.append((code, first, second, third))
        return self.base + len(self.rows) - 1
