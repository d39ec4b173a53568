"""Instructions on Taylor series as records, with expressions in place of slots."""

from __future__ import annotations

from dataclasses import dataclass, field

from nonsmooth.system.expressions import Expression
from nonsmooth.system.linear import Basis

__all__ = ["Instruction", "Operand", "TaylorCode"]

# an instruction's own result by number, or a coordinate
Operand = int | Basis


@dataclass(slots=True)
class Instruction:
    """One row: ``a``, ``b`` and ``c`` are operands, ``slot`` an expression of parameters.

    A sum has terms instead, operands with their constant factors, and products of two operands.
    """

    opcode: int
    a: Operand | None = None
    b: Operand | None = None
    c: Operand | None = None
    slot: Expression | None = None
    terms: tuple[tuple[Operand, Expression], ...] = ()
    products: tuple[tuple[Operand, Operand, Expression], ...] = ()


@dataclass(slots=True)
class TaylorCode:
    """Instructions of one mode and where its results are found."""

    instructions: list[Instruction] = field(default_factory=list)
    middle: int = 0  # resets follow
    results: dict[tuple[object, ...], Operand] = field(default_factory=dict)
    frequencies: dict[Expression, None] = field(default_factory=dict)
    constants: list[tuple[str, Expression]] = field(default_factory=list)  # with their places
    grows: str = ""  # place where plain time stands

    @property
    def uses_time(self) -> bool:
        """Whether time itself is a coordinate."""
        return bool(self.grows)
