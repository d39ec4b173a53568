"""Text of an equation to an expression tree.

The grammar is small and closed: numbers, names, ``+ - * / **``, parentheses, comparisons
inside ``where``, and the functions of `nonsmooth.system.functions`. Text is data: its
length and depth are bounded first, every character must belong to a known token, and
nothing is ever handed to Python for evaluation. Precedence is Python's.
"""

from __future__ import annotations

import keyword
import math
import re
from numbers import Real
from typing import NamedTuple, NoReturn

from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.expressions import Call, Expression, Name, Number
from nonsmooth.system.functions import COMPARISONS, FUNCTIONS

__all__ = ["MAX_DEPTH", "MAX_LENGTH", "is_name", "parse", "parse_condition", "point_at"]

MAX_LENGTH = 10_000  # characters; longer texts are a mistake or an attack
MAX_DEPTH = 60  # nesting; keeps every recursion over trees far from Python's limit

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?P<operator>\*\*|>=|<=|[-+*/(),<>]))"
)
_HINTS = {
    "^": "write a power as **",
    "=": "an equation is given as a right-hand side only",
    "[": "there is no indexing",
    ".": "there are no attributes: write cos, not np.cos; a number needs a digit",
    ";": "one expression per text",
    "&": "conditions are not joined; put one where into another",
    "|": "conditions are not joined; put one where into another",
    "\N{MINUS SIGN}": "write the sign of the keyboard, -",
    "\N{MIDDLE DOT}": "write a product as *",
    "'": (
        "there are no strings inside an expression; for the rate x' write the state that it is,"
        " or rate(x)"
    ),
    '"': "there are no strings inside an expression",
}


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
    >>> from nonsmooth.system.expressions import to_text
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
    """Tree of a single comparison such as ``xi > 0``."""
    if not isinstance(text, str) or len(text) > MAX_LENGTH:
        raise ModelError(f"{where}: a condition is a short text such as 'xi > 0'")
    parser = _Parser(text, where)
    tree = parser.condition("a condition is one comparison, as in xi > 0")
    parser.end()
    return tree


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


def _number(value: object, where: str) -> Number:
    """A plain number, Python's or numpy's, as an expression."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ModelError(
            f"{where}: an expression is a text or a number, such as '-2*v', not {value!r:.60}"
        )
    try:
        number = float(value)
    except OverflowError:
        raise ModelError(f"{where}: the number is too large for a double") from None
    if not math.isfinite(number):
        raise ModelError(f"{where}: {number} is not a finite number")
    return Number(number)


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
                character = self.text[position]
                hint = _HINTS.get(character, "allowed are numbers, names, + - * / ** ( ) ,")
                self.fail(position, f"{character!r} has no meaning here; {hint}")
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
        if token.text in COMPARISONS:
            self.fail(token.at, "a comparison is allowed only as the first argument of where")
        self.fail_at_value(token)
        hint = "; a decimal point is a point, as in 0.5" if token.text == "," else ""
        self.fail(token.at, f"{token.text!r} does not belong here{hint}")

    def fail_at_value(self, token: _Token) -> None:
        """Refuse a value where an operator is expected."""
        if token.text in ("and", "or"):
            self.fail(
                token.at,
                f"conditions are not joined by {token.text!r}; put one where into another, as in"
                " where(a > b, where(c > d, x, y), y)",
            )
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
        hint = "where needs a comparison first, as in where(x > e, a, b)"
        arguments = [self.condition(hint) if token.text == "where" else self.sum_()]
        while self.here.text == ",":
            self.take()
            arguments.append(self.sum_())
        self.close(opening)
        least, most = (1, 1) if token.text == "rate" else _arity(token.text)
        if len(arguments) < least or (most is not None and len(arguments) > most):
            wanted = f"{least}" if most == least else f"at least {least}"
            self.fail(
                token.at, f"{token.text} takes {wanted} argument(s), {len(arguments)} are given"
            )
        if token.text == "rate" and not isinstance(arguments[0], Name):
            self.fail(token.at, "rate takes the name of a state or of a signal, as in rate(y)")
        return Call(token.text, tuple(arguments), token.at)

    def condition(self, hint: str) -> Expression:
        left = self.sum_()
        token = self.here
        if token.text not in COMPARISONS:
            self.fail(token.at, hint)
        self.take()
        return Call(token.text, (left, self.sum_()), token.at)

    def close(self, opening: _Token) -> None:
        token = self.here
        if token.text == ")":
            self.take()
        elif token.kind == "end":
            self.fail(opening.at, "this parenthesis is never closed")
        else:
            self.fail_at_value(token)
            self.fail(token.at, f"{token.text!r} does not belong here; ')' or ',' is expected")


def _negative(term: Expression, at: int) -> Expression:
    if isinstance(term, Number):
        return Number(-term.value, at)
    return Call("neg", (term,), at)


def _arity(function: str) -> tuple[int, int | None]:
    entry = FUNCTIONS[function]
    return entry.least, entry.most
