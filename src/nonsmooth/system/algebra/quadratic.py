"""Guards that are quadratic in the states: products of two linear forms beside a linear one.

The flow of a linear mode is known in closed form, and so are products of what it moves. So a
distance, ``1 - x**2 - y**2``, need not make a mode run by series.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nonsmooth.system.algebra.linear import LinearForm, NotLinear, linear_form
from nonsmooth.system.text.expressions import Call, Expression, Name, Number, divide

__all__ = ["Quadratic", "quadratic"]

_MOST_PRODUCTS = 16  # of a guard; above that the series cost less

FormOf = Callable[[Name | Call], LinearForm]


@dataclass(frozen=True, slots=True)
class Quadratic:
    """A linear form plus products of two."""

    linear: LinearForm
    products: tuple[tuple[LinearForm, LinearForm], ...] = ()

    def plus(self, other: Quadratic) -> Quadratic:
        """Sum of two."""
        return Quadratic(self.linear.plus(other.linear), self.products + other.products)

    def scaled(self, factor: Expression) -> Quadratic:
        """Product with an expression of parameters."""
        scaled = tuple((left.scaled(factor), right) for left, right in self.products)
        return Quadratic(self.linear.scaled(factor), scaled)

    def times(self, other: Quadratic, node: Expression) -> Quadratic:
        """Product where it is quadratic again."""
        for one, two in ((self, other), (other, self)):
            if not one.products and one.linear.is_constant:
                return two.scaled(one.linear.constant_part)
        if self.products or other.products:
            raise NotLinear("this product is of a higher order than two", node)
        return Quadratic(LinearForm(), ((self.linear, other.linear),))


def quadratic(node: Expression, form_of: FormOf) -> Quadratic:
    """Linear form and products that an expression is the sum of.

    Raises
    ------
    NotLinear
        When it is anything else; with the node that is to blame.
    """
    found = _quadratic(node, form_of)
    if len(found.products) > _MOST_PRODUCTS:
        raise NotLinear(f"this has more than {_MOST_PRODUCTS} products", node)
    return found


def _quadratic(node: Expression, form_of: FormOf) -> Quadratic:
    try:
        return Quadratic(linear_form(node, form_of))
    except NotLinear:
        if not isinstance(node, Call):
            raise
        parts = node.arguments
        if node.function == "+":
            total = Quadratic(LinearForm())
            for part in parts:
                total = total.plus(_quadratic(part, form_of))
            return total
        if node.function == "neg":
            return _quadratic(parts[0], form_of).scaled(Number(-1.0))
        if node.function == "*":
            total = _quadratic(parts[0], form_of)
            for part in parts[1:]:
                total = total.times(_quadratic(part, form_of), node)
            return total
        if node.function == "/":
            below = linear_form(parts[1], form_of)
            if below.is_constant:
                inverse = divide(Number(1.0), below.constant_part)
                return _quadratic(parts[0], form_of).scaled(inverse)
        if node.function == "**" and parts[1] == Number(2.0):
            base = _quadratic(parts[0], form_of)
            return base.times(base, node)
        raise
