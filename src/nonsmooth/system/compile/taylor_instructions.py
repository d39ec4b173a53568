"""Instructions on Taylor series as records, and products that become part of a sum.

An instruction on series is done once for each order, and the next one waits for it. Of the force
``-c*v - k*x*y + x**3`` one sum with two products is left. The result of a product that something
else reads too stays an instruction of its own.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.system.algebra.linear import Basis
from nonsmooth.system.text.expressions import Expression

__all__ = ["Instruction", "Operand", "TaylorCode", "fuse_products"]

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


# ---------------------------------------------------------------- products in sums


def fuse_products(code: TaylorCode) -> TaylorCode:
    """The same code with products in their sums, and its results numbered anew."""
    instructions = code.instructions
    fused = _products_of_one_sum(code)
    kept = [i for i in range(len(instructions)) if i not in fused]
    numbers = {old: new for new, old in enumerate(kept)}

    def renumbered(operand: Operand) -> Operand:
        return numbers[operand] if isinstance(operand, int) else operand

    def if_any(operand: Operand | None) -> Operand | None:
        return None if operand is None else renumbered(operand)

    def rewritten(each: Instruction) -> Instruction:
        terms = [term for term in each.terms if term[0] not in fused]
        products = [
            (*_factors(instructions[operand]), weight)
            for operand, weight in each.terms
            if isinstance(operand, int) and operand in fused
        ]
        return replace(
            each,
            a=if_any(each.a),
            b=if_any(each.b),
            c=if_any(each.c),
            terms=tuple((renumbered(x), weight) for x, weight in terms),
            products=tuple((renumbered(x), renumbered(y), w) for x, y, w in products),
        )

    return replace(
        code,
        instructions=[rewritten(instructions[i]) for i in kept],
        middle=sum(i < code.middle for i in kept),
        results={place: renumbered(operand) for place, operand in code.results.items()},
    )


def _products_of_one_sum(code: TaylorCode) -> set[int]:
    """Numbers of the products that one sum reads and nothing else."""
    uses: Counter[Operand | None] = Counter(code.results.values())
    in_sums: set[Operand] = set()
    for each in code.instructions:
        uses.update((each.a, each.b, each.c, *(operand for operand, _ in each.terms)))
        in_sums.update(operand for operand, _ in each.terms)
    return {
        i
        for i, each in enumerate(code.instructions)
        if each.opcode in (op.MULTIPLY, op.SQUARE) and uses[i] == 1 and i in in_sums
    }


def _factors(product: Instruction) -> tuple[Operand, Operand]:
    assert product.a is not None
    if product.opcode == op.SQUARE:
        return product.a, product.a
    assert product.b is not None
    return product.a, product.b
