"""Which signs of some functions exclude each other, by linear arithmetic on their terms.

``x - e > 0`` and ``-x - e > 0`` add up to ``-2*e > 0``, which a requirement ``e > 0`` excludes.
Each product of names counts as a quantity of its own, so what is excluded cannot be, and what is
not excluded may still be impossible.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from nonsmooth.system.algebra.frequencies import monomials
from nonsmooth.system.text.expressions import Call, Expression

__all__ = ["Inequality", "excluded", "inequality_of"]

_MOST = 200  # inequalities; more of them take long, and exclude nothing here


class Inequality(NamedTuple):
    """A sum of quantities, each times a number, that is positive, or not negative."""

    terms: Mapping[Any, Fraction]
    strict: bool


ONE_IS_POSITIVE = Inequality({(): Fraction(1)}, strict=True)  # the product of no factor


def inequality_of(condition: Expression) -> Inequality | None:
    """A comparison as an inequality; None for what is none, or has a number without a value."""
    if not isinstance(condition, Call) or condition.function not in (">", ">=", "<", "<="):
        return None
    left, right = condition.arguments
    if condition.function in ("<", "<="):
        left, right = right, left
    try:
        terms = {key: Fraction(value) for key, value in monomials(left).items()}
        for key, value in monomials(right).items():
            terms[key] = terms.get(key, Fraction(0)) - Fraction(value)
    except (ValueError, OverflowError):  # nan, infinity
        return None
    return Inequality(terms, strict=condition.function in (">", "<"))


def excluded(inequalities: Iterable[Inequality]) -> bool:
    """Whether some inequalities contradict each other, by Fourier's and Motzkin's elimination."""
    open_ = [_reduced(each) for each in (*inequalities, ONE_IS_POSITIVE)]
    while True:
        if any(each.strict and not each.terms for each in open_):
            return True
        quantities = {key for each in open_ for key in each.terms}
        if not quantities:
            return False
        chosen = min(quantities, key=lambda key: _products(open_, key))
        open_ = _without(open_, chosen)
        if len(open_) > _MOST:
            return False


def _reduced(inequality: Inequality) -> Inequality:
    terms = {key: value for key, value in inequality.terms.items() if value}
    return Inequality(terms, inequality.strict)


def _sides(open_: list[Inequality], key: Hashable) -> tuple[list[Inequality], list[Inequality]]:
    """Inequalities in which a quantity has a positive and a negative factor."""
    above = [each for each in open_ if each.terms.get(key, 0) > 0]
    below = [each for each in open_ if each.terms.get(key, 0) < 0]
    return above, below


def _products(open_: list[Inequality], key: Hashable) -> int:
    above, below = _sides(open_, key)
    return len(above) * len(below)


def _without(open_: list[Inequality], key: Hashable) -> list[Inequality]:
    """The same without a quantity: sums of every two in which it cancels."""
    above, below = _sides(open_, key)
    found = [each for each in open_ if key not in each.terms]
    for one in above:
        for other in below:
            a, b = -other.terms[key], one.terms[key]
            terms = {name: a * value for name, value in one.terms.items()}
            for name, value in other.terms.items():
                terms[name] = terms.get(name, Fraction(0)) + b * value
            found.append(_reduced(Inequality(terms, one.strict or other.strict)))
    return found
