"""One spelling for each frequency, so that ``cos(2*w*t)`` and ``cos(w*t + w*t)`` meet.

A frequency is an expression of parameters. It is written as a sum of numbers times
products, with like products collected and everything in one order.
"""

from __future__ import annotations

from nonsmooth.system.text.expressions import (
    Call,
    Expression,
    Number,
    add,
    divide,
    multiply,
    place_in_order,
)

__all__ = ["canonical_frequency", "monomials", "rebuilt"]

Monomials = dict[tuple[Expression, ...], float]
_MOST_MONOMIALS = 200  # of a product; beyond, the product stays as it is written
_MOST_FACTORS = 40  # of a monomial


def canonical_frequency(frequency: Expression) -> tuple[Expression, float]:
    """Frequency in its one spelling, leading term positive, and the sign taken out.

    Zero comes back as the number zero.
    """
    terms = monomials(frequency)
    ordered = sorted(terms.items(), key=lambda item: [place_in_order(factor) for factor in item[0]])
    if not ordered:
        return Number(0.0), 1.0
    sign = -1.0 if ordered[0][1] < 0.0 else 1.0
    parts = [multiply(Number(sign * value), *factors) for factors, value in ordered]
    return add(*parts), sign


def monomials(expression: Expression) -> Monomials:
    """Coefficient of each product of factors; zeros are left out."""
    return _monomials(expression, {})


def _monomials(expression: Expression, known: dict[int, Monomials]) -> Monomials:
    """The same; parts that are shared are worked out once, into ``known``."""
    if id(expression) not in known:
        if isinstance(expression, Call):
            parts = [_monomials(argument, known) for argument in expression.arguments]
            known[id(expression)] = _of_call(expression, parts)
        elif isinstance(expression, Number):
            value = expression.value
            known[id(expression)] = {(): value} if value != 0.0 else {}
        else:
            known[id(expression)] = {(expression,): 1.0}
    return known[id(expression)]


def _of_call(call: Call, parts: list[Monomials]) -> Monomials:
    if call.function == "+":
        return _sum(parts)
    if call.function == "neg":
        return {factors: -value for factors, value in parts[0].items()}
    if call.function == "*":
        product: Monomials = {(): 1.0}
        for part in parts:
            if _is_large(product, part):
                return {(call,): 1.0}
            product = _product(product, part)
        return product
    if call.function == "/" and not _is_large(parts[0], parts[1]):
        return _product(parts[0], _reciprocal(parts[1]))
    return {(Call(call.function, tuple(rebuilt(part) for part in parts)),): 1.0}


def _sum(parts: list[Monomials]) -> Monomials:
    total: Monomials = {}
    for part in parts:
        for factors, value in part.items():
            total[factors] = total.get(factors, 0.0) + value
    return {factors: value for factors, value in total.items() if value != 0.0}


def _is_large(left: Monomials, right: Monomials) -> bool:
    """Whether a product would have so many terms that collecting them takes seconds."""
    factors = sum(max(map(len, terms), default=0) for terms in (left, right))
    return len(left) * len(right) > _MOST_MONOMIALS or factors > _MOST_FACTORS


def _product(left: Monomials, right: Monomials) -> Monomials:
    parts = [
        {tuple(sorted((*a, *b), key=place_in_order)): x * y}
        for a, x in left.items()
        for b, y in right.items()
    ]
    return _sum(parts)


def _reciprocal(terms: Monomials) -> Monomials:
    """One over a sum; over a single product each factor is inverted on its own."""
    if len(terms) == 1:
        (factors, value), *_ = terms.items()
        if value != 0.0:
            inverse = tuple(divide(Number(1.0), factor) for factor in factors)
            return {tuple(sorted(inverse, key=place_in_order)): 1.0 / value}
    return {(divide(Number(1.0), rebuilt(terms)),): 1.0}


def rebuilt(terms: Monomials) -> Expression:
    """Sum of products in one order."""
    ordered = sorted(terms.items(), key=lambda item: [place_in_order(factor) for factor in item[0]])
    return add(*(multiply(Number(value), *factors) for factors, value in ordered))
