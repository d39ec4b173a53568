"""Rows of code for the engine: operands become registers, constants slots of the tape."""

from __future__ import annotations

from collections.abc import Mapping
from operator import itemgetter

import numpy as np

from nonsmooth.engine.record import Rows, rows_of, zeros
from nonsmooth.system.expressions import Expression
from nonsmooth.system.linear import Basis
from nonsmooth.system.parameter_tape import ParameterTape
from nonsmooth.system.taylor_instructions import Instruction, Operand, TaylorCode

__all__ = ["TaylorRows"]


class TaylorRows:
    """Code of all Taylor modes, one after the other."""

    def __init__(self, columns: Mapping[Basis, int], n: int, n_modes: int, most: int) -> None:
        self.columns = columns
        self.n = n
        self.most = most
        self.n_registers = 0
        self.rows: list[tuple[int, int, int, int | Expression, int]] = []
        self.terms: list[tuple[int, int, Expression]] = []
        self.code_rows = zeros("Program", code_rows=(n_modes,))["code_rows"]
        self.outlets = np.full((n_modes, 2 * n + most + most * n), -1, np.int64)

    @property
    def constants(self) -> list[Expression]:
        """Expressions that need a slot."""
        of_rows = [row[3] for row in self.rows if not isinstance(row[3], int)]
        return [*of_rows, *(factor for *_, factor in self.terms)]

    def put(self, i_mode: int, code: TaylorCode, states: tuple[str, ...]) -> None:
        """Enter the code of a mode."""
        first, width = len(self.rows), len(self.columns)
        for i, each in enumerate(code.instructions):
            a, c = self._register(each.a), self._register(each.c)
            b = self._register(each.b) if each.slot is None else each.slot
            if each.terms or each.products:
                a, c, b = self._put_terms(each)
            self.rows.append((each.opcode, width + i, a, b, c))
        self.code_rows[i_mode] = first, first + code.middle, len(self.rows)
        self.n_registers = max(self.n_registers, width + len(code.instructions))
        for (kind, *place), operand in code.results.items():
            self.outlets[i_mode, self._outlet(kind, place, states)] = self._register(operand)

    def _put_terms(self, each: Instruction) -> tuple[int, int, int]:
        """First term, first product and end of a sum; what is computed last is added last."""
        first = len(self.terms)
        terms = [(self._register(x), 0, factor) for x, factor in each.terms]
        self.terms += sorted(terms, key=itemgetter(0))
        middle = len(self.terms)
        products = [(self._register(x), self._register(y), c) for x, y, c in each.products]
        self.terms += sorted(products, key=lambda row: max(row[:2]))
        return first, middle, len(self.terms)

    def array_of_terms(self, tape: ParameterTape) -> Rows:
        """Rows (register, slot, other register)."""
        rows = [(register, tape.slot(factor), other) for register, other, factor in self.terms]
        return rows_of("Term", rows)

    def array(self, tape: ParameterTape) -> Rows:
        """Rows (opcode, target, a, b, c)."""
        rows = [
            (code, target, a, b if isinstance(b, int) else tape.slot(b), c)
            for code, target, a, b, c in self.rows
        ]
        return rows_of("Instruction", rows)

    def _outlet(self, kind: object, place: list[object], states: tuple[str, ...]) -> int:
        if kind == "rate":
            return states.index(str(place[0]))
        if kind == "vanishing":
            return self.n + self.most + self.most * self.n + states.index(str(place[0]))
        exit_number = place[0]
        assert isinstance(exit_number, int)
        if kind == "guard":
            return self.n + exit_number
        return self.n + self.most + exit_number * self.n + states.index(str(place[1]))

    def _register(self, operand: Operand | None) -> int:
        if operand is None:
            return 0
        if isinstance(operand, int):
            return len(self.columns) + operand
        return self.columns[operand]
