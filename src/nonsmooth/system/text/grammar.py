"""Text of an equation to an expression tree.

The grammar is small and closed: numbers, names, ``+ - * / **``, parentheses, the functions of
`nonsmooth.system.text.functions`, and inside ``where`` comparisons, which ``and``, ``or`` and
``not`` may join. Text is data: its length and depth are bounded first, every character must belong
to a known token, and nothing is ever handed to Python for evaluation. Precedence is Python's.

Joined comparisons are no part of the trees: ``where(a and b, x, y)`` means
``where(a, where(b, x, y), y)``, so that each comparison has a switching function of its own.
"""

from __future__ import annotations

import keyword
import re
from itertools import pairwise
from numbers import Real
from typing import Any, NamedTuple, NoReturn

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.real_numbers import finite_real
from nonsmooth.system.text.expressions import ONE, ZERO, Call, Expression, Name, Number
from nonsmooth.system.text.functions import COMPARISONS, FUNCTIONS

__all__ = [
    "MAX_DEPTH",
    "MAX_LENGTH",
    "is_name",
    "parse",
    "parse_condition",
    "point_at",
    "why_no_name",
]

MAX_LENGTH = 10_000  # characters; longer texts are a mistake or an attack
MAX_DEPTH = 60  # nesting; keeps every recursion over trees far from Python's limit

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?P<operator>\*\*|>=|<=|[-+*/(),<>]))"
)
_EQUAL = "a motion meets single values only at instants; compare by <, <=, > or >="
_HINTS = {
    "==": _EQUAL,
    "!=": _EQUAL,
    "^": "write a power as **",
    "=": "an equation is given as a right-hand side only",
    "[": "there is no indexing",
    ".": "there are no attributes: write cos, not np.cos; a number needs a digit",
    ";": "one expression per text",
    "&": "join conditions by 'and'",
    "|": "join conditions by 'or', and write a size as abs(x)",
    "!": "write not (a > b)",
    "\N{MINUS SIGN}": "write the sign of the keyboard, -",
    "\N{MIDDLE DOT}": "write a product as *",
    "'": (
        "there are no strings inside an expression; for the rate x' write the state that it is,"
        " or rate(x)"
    ),
    '"': "there are no strings inside an expression",
}


_JOINING = ("and", "or", "not")

_OTHER_NAMES = {  # of functions, in other programs
    "arccos": "acos",
    "arcsin": "asin",
    "arctan": "atan",
    "arctan2": "atan2",
    "fabs": "abs",
    "fmax": "max",
    "fmin": "min",
    "ln": "log",
    "pow": "**",
    "sgn": "sign",
    "step": "heaviside",
}


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


def is_name(text: str) -> bool:
    """Whether the text may name a state, parameter, definition, output, mode or exit."""
    return bool(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", text)) and not keyword.iskeyword(text)


def why_no_name(name: object) -> str:
    """What an error adds where a name is a reserved word; else nothing."""
    if not isinstance(name, str) or not keyword.iskeyword(name):
        return ""
    return f": equations are read as Python reads them, where {name} is one; write {name}_"


def parse(text: str | float, *, where: str = "expression") -> Expression:
    """Expression tree of a text.

    Parameters
    ----------
    text : str or float
        The expression; a number is taken as it is.
    where : str
        What the text belongs to, for messages.

    Returns
    -------
    Expression

    Raises
    ------
    ModelError
        With a caret under the fault and what is allowed there.

    Examples
    --------
    >>> from nonsmooth.system.text.expressions import to_text
    >>> to_text(parse("a*cos(omega*t + phi) - 2*xi*y"))
    'a*cos(omega*t + phi) - 2*xi*y'
    """
    if not isinstance(text, str):
        return _number(text, where)
    if len(text) > MAX_LENGTH:
        raise ModelError(
            f"{where}: the text has {len(text):,} characters, at most {MAX_LENGTH:,} are"
            " allowed; split it with definitions"
        )
    parser = _Parser(text, where)
    tree = parser.sum_()
    parser.end()
    return tree


def parse_condition(text: str, *, where: str) -> Expression:
    """Tree of a condition such as ``xi > 0`` or ``a < b or not c < d``: one comparison."""
    if not isinstance(text, str) or len(text) > MAX_LENGTH:
        raise ModelError(f"{where}: a condition is a short text such as 'xi > 0'")
    parser = _Parser(text, where)
    condition = parser.condition("a condition is a comparison, as in xi > 0")
    parser.end()
    if condition.function in COMPARISONS:
        return condition
    return Call(">", (_choice(condition, ONE, ZERO), ZERO), condition.at)


def point_at(text: str, at: int, message: str) -> str:
    """Message followed by the part of the text around a place and a caret under it."""
    if at < 0:
        return message
    start = max(0, at - 40)
    # one column for each character, and nothing that a terminal would obey
    shown = "".join(c if c.isprintable() else " " for c in text[start : at + 40])
    lead = "..." if start else ""
    tail = "..." if at + 40 < len(text) else ""
    caret = " " * (len(lead) + at - start) + "^"
    return f"{message}\n    {lead}{shown}{tail}\n    {caret}"


def _number(value: Any, where: str) -> Number:
    """A plain number, Python's or numpy's, as an expression.

    A value that was taken from a dataset is an array without axes, and a number too.
    """
    if getattr(value, "ndim", None) == 0 and isinstance(value.item(), float | int):
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ModelError(
            f"{where}: an expression is a text or a number, such as '-2*v', not {quote(value)}"
        )
    return Number(finite_real(where, value, ModelError))


class _Parser:
    """Recursive descent over the tokens; ``depth`` bounds the recursion."""

    def __init__(self, text: str, where: str) -> None:
        self.text = text
        self.where = where
        self.tokens = list(self._tokens())
        self.index = 0
        self.depth = 0

    def _tokens(self) -> list[_Token]:
        found: list[_Token] = []
        position = 0
        end = len(self.text.rstrip())
        while position < end:
            match = _TOKEN.match(self.text, position)
            if match is None:
                position += len(self.text[position:]) - len(self.text[position:].lstrip())
                sign = self.text[position : position + 2]
                sign = sign if sign in _HINTS else sign[0]
                hint = _HINTS.get(sign, "allowed are numbers, names, + - * / ** ( ) ,")
                self.fail(position, f"{sign!r} has no meaning here; {hint}")
            kind = str(match.lastgroup)
            found.append(_Token(kind, match.group(kind), match.start(kind)))
            position = match.end()
        found.append(_Token("end", "", end))
        return found

    def fail(self, at: int, message: str) -> NoReturn:
        """Raise with a caret under the fault."""
        raise ModelError(point_at(self.text, at, f"{self.where}: {message}"))

    @property
    def here(self) -> _Token:
        return self.tokens[self.index]

    def take(self) -> _Token:
        token = self.tokens[self.index]
        self.index += 1
        return token

    def end(self) -> None:
        token = self.here
        if token.kind == "end":
            return
        if token.text in COMPARISONS or token.text in _JOINING:
            self.fail(
                token.at,
                "a condition is allowed only as the first argument of where; a guard is an"
                " expression that falls below 0, such as limit - x for x > limit",
            )
        self.fail_at_value(token)
        hint = "; a decimal point is a point, as in 0.5" if token.text == "," else ""
        self.fail(token.at, f"{token.text!r} does not belong here{hint}")

    def fail_at_value(self, token: _Token) -> None:
        """Refuse a value where an operator is expected."""
        if token.text in _JOINING:
            self.fail(
                token.at,
                f"{token.text!r} joins comparisons, as in where(a > b {token.text} c > d, x, y)",
            )
        if token.text in ("if", "else"):
            self.fail(token.at, "write a choice as where(x > 0, a, b), not with if and else")
        if token.kind in ("name", "number") or token.text == "(":
            self.fail(token.at, "an operator is missing before this; write products with *")

    def enter(self) -> None:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.fail(
                self.here.at, f"nested deeper than {MAX_DEPTH} levels; split it with definitions"
            )

    def sum_(self) -> Expression:
        self.enter()
        at = self.here.at
        terms = [self.product()]
        while self.here.text in ("+", "-"):
            sign = self.take()
            term = self.product()
            terms.append(term if sign.text == "+" else _negative(term, sign.at))
        self.depth -= 1
        return terms[0] if len(terms) == 1 else Call("+", tuple(terms), at)

    def product(self) -> Expression:
        at = self.here.at
        factors = [self.signed()]
        divisions = 0
        while self.here.text in ("*", "/"):
            operator = self.take()
            right = self.signed()
            if operator.text == "*":
                factors.append(right)
                continue
            left = factors[0] if len(factors) == 1 else Call("*", tuple(factors), at)
            factors = [Call("/", (left, right), at)]
            divisions += 1
            if divisions > MAX_DEPTH:
                self.fail(operator.at, f"more than {MAX_DEPTH} divisions in a row; use parentheses")
        return factors[0] if len(factors) == 1 else Call("*", tuple(factors), at)

    def signed(self) -> Expression:
        token = self.here
        if token.text not in ("+", "-"):
            return self.power()
        self.take()
        self.enter()
        value = self.signed()
        self.depth -= 1
        return value if token.text == "+" else _negative(value, token.at)

    def power(self) -> Expression:
        base = self.atom()
        if self.here.text != "**":
            return base
        at = self.take().at
        self.enter()
        exponent = self.signed()
        self.depth -= 1
        return Call("**", (base, exponent), at)

    def atom(self) -> Expression:
        token = self.take()
        if token.kind == "number":
            return Number(float(token.text), token.at)
        if token.kind == "name":
            return self.name(token)
        if token.text == "(":
            inner = self.sum_()
            self.close(token)
            return inner
        if token.kind == "end":
            self.fail(token.at, "the expression ends where a value is expected")
        self.fail(token.at, f"a value is expected here, not {token.text!r}")

    def name(self, token: _Token) -> Expression:
        if keyword.iskeyword(token.text):
            self.fail(
                token.at,
                f"{token.text!r} is a reserved word and cannot be a name; write {token.text}_",
            )
        if self.here.text == "(":
            return self.function(token)
        if token.text in FUNCTIONS or token.text == "rate":
            self.fail(
                token.at, f"{token.text!r} is a function and needs an argument in parentheses"
            )
        return Name(token.text, token.at)

    def function(self, token: _Token) -> Expression:
        if token.text != "rate" and token.text not in FUNCTIONS:
            known = [*FUNCTIONS, "rate"]
            here = _OTHER_NAMES.get(token.text)
            cure = f"it is {here} here" if here else "write products with *"
            self.fail(token.at, f"{unknown_name('function', token.text, known)}; {cure}")
        opening = self.take()
        before = self.depth
        hint = "where needs a comparison first, as in where(x > e, a, b)"
        arguments = [self.condition(hint) if token.text == "where" else self.sum_()]
        while self.here.text == ",":
            self.take()
            arguments.append(self.sum_())
        self.close(opening)
        self.depth = before
        least, most = (1, 1) if token.text == "rate" else _arity(token.text)
        if len(arguments) < least or (most is not None and len(arguments) > most):
            wanted = f"{least}" if most == least else f"at least {least}"
            self.fail(
                token.at, f"{token.text} takes {wanted} argument(s), {len(arguments)} are given"
            )
        if token.text == "rate" and not isinstance(arguments[0], Name):
            self.fail(token.at, "rate takes the name of a state or of a signal, as in rate(y)")
        if token.text == "where":
            condition, yes, no = arguments
            assert isinstance(condition, Call)
            return _choice(condition, yes, no, token.at)
        if token.text == "clip" and all(isinstance(each, Number) for each in arguments[1:]):
            low, high = (each.value for each in arguments[1:] if isinstance(each, Number))
            if low > high:
                self.fail(token.at, f"clip from {low:g} to {high:g}: give the lower bound first")
        return Call(token.text, tuple(arguments), token.at)

    def condition(self, hint: str) -> Call:
        """Comparisons joined by ``or``, ``and`` and ``not``, as calls of these."""
        return self.joined("or", hint)

    def joined(self, word: str, hint: str) -> Call:
        parts = [self.negated(hint) if word == "and" else self.joined("and", hint)]
        at = self.here.at
        while self.here.text == word:
            self.take()
            parts.append(self.negated(hint) if word == "and" else self.joined("and", hint))
        return parts[0] if len(parts) == 1 else Call(word, tuple(parts), at)

    def negated(self, hint: str) -> Call:
        token = self.here
        if token.text == "not":
            self.take()
            self.enter()
            return Call("not", (self.negated(hint),), token.at)
        if token.text == "(" and self.holds_condition():
            self.take()
            self.enter()
            inner = self.condition(hint)
            self.close(token)
            return inner
        return self.comparison(hint)

    def holds_condition(self) -> bool:
        """Whether the parenthesis here is around a condition, not around a value.

        What follows it tells: behind a value stands an operator or a comparison.
        """
        depth = 0
        for token, following in pairwise(self.tokens[self.index :]):
            depth += {"(": 1, ")": -1}.get(token.text, 0)
            if depth == 0:
                return following.kind == "end" or following.text in ("and", "or", ",", ")")
        return False

    def comparison(self, hint: str) -> Call:
        """One comparison, or several in a row as in ``0 < x < 1``.

        Each leaves what follows one level deeper, as it will be in the tree of choices.
        """
        values = [self.sum_()]
        parts: list[Call] = []
        if self.here.text not in COMPARISONS:
            self.fail(self.here.at, hint)
        at = self.here.at
        while self.here.text in COMPARISONS:
            token = self.take()
            self.enter()
            values.append(self.sum_())
            parts.append(Call(token.text, (values[-2], values[-1]), token.at))
        return parts[0] if len(parts) == 1 else Call("and", tuple(parts), at)

    def close(self, opening: _Token) -> None:
        token = self.here
        if token.text == ")":
            self.take()
        elif token.kind == "end":
            self.fail(opening.at, "this parenthesis is never closed")
        else:
            self.fail_at_value(token)
            self.fail(token.at, f"{token.text!r} does not belong here; ')' or ',' is expected")


def _choice(condition: Call, yes: Expression, no: Expression, at: int = -1) -> Call:
    """A choice by joined comparisons, as choices by one each."""
    if condition.function == "not":
        (denied,) = condition.arguments
        assert isinstance(denied, Call)
        return _choice(denied, no, yes, at)
    if condition.function not in _JOINING:
        return Call("where", (condition, yes, no), at)
    result: Expression = yes if condition.function == "and" else no
    for part in reversed(condition.arguments):
        assert isinstance(part, Call)
        both = (result, no) if condition.function == "and" else (yes, result)
        result = _choice(part, *both, at)
    assert isinstance(result, Call)
    return result


def _negative(term: Expression, at: int) -> Expression:
    if isinstance(term, Number):
        return Number(-term.value, at)
    return Call("neg", (term,), at)


def _arity(function: str) -> tuple[int, int | None]:
    entry = FUNCTIONS[function]
    return entry.least, entry.most
