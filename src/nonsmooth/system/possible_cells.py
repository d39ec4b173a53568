"""Whether a cell has a place among the states, for given values of the parameters."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from fractions import Fraction

from nonsmooth.system.cells import Cell, SplitMode
from nonsmooth.system.evaluate import constant_value
from nonsmooth.system.exclusions import Inequality, excluded
from nonsmooth.system.expressions import Expression
from nonsmooth.system.frequencies import monomials
from nonsmooth.system.graph import Graph

__all__ = ["is_possible"]


def is_possible(graph: Graph, mode: SplitMode, cell: Cell, values: Mapping[str, float]) -> bool:
    """Whether linear arithmetic leaves a place for a cell; products of states count as unknown."""
    inequalities: list[Inequality] = []
    for key, sign in cell.signs.items():
        terms = _terms(graph, mode.nodes[mode.names[key]], values)
        if terms is None:
            return True
        if sign >= 0:
            inequalities.append(Inequality(terms, strict=sign > 0))
        if sign <= 0:
            turned = {factors: -value for factors, value in terms.items()}
            inequalities.append(Inequality(turned, strict=sign < 0))
    return not excluded(inequalities)


def _terms(
    graph: Graph, node: Expression, values: Mapping[str, float]
) -> dict[Hashable, Fraction] | None:
    """Products of what moves, and the number before each; None where that is no number."""
    terms: dict[Hashable, Fraction] = {}
    for product, number in monomials(node).items():
        factors = [graph.imported(factor) for factor in product]  # sums in them are made anew
        moving = tuple(factor for factor in factors if graph.moves(factor))
        fixed = [constant_value(each, values) for each in factors if not graph.moves(each)]
        value = math.prod(fixed, start=number)
        if not math.isfinite(value):
            return None
        terms[moving] = terms.get(moving, Fraction(0)) + Fraction(value)
    return terms
