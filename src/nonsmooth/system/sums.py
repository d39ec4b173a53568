"""Sums of expressions whose parts are shared: what is in both of two sides cancels exactly.

Where fields differ by friction alone, springs and loads cancel before any number is looked at:
their values, which may be large beside friction, say nothing about whether it is there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nonsmooth.system.expressions import Call, Expression
from nonsmooth.system.graph import Graph

__all__ = ["signed_sum"]

# What a term of a sum within a product or quotient is multiplied by or divided by, outermost first.
_Around = tuple[tuple[str, Expression], ...]


def signed_sum(graph: Graph, nodes: Sequence[Expression], signs: Sequence[int]) -> Expression:
    """Sum of expressions, each with its sign, without the terms that are in it with both signs."""
    counts: dict[tuple[object, ...], int] = {}
    kept: dict[tuple[object, ...], tuple[Expression, _Around]] = {}
    for node, sign in zip(nodes, signs, strict=True):
        for term, own, around in _terms(graph, node, sign, ()):
            key = (id(term), *((operator, id(other)) for operator, other in around))
            counts[key] = counts.get(key, 0) + own
            kept[key] = term, around
    terms = []
    for key, count in counts.items():
        if count:
            term = _within(graph, *kept[key])
            terms.append(term if count == 1 else graph.multiply(graph.number(float(count)), term))
    return graph.add(*terms)


def _terms(
    graph: Graph, node: Expression, sign: int, around: _Around
) -> Iterator[tuple[Expression, int, _Around]]:
    """Terms of a sum, with what multiplies all of it."""
    if not isinstance(node, Call):
        yield node, sign, around
    elif node.function == "+":
        for argument in node.arguments:
            yield from _terms(graph, argument, sign, around)
    elif node.function == "neg":
        yield from _terms(graph, node.arguments[0], -sign, around)
    elif node.function == "/":
        above, below = node.arguments
        yield from _terms(graph, above, sign, (*around, ("/", below)))
    elif node.function == "*":
        moving = [argument for argument in node.arguments if graph.moves(argument)]
        if len(moving) != 1:
            yield node, sign, around
            return
        rest = [argument for argument in node.arguments if argument is not moving[0]]
        yield from _terms(graph, moving[0], sign, (*around, ("*", graph.multiply(*rest))))
    else:
        yield node, sign, around


def _within(graph: Graph, term: Expression, around: _Around) -> Expression:
    for operator, other in reversed(around):
        term = graph.multiply(other, term) if operator == "*" else graph.call("/", term, other)
    return term
