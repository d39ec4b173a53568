"""Recognition of expressions that are linear in the states.

A `LinearForm` is a sum of coefficients times basis functions: the states, powers of
time, the harmonics cos(w t), sin(w t) of any number of frequencies, and signals. Coefficients and
frequencies are expressions of parameters only, so a form is exact and stays valid for
every parameter value. Products of harmonics are rewritten as sums, nothing is
approximated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from nonsmooth.system.algebra.frequencies import canonical_frequency
from nonsmooth.system.signals import LAST_DERIVATIVE
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
)

__all__ = [
    "CONSTANT",
    "Basis",
    "Harmonic",
    "Input",
    "LinearForm",
    "NotLinear",
    "Power",
    "State",
    "linear_form",
]

_MAX_POWER = 6  # of time; higher ones are more likely a mistake than a model
_MAX_TERMS = 256  # of a product, which doubles with each harmonic factor


@dataclass(frozen=True, slots=True)
class State:
    """A state as basis function."""

    name: str


@dataclass(frozen=True, slots=True)
class Power:
    """A power of time as basis function; order 0 is the constant one."""

    order: int


@dataclass(frozen=True, slots=True)
class Harmonic:
    """cos(w t) or sin(w t) as basis function."""

    kind: Literal["cos", "sin"]
    frequency: Expression


@dataclass(frozen=True, slots=True)
class Input:
    """A signal, or a derivative of it, as basis function."""

    name: str
    order: int


Basis = State | Power | Harmonic | Input
CONSTANT = Power(0)


class NotLinear(Exception):
    """The expression is not linear; carries the reason and the node."""

    def __init__(self, reason: str, node: Expression) -> None:
        super().__init__(reason)
        self.reason = reason
        self.node = node


class LinearForm:
    """Coefficients by basis function; the algebra that recognition needs."""

    __slots__ = ("terms",)

    def __init__(self, terms: dict[Basis, Expression] | None = None) -> None:
        self.terms = {b: c for b, c in (terms or {}).items() if c != ZERO}

    @classmethod
    def of(cls, basis: Basis) -> LinearForm:
        """Form of one basis function."""
        return cls({basis: ONE})

    @classmethod
    def constant(cls, value: Expression) -> LinearForm:
        """Form of a constant, an expression of parameters."""
        return cls({CONSTANT: value})

    @property
    def is_constant(self) -> bool:
        """Whether neither states nor time appear."""
        return all(basis == CONSTANT for basis in self.terms)

    @property
    def constant_part(self) -> Expression:
        """Coefficient of the constant."""
        return self.terms.get(CONSTANT, ZERO)

    def coefficient(self, basis: Basis) -> Expression:
        """Coefficient of one basis function, zero where it does not appear."""
        return self.terms.get(basis, ZERO)

    def plus(self, other: LinearForm) -> LinearForm:
        """Sum of two forms."""
        return _total((self, other))

    def scaled(self, factor: Expression) -> LinearForm:
        """Product with an expression of parameters."""
        return LinearForm({b: multiply(factor, c) for b, c in self.terms.items()})

    def divided(self, divisor: Expression) -> LinearForm:
        """Quotient by an expression of parameters."""
        return LinearForm({b: divide(c, divisor) for b, c in self.terms.items()})

    def times(self, other: LinearForm, node: Expression) -> LinearForm:
        """Product of two forms where it is a form again."""
        if self.is_constant:
            return other.scaled(self.constant_part)
        if other.is_constant:
            return self.scaled(other.constant_part)
        if len(self.terms) * len(other.terms) > _MAX_TERMS:
            raise NotLinear(f"this product has more than {_MAX_TERMS} terms", node)
        return _total(
            _basis_product(left, right, node).scaled(multiply(left_value, right_value))
            for left, left_value in self.terms.items()
            for right, right_value in other.terms.items()
        )

    def with_replaced(self, forms: Mapping[str, LinearForm]) -> LinearForm:
        """Form with some states replaced by forms of their own."""
        if not any(isinstance(b, State) and b.name in forms for b in self.terms):
            return self
        return _total(
            forms[basis.name].scaled(value)
            if isinstance(basis, State) and basis.name in forms
            else LinearForm({basis: value})
            for basis, value in self.terms.items()
        )

    def rate(self, rate_of_state: Callable[[str], LinearForm]) -> LinearForm:
        """Time derivative along a flow given by the rates of the states."""
        return _total(
            _basis_rate(basis, rate_of_state).scaled(value) for basis, value in self.terms.items()
        )


def _total(forms: Iterable[LinearForm]) -> LinearForm:
    """Sum of forms, collected in one dict: hashing long expressions is what costs."""
    terms: dict[Basis, Expression] = {}
    for form in forms:
        for basis, value in form.terms.items():
            present = terms.get(basis)
            total = value if present is None else add(present, value)
            if total == ZERO:
                del terms[basis]
            else:
                terms[basis] = total
    return LinearForm(terms)


def linear_form(
    expression: Expression,
    form_of: Callable[[Name | Call], LinearForm],
    known: dict[int, LinearForm | NotLinear] | None = None,
) -> LinearForm:
    """Linear form of an expression.

    Parameters
    ----------
    expression : Expression
        The tree.
    form_of : callable
        Form of a name, or of a call of ``rate``.
    known : dict, optional
        What parts have come to before, by their numbers; for parts that stay alive.

    Raises
    ------
    NotLinear
        With the node that is to blame.
    """
    if isinstance(expression, Number):
        return LinearForm.constant(expression)
    known = {} if known is None else known
    if id(expression) not in known:
        try:
            known[id(expression)] = _form(expression, form_of, known)
        except NotLinear as fault:
            known[id(expression)] = NotLinear(fault.reason, fault.node)
    found = known[id(expression)]
    if isinstance(found, NotLinear):
        raise NotLinear(found.reason, found.node)
    return found


def _form(
    expression: Name | Call,
    form_of: Callable[[Name | Call], LinearForm],
    known: dict[int, LinearForm | NotLinear],
) -> LinearForm:
    """The same for an expression that was not met before."""
    if isinstance(expression, Name) or expression.function == "rate":
        return form_of(expression)
    arguments = [linear_form(argument, form_of, known) for argument in expression.arguments]
    if all(argument.is_constant for argument in arguments):
        return _constant_call(expression, arguments)
    rule = _RULES.get(expression.function)
    if rule is None:
        raise NotLinear(f"{expression.function} of a state or of time is not linear", expression)
    return rule(expression, arguments)


def _constant_call(node: Call, arguments: list[LinearForm]) -> LinearForm:
    values = [argument.constant_part for argument in arguments]
    folding: dict[str, Callable[..., Expression]] = {
        "+": add,
        "*": multiply,
        "/": divide,
        "neg": negate,
    }
    return LinearForm.constant(folding.get(node.function, _plain(node.function))(*values))


def _plain(function: str) -> Callable[..., Expression]:
    return lambda *values: call(function, *values)


def _sum(node: Call, arguments: list[LinearForm]) -> LinearForm:
    return _total(arguments)


def _negative(node: Call, arguments: list[LinearForm]) -> LinearForm:
    return arguments[0].scaled(Number(-1.0))


def _product(node: Call, arguments: list[LinearForm]) -> LinearForm:
    total = arguments[0]
    for argument in arguments[1:]:
        total = total.times(argument, node)
    return total


def _quotient(node: Call, arguments: list[LinearForm]) -> LinearForm:
    above, below = arguments
    if not below.is_constant:
        raise NotLinear("division by a state or by time is not linear", node)
    return above.divided(below.constant_part)


def _power(node: Call, arguments: list[LinearForm]) -> LinearForm:
    base = arguments[0]
    exponent = node.arguments[1]
    if not isinstance(exponent, Number) or exponent.value not in range(1, _MAX_POWER + 1):
        raise NotLinear("this power of a state or of time is not linear", node)
    total = base
    for _ in range(int(exponent.value) - 1):
        total = total.times(base, node)
    return total


def _harmonic(node: Call, arguments: list[LinearForm]) -> LinearForm:
    """cos or sin of ``w t + p``, split by the addition theorem."""
    angle = arguments[0]
    if set(angle.terms) - {CONSTANT, Power(1)}:
        raise NotLinear(f"{node.function} of anything but w*t + phase is not linear", node)
    phase = angle.constant_part
    cos, sin = _harmonic_pair(angle.coefficient(Power(1)))
    if phase == ZERO:
        return cos if node.function == "cos" else sin
    cos_phase, sin_phase = call("cos", phase), call("sin", phase)
    if node.function == "cos":
        return cos.scaled(cos_phase).plus(sin.scaled(negate(sin_phase)))
    return sin.scaled(cos_phase).plus(cos.scaled(sin_phase))


def _selection(node: Call, arguments: list[LinearForm]) -> LinearForm:
    """``where`` by a condition on parameters: a selection of each coefficient."""
    condition, yes, no = arguments
    if not condition.is_constant:
        raise NotLinear("where by a state or by time is not linear", node)
    chosen = condition.constant_part
    return LinearForm(
        {
            basis: call("where", chosen, yes.coefficient(basis), no.coefficient(basis))
            for basis in (*yes.terms, *(b for b in no.terms if b not in yes.terms))
        }
    )


_RULES: dict[str, Callable[[Call, list[LinearForm]], LinearForm]] = {
    "+": _sum,
    "neg": _negative,
    "*": _product,
    "/": _quotient,
    "**": _power,
    "cos": _harmonic,
    "sin": _harmonic,
    "where": _selection,
}


def _harmonic_pair(frequency: Expression) -> tuple[LinearForm, LinearForm]:
    """Forms of cos(w t) and sin(w t); one spelling per frequency, sign taken out."""
    positive, sign = canonical_frequency(frequency)
    if positive == ZERO:
        return LinearForm.constant(ONE), LinearForm()
    cos = LinearForm.of(Harmonic("cos", positive))
    return cos, LinearForm.of(Harmonic("sin", positive)).scaled(Number(sign))


def _basis_product(left: Basis, right: Basis, node: Expression) -> LinearForm:
    if left == CONSTANT:
        return LinearForm.of(right)
    if right == CONSTANT:
        return LinearForm.of(left)
    if isinstance(left, State) or isinstance(right, State):
        both = isinstance(left, State) and isinstance(right, State)
        reason = "a product of states" if both else "a state multiplied by a function of time"
        raise NotLinear(f"{reason} is not linear", node)
    if isinstance(left, Input) or isinstance(right, Input):
        raise NotLinear("a signal multiplied by another function of time is not linear", node)
    if isinstance(left, Power) and isinstance(right, Power):
        if left.order + right.order > _MAX_POWER:
            raise NotLinear(f"powers of time above {_MAX_POWER} are not supported", node)
        return LinearForm.of(Power(left.order + right.order))
    if isinstance(left, Harmonic) and isinstance(right, Harmonic):
        return _harmonic_product(left, right)
    raise NotLinear("time multiplied by a harmonic is not supported", node)


def _harmonic_product(left: Harmonic, right: Harmonic) -> LinearForm:
    """Product-to-sum formulas."""
    cos_d, sin_d = _harmonic_pair(subtract(left.frequency, right.frequency))
    cos_s, sin_s = _harmonic_pair(add(left.frequency, right.frequency))
    minus = Number(-1.0)
    if left.kind == right.kind:
        sign = ONE if left.kind == "cos" else minus
        total = cos_d.plus(cos_s.scaled(sign))
    else:
        sign = ONE if left.kind == "sin" else minus
        total = sin_s.plus(sin_d.scaled(sign))
    return total.scaled(Number(0.5))


def _basis_rate(basis: Basis, rate_of_state: Callable[[str], LinearForm]) -> LinearForm:
    if isinstance(basis, State):
        return rate_of_state(basis.name)
    if isinstance(basis, Power):
        if basis.order == 0:
            return LinearForm()
        return LinearForm({Power(basis.order - 1): Number(float(basis.order))})
    if isinstance(basis, Input):
        last = basis.order == LAST_DERIVATIVE
        return LinearForm() if last else LinearForm.of(Input(basis.name, basis.order + 1))
    if basis.kind == "cos":
        return LinearForm({Harmonic("sin", basis.frequency): negate(basis.frequency)})
    return LinearForm({Harmonic("cos", basis.frequency): basis.frequency})
