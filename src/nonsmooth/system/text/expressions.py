"""Expression trees: what the text of an equation means, as frozen data.

Trees are built by `nonsmooth.system.text.grammar` from text and by `add`, `multiply` and the
other builders below, which fold numbers so that derived coefficients stay short. Nothing
here knows about states, modes or time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from hashlib import blake2b

__all__ = [
    "ONE",
    "ZERO",
    "Call",
    "Expression",
    "Name",
    "Number",
    "add",
    "call",
    "divide",
    "multiply",
    "name_set",
    "names_in",
    "negate",
    "place_in_order",
    "subtract",
    "to_text",
    "walk",
    "written_out",
]


@dataclass(frozen=True, slots=True)
class Number:
    """A literal number."""

    value: float
    at: int = field(default=-1, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Name:
    """A name: state, parameter, definition, `t` or `pi`."""

    name: str
    at: int = field(default=-1, compare=False, repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Call:
    """An operator or function applied to arguments; sums and products hold many.

    Trees share parts, and written out some have more nodes than a computer has memory. So each
    node knows its hash and its size, and a short one its text: none of them is worked out twice.
    """

    function: str
    arguments: tuple[Expression, ...]
    at: int = field(default=-1, repr=False)
    size: int = field(init=False, repr=False)  # nodes, written out
    _hash: int = field(init=False, repr=False)
    _text: str = field(init=False, repr=False, default="")
    _mark: str = field(init=False, repr=False, default="")

    def __post_init__(self) -> None:
        sizes = [part.size if isinstance(part, Call) else 1 for part in self.arguments]
        object.__setattr__(self, "size", 1 + sum(sizes))
        object.__setattr__(self, "_hash", hash((self.function, self.arguments)))

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Call) or self._hash != other._hash:
            return False
        return self.function == other.function and self.arguments == other.arguments

    def __reduce__(self) -> tuple[type[Call], tuple[str, tuple[Expression, ...], int]]:
        return Call, (
            self.function,
            self.arguments,
            self.at,
        )  # hashes of texts are those of a process

    def text(self) -> str:
        """The text of the node, without parentheses around it."""
        if self._text:
            return self._text
        text = _text_of_call(self)
        if self.size <= _SHORT:
            object.__setattr__(self, "_text", text)
        return text

    def mark(self) -> str:
        """A text of fixed length that no other tree has, the same in every process."""
        if not self._mark:
            parts = [place_in_order(part)[1] for part in self.arguments]
            text = "\n".join([self.function, *parts])
            object.__setattr__(self, "_mark", blake2b(text.encode(), digest_size=16).hexdigest())
        return self._mark


Expression = Number | Name | Call

_SHORT = 200  # nodes of a tree whose text is kept

ZERO = Number(0.0)
ONE = Number(1.0)


def add(*terms: Expression) -> Expression:
    """Sum with its numbers folded into one."""
    constant = 0.0
    rest: list[Expression] = []
    for term in terms:
        parts = term.arguments if isinstance(term, Call) and term.function == "+" else (term,)
        for part in parts:
            if isinstance(part, Number):
                constant += part.value
            else:
                rest.append(part)
    if constant != 0.0 or not rest:
        rest.append(Number(constant))
    return rest[0] if len(rest) == 1 else Call("+", tuple(rest))


def multiply(*factors: Expression) -> Expression:
    """Product with its numbers folded into one; a zero factor makes zero."""
    constant = 1.0
    rest: list[Expression] = []
    for factor in factors:
        parts = (
            factor.arguments if isinstance(factor, Call) and factor.function == "*" else (factor,)
        )
        for part in parts:
            if isinstance(part, Number):
                constant *= part.value
            else:
                rest.append(part)
    if constant == 0.0 or not rest:
        return Number(constant)
    if constant == -1.0:
        return negate(rest[0] if len(rest) == 1 else Call("*", tuple(rest)))
    if constant != 1.0:
        rest.insert(0, Number(constant))
    return rest[0] if len(rest) == 1 else Call("*", tuple(rest))


def negate(x: Expression) -> Expression:
    """``-x``."""
    if isinstance(x, Number):
        return Number(-x.value) if x.value != 0.0 else ZERO
    if isinstance(x, Call) and x.function == "neg":
        return x.arguments[0]
    return Call("neg", (x,))


def subtract(x: Expression, y: Expression) -> Expression:
    """``x - y``."""
    return add(x, negate(y))


def divide(x: Expression, y: Expression) -> Expression:
    """``x / y``, unless one of them makes it trivial."""
    if x == ZERO and not isinstance(y, Number):
        return ZERO
    if y == ONE:
        return x
    if isinstance(x, Number) and isinstance(y, Number) and y.value != 0.0:
        return Number(x.value / y.value)
    return Call("/", (x, y))


def call(function: str, *arguments: Expression) -> Expression:
    """Apply a named function to arguments."""
    return Call(function, arguments)


def walk(expression: Expression) -> Iterator[Expression]:
    """Every node of the tree, parents before children."""
    stack = [expression]
    while stack:
        node = stack.pop()
        yield node
        if isinstance(node, Call):
            stack.extend(reversed(node.arguments))


def names_in(expression: Expression) -> list[Name]:
    """Return the name nodes of the tree in the order of the text; shared parts are met once."""
    names: list[Name] = []
    seen: set[int] = set()
    stack = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Name):
            names.append(node)
        elif isinstance(node, Call) and id(node) not in seen:
            seen.add(id(node))
            stack.extend(reversed(node.arguments))
    return names


def name_set(expression: Expression) -> set[str]:
    """Names in a tree, ``pi`` and ``t`` among them; parts that it shares are met once."""
    return {node.name for node in names_in(expression)}


def written_out(expressions: Iterable[Expression]) -> int:
    """Number of nodes of some trees; parts that they share count each time, at no cost."""
    return sum(node.size if isinstance(node, Call) else 1 for node in expressions)


def place_in_order(expression: Expression) -> tuple[bool, str]:
    """Key that sorts trees: short ones by their text, long ones behind them."""
    if isinstance(expression, Call) and expression.size > _SHORT:
        return True, expression.mark()
    return False, to_text(expression)


_STRENGTH = {"+": 1, "*": 2, "/": 2, "neg": 3, "**": 4}


def to_text(expression: Expression) -> str:
    """Text that parses back to an equal tree, with as few parentheses as safe."""
    return _text(expression, 0)


def _text(node: Expression, surrounding: int) -> str:
    if isinstance(node, Name):
        return node.name
    if isinstance(node, Number):
        value = node.value
        text = str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
        return f"({text})" if value < 0.0 and surrounding > 1 else text
    strength = _STRENGTH.get(node.function, surrounding)
    return f"({node.text()})" if strength < surrounding else node.text()


def _text_of_call(node: Call) -> str:
    if node.function in (">", ">=", "<", "<="):
        left, right = node.arguments
        return f"{_text(left, 0)} {node.function} {_text(right, 0)}"
    strength = _STRENGTH.get(node.function)
    if strength is None:
        return f"{node.function}({', '.join(_text(a, 0) for a in node.arguments)})"
    return _operator_text(node, strength)


def _operator_text(node: Call, strength: int) -> str:
    first, *others = node.arguments
    if isinstance(first, Call) and first.function == node.function and node.function in ("+", "*"):
        opening = f"({_text(first, 0)})"  # a sum that opens a sum keeps its parentheses
    else:
        opening = _text(first, strength)
    if node.function == "neg":
        return f"-{_text(first, strength + 1)}"
    if node.function == "**":
        return f"{_text(first, strength + 1)}**{_text(others[0], strength)}"
    if node.function == "/":
        return f"{_text(first, strength)}/{_text(others[0], strength + 1)}"
    if node.function == "*":
        return "*".join([opening, *(_text(other, strength + 1) for other in others)])
    text = opening
    for term in others:
        if isinstance(term, Call) and term.function == "neg":
            text += f" - {_text(term.arguments[0], strength + 1)}"
        elif isinstance(term, Number) and term.value < 0.0:
            text += f" - {_text(Number(-term.value), 0)}"
        else:
            text += f" + {_text(term, strength + 1)}"
    return text
