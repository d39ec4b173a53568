"""Expressions that share their nodes: equal parts are one object.

Definitions written into each other make trees of exponential size; as a graph they stay as
small as their texts. A graph knows of each node which states it depends on and whether
time stands in it, so that what depends on parameters alone is seen at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from nonsmooth.system.algebra.linear import (
    CONSTANT,
    Harmonic,
    Input,
    LinearForm,
    NotLinear,
    Power,
    State,
    linear_form,
)
from nonsmooth.system.signals import LAST_DERIVATIVE
from nonsmooth.system.text.expressions import Call, Expression, Name, Number

__all__ = ["Graph"]

_TIME = 1  # bit of time; the bits of the states and signals follow


class Graph:
    """Makes nodes and keeps one of each; nodes of one graph are equal when they are one."""

    def __init__(self, states: Sequence[str], signals: Sequence[str] = ()) -> None:
        self.states = tuple(states)
        self.signals = tuple(signals)
        self._bits = {"t": _TIME} | {name: 2 << i for i, name in enumerate((*states, *signals))}
        self._nodes: dict[tuple[object, ...], Expression] = {}
        self._depends: dict[int, int] = {}
        self._imported: dict[int, tuple[Expression, Expression]] = {}
        self._forms: dict[int, LinearForm | NotLinear] = {}
        self._angles: dict[int, tuple[Expression, Expression] | None] = {}
        self.surfaces: dict[int, Any] = {}  # switching functions worked out before
        self.zero = self.number(0.0)
        self.one = self.number(1.0)

    def number(self, value: float) -> Expression:
        """Node of a literal number."""
        return self._kept(("number", value), Number(value), 0)

    def name(self, name: str) -> Expression:
        """Node of a state, a parameter, a signal, ``t`` or ``pi``."""
        return self._kept(("name", name), Name(name), self._bits.get(name, 0))

    def signal(self, name: str, order: int) -> Expression:
        """Node of a derivative of a signal, written as rates of rates."""
        if order > LAST_DERIVATIVE:
            return self.zero
        node = self.name(name)
        for _ in range(order):
            node = self.call("rate", node)
        return node

    def signal_of(self, node: Expression) -> tuple[str, int] | None:
        """Signal and order of the derivative that a node is; None where it is anything else."""
        order = 0
        while isinstance(node, Call) and node.function == "rate":
            node, order = node.arguments[0], order + 1
        if isinstance(node, Name) and node.name in self.signals:
            return node.name, order
        return None

    def call(self, function: str, *arguments: Expression) -> Expression:
        """Node of a function or operator; what is trivial is left out."""
        simple = self._simplified(function, arguments)
        if simple is not None:
            return simple
        key = (function, *map(id, arguments))
        known = self._nodes.get(key)
        if known is not None:
            return known
        depends = 0
        for argument in arguments:
            depends |= self._depends[id(argument)]
        return self._kept(key, Call(function, arguments), depends)

    def add(self, *terms: Expression) -> Expression:
        """Sum without zeros."""
        zero = self.zero
        rest = [term for term in terms if term is not zero]
        if len(rest) < 2:
            return rest[0] if rest else zero
        return self.call("+", *rest)

    def multiply(self, *factors: Expression) -> Expression:
        """Product without ones; a zero makes zero."""
        zero, one = self.zero, self.one
        rest = []
        for factor in factors:
            if factor is zero:
                return zero
            if factor is not one:
                rest.append(factor)
        if len(rest) < 2:
            return rest[0] if rest else one
        return self.call("*", *rest)

    def negate(self, x: Expression) -> Expression:
        """``-x``, sums term by term."""
        if isinstance(x, Call) and x.function == "+":
            return self.add(*(self.negate(term) for term in x.arguments))
        return self.call("neg", x)

    def imported(self, tree: Expression) -> Expression:
        """Node of an expression that was made elsewhere, its names taken as they are."""
        if isinstance(tree, Number):
            return self.number(tree.value)
        if isinstance(tree, Name):
            return self.name(tree.name)
        if id(tree) in self._depends:  # nodes stay alive, so the number is of one of them
            return tree
        known = self._imported.get(id(tree))
        if known is None:  # kept beside its node for the same reason
            node = self.call(tree.function, *(self.imported(part) for part in tree.arguments))
            known = self._imported[id(tree)] = tree, node
        return known[1]

    def from_form(self, form: LinearForm) -> Expression:
        """Node of a linear form."""
        terms = []
        for basis, value in form.terms.items():
            coefficient = self.imported(value)
            if isinstance(basis, Power):
                power = self.call("**", self.name("t"), self.number(float(basis.order)))
                terms.append(self.multiply(coefficient, power))
            elif isinstance(basis, Harmonic):
                angle = self.multiply(self.imported(basis.frequency), self.name("t"))
                terms.append(self.multiply(coefficient, self.call(basis.kind, angle)))
            elif isinstance(basis, Input):
                terms.append(self.multiply(coefficient, self.signal(basis.name, basis.order)))
            else:
                terms.append(self.multiply(coefficient, self.name(basis.name)))
        return self.add(*terms)

    def form(self, node: Expression) -> LinearForm:
        """Linear form of a node in which rates of states were put in; `NotLinear` without one."""
        return linear_form(node, self._form_of_leaf, self._forms)

    def _form_of_leaf(self, node: Expression) -> LinearForm:
        signal = self.signal_of(node)
        if signal is not None:
            return LinearForm.of(Input(*signal))
        assert isinstance(node, Name)  # rates were put in
        if node.name == "t":
            return LinearForm.of(Power(1))
        if node.name in self.states:
            return LinearForm.of(State(node.name))
        return LinearForm.constant(node)

    def moves(self, node: Expression) -> bool:
        """Whether a state, a signal or time stands in a node."""
        return self._depends[id(node)] != 0

    def reads(self, names: Iterable[str]) -> Callable[[Expression], bool]:
        """Test of nodes: whether one of some states or signals, or time, stands in them."""
        wanted = 0
        for name in names:
            wanted |= self._bits[name]
        return lambda node: self._depends[id(node)] & wanted != 0

    def states_in(self, node: Expression) -> set[str]:
        """States that stand in a node."""
        depends = self._depends[id(node)]
        return {state for state in self.states if depends & self._bits[state]}

    def angle(self, node: Expression) -> tuple[Expression, Expression] | None:
        """Frequency and phase of ``w*t + p``; None where a node is anything else."""
        if self._depends[id(node)] != _TIME:
            return None
        if id(node) not in self._angles:
            self._angles[id(node)] = self._angle(node)
        return self._angles[id(node)]

    def _angle(self, node: Expression) -> tuple[Expression, Expression] | None:
        try:
            form = linear_form(node, _form_of_time)
        except NotLinear:
            return None
        if set(form.terms) - {CONSTANT, Power(1)}:
            return None
        return form.coefficient(Power(1)), form.constant_part

    def _simplified(self, function: str, arguments: Sequence[Expression]) -> Expression | None:
        if function == "*":
            return self.zero if any(argument is self.zero for argument in arguments) else None
        if function == "neg":
            (inner,) = arguments
            if isinstance(inner, Number):
                return self.number(-inner.value)
            if isinstance(inner, Call) and inner.function == "neg":
                return inner.arguments[0]
        elif function == "/" and arguments[1] is self.one:
            return arguments[0]
        elif function == "**" and arguments[1] is self.zero:
            return self.one
        elif function == "**" and arguments[1] is self.one:
            return arguments[0]
        return None

    def _kept(self, key: tuple[object, ...], node: Expression, depends: int) -> Expression:
        known = self._nodes.setdefault(key, node)
        self._depends.setdefault(id(known), depends)
        return known


def _form_of_time(node: Name | Call) -> LinearForm:
    assert isinstance(node, Name)
    return LinearForm.of(Power(1)) if node.name == "t" else LinearForm.constant(node)
