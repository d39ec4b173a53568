"""Quotients of rates that stay finite: without friction, and where a common square vanishes."""

from __future__ import annotations

from collections import Counter
from functools import reduce

from nonsmooth.system.expressions import Call, Expression, Number, written_out
from nonsmooth.system.frequencies import Monomials, monomials, rebuilt
from nonsmooth.system.graph import Graph

__all__ = ["quotient", "without_squares"]

_HIGHEST = 40  # power that is written as a product
_LONGEST = 1000  # nodes of sums that are looked through


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
