"""Sums, quotients and determinants of expressions, without the terms that cancel.

Where fields differ by friction alone, springs and loads cancel before any number is looked at:
their values, which may be large beside friction, say nothing about whether it is there.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import reduce

from nonsmooth.system.algebra.frequencies import Monomials, monomials, rebuilt
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.text.expressions import Call, Expression, Number, written_out

__all__ = ["determinant", "quotient", "signed_sum", "without_squares"]

_HIGHEST = 40  # power that is written as a product
_LONGEST = 1000  # nodes of sums that are looked through

# What a term of a sum within a product or quotient is multiplied by or divided by, outermost first.
_Around = tuple[tuple[str, Expression], ...]


def signed_sum(graph: Graph, nodes: Sequence[Expression], signs: Sequence[int]) -> Expression:
    """Sum of expressions, each with its sign, without the terms that are in it with both signs.

    A product of sums stays as it is, unless terms of the longest one cancel: the rate of the slip
    of a shaft on a ring has a sum of forces multiplied by a displacement.
    """
    terms, cancelled = _uncancelled(graph, nodes, signs, products=False)
    if len(terms) > 1:
        opened, more = _uncancelled(graph, nodes, signs, products=True)
        terms = opened if more > cancelled else terms
    return graph.add(*terms)


def _uncancelled(
    graph: Graph, nodes: Sequence[Expression], signs: Sequence[int], *, products: bool
) -> tuple[list[Expression], int]:
    """Terms of a sum that are not in it with both signs, and how many are."""
    counts: dict[tuple[object, ...], int] = {}
    kept: dict[tuple[object, ...], tuple[Expression, _Around]] = {}
    for node, sign in zip(nodes, signs, strict=True):
        for term, own, around in _terms(graph, node, sign, (), products):
            key = (id(term), *((operator, id(other)) for operator, other in around))
            counts[key] = counts.get(key, 0) + own
            kept[key] = term, around
    terms = []
    for key, count in counts.items():
        if count:
            term = _within(graph, *kept[key])
            terms.append(term if count == 1 else graph.multiply(graph.number(float(count)), term))
    return terms, len(counts) - len(terms)


def _terms(
    graph: Graph, node: Expression, sign: int, around: _Around, products: bool
) -> Iterator[tuple[Expression, int, _Around]]:
    """Terms of a sum, with what multiplies all of it; ``products`` of moving factors opened too."""
    if not isinstance(node, Call):
        yield node, sign, around
    elif node.function == "+":
        for argument in node.arguments:
            yield from _terms(graph, argument, sign, around, products)
    elif node.function == "neg":
        yield from _terms(graph, node.arguments[0], -sign, around, products)
    elif node.function == "/":
        above, below = node.arguments
        yield from _terms(graph, above, sign, (*around, ("/", below)), products)
    elif node.function == "*":
        moving = [argument for argument in node.arguments if graph.moves(argument)]
        if (len(moving) > 1 and not products) or not moving:
            yield node, sign, around
            return
        longest = max(moving, key=_length)
        rest = [argument for argument in node.arguments if argument is not longest]
        outside = (*around, ("*", graph.multiply(*rest)))
        yield from _terms(graph, longest, sign, outside, products)
    else:
        yield node, sign, around


def _length(node: Expression) -> int:
    """How many terms a sum has, within products and quotients too."""
    if not isinstance(node, Call) or node.function not in ("+", "neg", "/", "*"):
        return 1
    counts = [_length(argument) for argument in node.arguments]
    return sum(counts) if node.function == "+" else max(counts)


def _within(graph: Graph, term: Expression, around: _Around) -> Expression:
    for operator, other in reversed(around):
        term = graph.multiply(other, term) if operator == "*" else graph.call("/", term, other)
    return term


# ---------------------------------------------------------------- quotients


def quotient(graph: Graph, above: Expression, below: Expression) -> Expression:
    """One over another; where parameters alone make the divisor zero it is replaced by one.

    Without friction there is no width between the sides of a surface: nothing slides then, but
    the cell has its rates.
    """
    if not graph.moves(below) and not isinstance(below, Number):
        differs = graph.call(">", graph.multiply(below, below), graph.zero)
        below = graph.call("where", differs, below, graph.one)
    return graph.call("/", above, below)


def without_squares(
    graph: Graph, one: Expression, other: Expression
) -> tuple[Expression, Expression]:
    """Two sums of products without even powers that all products share.

    Odd ones stay: where they change sign the signs of the two change.
    """
    if written_out([one, other]) > _LONGEST:
        return one, other
    sums = [monomials(one), monomials(other)]
    powers = [_powers(factors) for terms in sums for factors in terms]
    shared = reduce(lambda a, b: a & b, powers, powers[0]) if powers else Counter()
    even = {
        factor: count - count % 2
        for factor, count in shared.items()
        if count > 1 and graph.moves(graph.imported(factor))
    }
    if not even:
        return one, other
    reduced = [graph.imported(rebuilt(_divided(terms, even))) for terms in sums]
    return reduced[0], reduced[1]


def _powers(factors: tuple[Expression, ...]) -> Counter[Expression]:
    """How often each factor stands in a product; integer powers are products."""
    found: Counter[Expression] = Counter()
    for factor in factors:
        base, count = factor, 1
        if isinstance(factor, Call) and factor.function == "**":
            exponent = factor.arguments[1]
            if (
                isinstance(exponent, Number)
                and exponent.value.is_integer()
                and 0.0 < exponent.value <= _HIGHEST
            ):
                base, count = factor.arguments[0], int(exponent.value)
        found[base] += count
    return found


def _divided(terms: Monomials, even: dict[Expression, int]) -> Monomials:
    """Products without some of their factors."""
    found: Monomials = {}
    for factors, value in terms.items():
        left = _powers(factors)
        left.subtract(even)
        product = tuple(left.elements())
        found[product] = found.get(product, 0.0) + value
    return found


# ---------------------------------------------------------------- determinants


def determinant(graph: Graph, rows: Sequence[Sequence[Expression]]) -> Expression:
    """Determinant by expansion along the rows; equal minors are one node."""
    known: dict[tuple[int, ...], Expression] = {(): graph.one}

    def minor(columns: tuple[int, ...]) -> Expression:
        """Determinant of the last rows in some columns."""
        if columns not in known:
            row = rows[len(rows) - len(columns)]
            terms = []
            for k, column in enumerate(columns):
                if row[column] is not graph.zero:
                    rest = minor(columns[:k] + columns[k + 1 :])
                    term = graph.multiply(row[column], rest)
                    terms.append(graph.negate(term) if k % 2 else term)
            known[columns] = graph.add(*terms)
        return known[columns]

    return minor(tuple(range(len(rows))))
