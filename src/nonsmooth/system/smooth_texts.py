"""Expressions in which smooth functions stand for the piecewise ones.

Every call chooses between sides by the sign of a switching function u. Two replacements are
enough for all of them: a smooth sign s(u), which goes from -1 to 1 over a width epsilon, and an
absolute value made with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from nonsmooth.errors import ModelError
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.text.expressions import (
    ONE,
    ZERO,
    Call,
    Expression,
    Name,
    Number,
    add,
    call,
    divide,
    multiply,
    negate,
    subtract,
    to_text,
    written_out,
)
from nonsmooth.system.text.functions import COMPARISONS, lookup

__all__ = ["KINDS", "Scope", "Smoother"]

_LONGEST = 40  # nodes of a part that is written out in place; a longer one gets a name
_TWO = Number(2.0)


def _tanh(u: Expression, width: Expression) -> Expression:
    return call("tanh", divide(u, width))


def _arctan(u: Expression, width: Expression) -> Expression:
    return divide(multiply(_TWO, call("atan", divide(u, width))), Name("pi"))


def _logistic(u: Expression, width: Expression) -> Expression:
    # 2/(1 + exp(-u/width)) - 1 in a form in which nothing overflows
    return call("tanh", divide(u, multiply(_TWO, width)))


def _root(u: Expression, width: Expression) -> Expression:
    """``sqrt(u**2 + width**2)``."""
    return call("sqrt", add(call("**", u, _TWO), call("**", width, _TWO)))


def _sqrt(u: Expression, width: Expression) -> Expression:
    return divide(u, _root(u, width))


KINDS: dict[str, Callable[[Expression, Expression], Expression]] = {
    "tanh": _tanh,
    "arctan": _arctan,
    "logistic": _logistic,
    "sqrt": _sqrt,
}


@dataclass
class Scope:
    """Which expressions of a text change along a motion.

    ``definitions`` are those of the mode of the text, or of all modes where the text is shared:
    a name then counts as moving when it does in any of them.
    """

    moving: frozenset[str]  # states, signals and time
    definitions: Sequence[Mapping[str, Equation]]
    _known: dict[str, bool] = field(default_factory=dict)

    def moves(self, node: Expression) -> bool:
        """Whether a state, a signal or time stands in a tree."""
        if isinstance(node, Number):
            return False
        if isinstance(node, Call):
            return node.function == "rate" or any(map(self.moves, node.arguments))
        if node.name not in self._known:
            self._known[node.name] = node.name in self.moving or any(
                self.moves(own[node.name].tree) for own in self.definitions if node.name in own
            )
        return self._known[node.name]

    def meanings(self, name: str) -> list[Expression]:
        """Trees of a definition."""
        return [own[name].tree for own in self.definitions if name in own]


@dataclass
class Smoother:
    """Replaces piecewise calls of what moves; ``named`` holds long parts that got a name.

    Names mean in each mode what they mean there, so a part has one text for all modes.
    """

    kind: str
    width: Expression
    taken: set[str]
    named: dict[str, Expression] = field(default_factory=dict)
    count: int = 0
    _names: dict[str, str] = field(default_factory=dict)

    def smooth(self, node: Expression, scope: Scope, where: str) -> Expression:
        """Tree with smooth calls; the same object where nothing had to be replaced."""
        if not isinstance(node, Call) or node.function == "rate":
            return node
        self._check_root(node, scope, where)
        arguments = tuple(self.smooth(a, scope, where) for a in node.arguments)
        replaced = self._replaced(node, arguments, scope)
        if replaced is not None:
            self.count += 1
            return replaced
        if all(new is old for new, old in zip(arguments, node.arguments, strict=True)):
            return node
        return Call(node.function, arguments)

    def _replaced(
        self, node: Call, arguments: tuple[Expression, ...], scope: Scope
    ) -> Expression | None:
        """What stands for a call; None where it is smooth, or decided by parameters alone."""
        if lookup(node.function).smooth or node.function in COMPARISONS:
            return None
        moves = [scope.moves(argument) for argument in node.arguments]
        if node.function == "where":
            return self._where(*arguments) if moves[0] else None
        if not any(moves):
            return None
        parts = [self._short(argument) for argument in arguments]
        if node.function == "sign":
            return self.sign(parts[0])
        if node.function == "heaviside":
            return self._weighted(ONE, parts[0])
        if node.function == "abs":
            return self.size(parts[0])
        if node.function == "clip":
            return self._clip(*parts)
        return self._extreme(node.function, parts, moves)

    # ------------------------------------------------------------ the two that are enough

    def sign(self, u: Expression) -> Expression:
        """Smooth sign of a switching function."""
        return KINDS[self.kind](u, self.width)

    def size(self, u: Expression) -> Expression:
        """Smooth absolute value: the two sides weighted, or for ``sqrt`` the root itself."""
        return _root(u, self.width) if self.kind == "sqrt" else multiply(u, self.sign(u))

    def _weighted(self, side: Expression, u: Expression, sign: int = 1) -> Expression:
        """A side with its weight, that of u > 0 or, with the other sign, of u < 0."""
        smooth = self.sign(u)
        weight = add(ONE, smooth if sign > 0 else negate(smooth))
        return divide(multiply(side, weight), _TWO)

    def _chosen(self, u: Expression, above: Expression, below: Expression) -> Expression:
        """Both sides of a switching function with their weights."""
        return add(self._weighted(above, u), self._weighted(below, u, -1))

    # ------------------------------------------------------------ calls made of them

    def _where(self, condition: Expression, yes: Expression, no: Expression) -> Expression:
        assert isinstance(condition, Call)  # the grammar admits nothing else
        u = self._short(subtract(*condition.arguments))
        yes, no = self._short(yes), self._short(no)
        above, below = (yes, no) if condition.function in (">", ">=") else (no, yes)
        return self._chosen(u, above, below)

    def _clip(self, x: Expression, low: Expression, high: Expression) -> Expression:
        """Of both bounds alike, so that a symmetric one stays symmetric."""
        to_low, to_high = (self._short(subtract(x, bound)) for bound in (low, high))
        total = add(low, high, self.size(to_low), negate(self.size(to_high)))
        return divide(total, _TWO)

    def _extreme(self, function: str, parts: list[Expression], moves: list[bool]) -> Expression:
        """``max`` or ``min`` of several, one after the other."""
        found, moving = parts[0], moves[0]
        for other, other_moves in zip(parts[1:], moves[1:], strict=True):
            moving = moving or other_moves
            if moving:
                found = self._short(self._greater(function, found, other))
            else:
                found = Call(function, (found, other))
        return found

    def _greater(self, function: str, a: Expression, b: Expression) -> Expression:
        """``max`` or ``min`` of two."""
        u = self._short(subtract(a, b))
        if self.kind == "sqrt":
            size = self.size(u)
            return divide(add(a, b, size if function == "max" else negate(size)), _TWO)
        return self._chosen(u, a, b) if function == "max" else self._chosen(u, b, a)

    # ------------------------------------------------------------ names for long parts

    def _short(self, node: Expression) -> Expression:
        """The tree, or where it is long a name for it: it may be needed several times."""
        if written_out([node]) <= _LONGEST:
            return node
        text = to_text(node)
        if text not in self._names:
            number = len(self.named) + 1
            while f"part_{number}" in self.taken:
                number += 1
            name = f"part_{number}"
            self.taken.add(name)
            self._names[text], self.named[name] = name, node
        return Name(self._names[text])

    # ------------------------------------------------------------ what has no value below zero

    def _check_root(self, node: Call, scope: Scope, where: str) -> None:
        """Refuse a root of what touches zero: weighted sides go through zero there."""
        if self.kind == "sqrt" or not _is_root(node) or not scope.moves(node.arguments[0]):
            return
        if _touches_zero(node.arguments[0], scope):
            raise ModelError(
                f"{where}: {to_text(node):.80} has a call in it that ends at zero, and smoothed by"
                f" {self.kind!r} it goes through zero, where this has no value; take kind='sqrt',"
                " which stays above zero"
            )


def _is_root(node: Call) -> bool:
    """Whether a call needs a first argument that is positive."""
    if node.function == "**":
        exponent = node.arguments[1]
        return not (isinstance(exponent, Number) and exponent.value.is_integer())
    return node.function in ("sqrt", "log")


def _touches_zero(node: Expression, scope: Scope) -> bool:
    """Whether a tree is ``abs(u)`` or ``max(u, 0)``, or a multiple of one."""
    if isinstance(node, Name):
        return any(_touches_zero(tree, scope) for tree in scope.meanings(node.name))
    if isinstance(node, Number):
        return False
    if node.function in ("neg", "*"):
        return any(_touches_zero(argument, scope) for argument in node.arguments)
    if node.function == "/":
        return _touches_zero(node.arguments[0], scope)
    ends = node.function in ("min", "max") and ZERO in node.arguments
    return (node.function == "abs" or ends) and scope.moves(node)
