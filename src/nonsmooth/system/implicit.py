"""Rates of slaved states that are given by equations: these hold on, so their rates vanish.

With equations G(u, z, t) = 0 for the slaved states u, the rates of u solve G_u u' = -G_z z' - G_t.
Block by block of those that depend on each other, Cramer's rule writes them with one divisor, a
determinant of G_u, which is zero only where the equations do not tell u.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nonsmooth.errors import ModelError
from nonsmooth.system.blocks import Block, blocks_of
from nonsmooth.system.determinants import determinant
from nonsmooth.system.differentiate import derivative, rate_of_change
from nonsmooth.system.expressions import Expression
from nonsmooth.system.graph import Graph
from nonsmooth.system.mode_equations import ModeEquations
from nonsmooth.system.relations import Relations

__all__ = ["implicit_rates", "partials"]

_Row = Sequence[Expression]
_MOST_SOLVED = 6  # states that depend on each other: the terms of a determinant are many


def implicit_rates(
    graph: Graph,
    equations: ModeEquations,
    relations: Relations,
    rate: Callable[[str], Expression],
) -> dict[str, Expression]:
    """Rates of the implicit slaved states, from the rates of all others."""
    unknowns = tuple(relations.implicit)
    rows = partials(graph, relations)

    def rate_of_others(state: str) -> Expression:
        if state in relations.implicit:
            return graph.zero
        if state in relations.explicit:
            return rate_of_change(graph, relations.explicit[state], rate_of_others)
        return rate(state)

    pushed = [
        graph.negate(rate_of_change(graph, node, rate_of_others))
        for node in relations.implicit.values()
    ]
    found: dict[str, Expression] = {}
    for block in _blocks(graph, equations, rows, unknowns):
        right = [
            graph.add(
                pushed[i],
                *(
                    graph.negate(graph.multiply(rows[i][j], found[state]))
                    for j, state in enumerate(unknowns)
                    if state in found and rows[i][j] is not graph.zero
                ),
            )
            for i in block.rows
        ]
        inner = [[rows[i][j] for j in block.columns] for i in block.rows]
        names = [unknowns[j] for j in block.columns]
        found |= _by_cramers_rule(graph, equations, inner, right, names)
    return {state: found[state] for state in unknowns}


def _blocks(
    graph: Graph, equations: ModeEquations, rows: Sequence[_Row], unknowns: Sequence[str]
) -> list[Block]:
    """Equations that have to be solved together, those first on which others depend."""
    pattern = np.array([[node is not graph.zero for node in row] for row in rows], dtype=bool)
    blocks = blocks_of(pattern)
    if blocks is None:
        raise ModelError(_untold(equations, unknowns))
    for block in blocks:
        if len(block.rows) > _MOST_SOLVED:
            names = [unknowns[j] for j in block.columns]
            raise ModelError(
                f"modes[{equations.name!r}].slaved: {len(names)} equations with '=' that are not"
                f" linear depend on each other ({', '.join(names)}); at most {_MOST_SOLVED} are"
                " solved together: write some of these states as expressions of the others"
            )
    return blocks


def _by_cramers_rule(
    graph: Graph, equations: ModeEquations, rows: Sequence[_Row], right: _Row, names: Sequence[str]
) -> dict[str, Expression]:
    divisor = determinant(graph, rows)
    if divisor is graph.zero:
        raise ModelError(_untold(equations, names))
    rates = {}
    for j, state in enumerate(names):
        replaced = [[*row[:j], b, *row[j + 1 :]] for row, b in zip(rows, right, strict=True)]
        rates[state] = graph.call("/", determinant(graph, replaced), divisor)
    return rates


def _untold(equations: ModeEquations, names: Sequence[str]) -> str:
    return (
        f"modes[{equations.name!r}].slaved: the equations with '=' of {', '.join(names)}"
        " cannot be solved for these states, whatever their values; each of them must stand"
        " in an equation, and no two equations may say the same"
    )


def partials(graph: Graph, relations: Relations) -> list[list[Expression]]:
    """Derivatives of the implicit equations, row by row, by the states for which they are solved.

    States that follow from these by expressions move with them.
    """
    return [
        [_partial(graph, relations, node, state) for state in relations.implicit]
        for node in relations.implicit.values()
    ]


def _partial(graph: Graph, relations: Relations, node: Expression, state: str) -> Expression:
    """Derivative by one implicit state, those that follow from it by expressions included."""

    def seed(name: str) -> Expression:
        if name in relations.explicit:
            return derivative(graph, relations.explicit[name], seed)
        return graph.one if name == state else graph.zero

    return derivative(graph, node, seed)
