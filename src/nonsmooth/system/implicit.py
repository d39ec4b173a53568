"""Rates of slaved states that are given by equations: these hold on, so their rates vanish.

With equations G(u, z, t) = 0 for the slaved states u, the rates of u solve G_u u' = -G_z z' - G_t.
Cramer's rule writes them with one divisor, the determinant of G_u, which is zero only where
the equations do not tell u.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nonsmooth.errors import ModelError
from nonsmooth.system.determinants import determinant
from nonsmooth.system.differentiate import derivative, rate_of_change
from nonsmooth.system.expressions import Expression
from nonsmooth.system.graph import Graph
from nonsmooth.system.mode_equations import ModeEquations
from nonsmooth.system.relations import Relations

__all__ = ["implicit_rates", "partials"]

_Row = Sequence[Expression]


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
    divisor = determinant(graph, rows)
    if divisor is graph.zero:
        raise ModelError(
            f"modes[{equations.name!r}].slaved: the equations with '=' of {', '.join(unknowns)}"
            " cannot be solved for these states, whatever their values; each of them must stand"
            " in an equation, and no two equations may say the same"
        )
    rates = {}
    for j, state in enumerate(unknowns):
        replaced = [[*row[:j], b, *row[j + 1 :]] for row, b in zip(rows, pushed, strict=True)]
        rates[state] = graph.call("/", determinant(graph, replaced), divisor)
    return rates


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
