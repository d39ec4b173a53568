"""Instructions on Taylor series for the modes that are not linear.

Equal parts are computed once. What depends on parameters only stays an expression here and
gets a slot of the parameter tape later; harmonics are read from their coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from nonsmooth.engine import taylor_opcodes as op
from nonsmooth.system.algebra.frequencies import canonical_frequency
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import Harmonic, Input, Power, State
from nonsmooth.system.compile.mode_forms import Forms
from nonsmooth.system.compile.taylor_instructions import (
    Instruction,
    Operand,
    TaylorCode,
    fuse_products,
)
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import ZERO, Call, Expression, Name, names_in

__all__ = ["write_code"]

_ONE: Operand = Power(0)
_TIME: Operand = Power(1)


def write_code(graph: Graph, forms: Forms[Expression], mode: str) -> TaylorCode:
    """Instructions for the rates, relations, guards and resets of a mode.

    ``results`` has their operands under ("rate", state), ("guard", exit),
    ("reset", exit, state) and ("vanishing", state) for an implicit relation; a state slaved by
    an expression has the operand of that as its rate.
    """
    writer = _Writer(graph, forms)
    results = writer.code.results
    for state in graph.states:
        kind = "slaved equation" if state in forms.slaved else "rate"
        writer.place = f"the {kind} of {state!r} in mode {mode!r}"
        if state in forms.slaved:
            results["rate", state] = writer.operand(graph.name(state))
        else:
            results["rate", state] = writer.operand(forms.rates[state])
    for e, way in enumerate(forms.exits):
        writer.place = f"the guard of {way.name!r} in mode {mode!r}"
        results["guard", e] = writer.operand(way.guard)
    writer.code.middle = len(writer.code.instructions)
    for state, node in forms.implicit.items():
        writer.place = f"the slaved equation of {state!r} in mode {mode!r}"
        results["vanishing", state] = writer.copy(writer.operand(node))
    for e, way in enumerate(forms.exits):
        for state, node in way.reset.items():
            writer.place = f"the reset of {state!r} by {way.name!r} in mode {mode!r}"
            results["reset", e, state] = writer.operand(node)
    return fuse_products(writer.code)


class _Writer:
    """Writes instructions; an equal one is written once."""

    def __init__(self, graph: Graph, forms: Forms[Expression]) -> None:
        self.graph = graph
        self.forms = forms
        self.code = TaylorCode()
        self.place = ""
        self._known: dict[int, Operand] = {}
        self._terms: dict[int, tuple[Operand, Expression]] = {}
        self._written: dict[tuple[object, ...], Operand] = {}
        self._minus_one = graph.number(-1.0)

    def operand(self, node: Expression) -> Operand:
        """Operand that holds the value of a node."""
        if id(node) not in self._known:
            self._known[id(node)] = self._of(node)
        return self._known[id(node)]

    def _of(self, node: Expression) -> Operand:
        if not self.graph.moves(node):
            return self.combine({_ONE: node})
        signal = self.graph.signal_of(node)
        if signal is not None:
            return Input(*signal)
        if isinstance(node, Name):
            if node.name == "t":
                self.code.grows = self.code.grows or self.place
                return _TIME
            relation = self.forms.slaved.get(node.name)
            return State(node.name) if relation is None else self.operand(relation)
        assert isinstance(node, Call)
        return _RULES[node.function](self, node)

    def _write(
        self,
        opcode: int,
        a: Operand,
        b: Operand | None = None,
        c: Operand | None = None,
        slot: Expression | None = None,
    ) -> Operand:
        """Operand of an instruction, a new one or an equal one from before."""
        key = (opcode, a, b, c, id(slot))
        if key not in self._written:
            if slot is not None:
                self.code.constants.append((self.place, slot))
            self._written[key] = self._append(Instruction(opcode, a, b, c, slot))
        return self._written[key]

    def combine(self, terms: Mapping[Operand, Expression]) -> Operand:
        """Operand of a sum of operands times constants."""
        kept = tuple((x, c) for x, c in terms.items() if c is not self.graph.zero)
        if len(kept) == 1 and kept[0][1] is self.graph.one:
            return kept[0][0]
        key = (op.COMBINE, *((x, id(c)) for x, c in kept))
        if key not in self._written:
            self.code.constants += [(self.place, c) for _, c in kept]
            self._written[key] = self._append(Instruction(op.COMBINE, terms=kept))
        return self._written[key]

    def copy(self, operand: Operand) -> Operand:
        """A register of its own, in which the engine solves the implicit relations."""
        return self._append(Instruction(op.COMBINE, terms=((operand, self.graph.one),)))

    def _append(self, instruction: Instruction) -> int:
        self.code.instructions.append(instruction)
        return len(self.code.instructions) - 1

    # ------------------------------------------------------------ operators

    def sum_(self, node: Call) -> Operand:
        terms: dict[Operand, Expression] = {}
        for part in node.arguments:
            operand, factor = self.term(part)
            known = terms.get(operand, self.graph.zero)
            terms[operand] = self.graph.add(known, factor)
        return self.combine(terms)

    def term(self, node: Expression) -> tuple[Operand, Expression]:
        """A part of a sum as an operand and its constant factor; sums within stay whole."""
        if id(node) not in self._terms:
            self._terms[id(node)] = self._term(node)
        return self._terms[id(node)]

    def _term(self, node: Expression) -> tuple[Operand, Expression]:
        graph = self.graph
        if not graph.moves(node):
            return _ONE, node
        if isinstance(node, Call) and node.function == "neg":
            operand, factor = self.term(node.arguments[0])
            return operand, graph.multiply(self._minus_one, factor)
        if isinstance(node, Call) and node.function == "/" and not graph.moves(node.arguments[1]):
            operand, factor = self.term(node.arguments[0])
            return operand, graph.call("/", factor, node.arguments[1])
        if isinstance(node, Call) and node.function == "*":
            return self.moving_part(node)
        return self.operand(node), graph.one

    def moving_part(self, node: Call) -> tuple[Operand, Expression]:
        """A product as an operand and its constant factor."""
        constant: Expression = self.graph.one
        total: Operand | None = None
        for part in node.arguments:
            operand, factor = self.term(part)
            constant = self.graph.multiply(constant, factor)
            if self.graph.moves(part):
                total = operand if total is None else self.times(total, operand)
        assert total is not None  # the node moves
        return total, constant

    def alone(self, node: Call) -> Operand:
        """A product with constants, a negative or a quotient by a constant."""
        operand, factor = self.term(node)
        return self.combine({operand: factor})

    def times(self, left: Operand, right: Operand) -> Operand:
        if left == right:
            return self._write(op.SQUARE, left)
        return self._write(op.MULTIPLY, left, right)

    def quotient(self, node: Call) -> Operand:
        above, below = node.arguments
        if not self.graph.moves(below):
            return self.alone(node)
        return self._write(op.DIVIDE, self.operand(above), self.operand(below))

    def power(self, node: Call) -> Operand:
        base, exponent = node.arguments
        graph = self.graph
        if names_in(exponent):
            logarithm = graph.multiply(exponent, graph.call("log", base))
            return self._write(op.EXP, self.operand(logarithm))
        value = constant_value(exponent, {})
        if value.is_integer():
            return self.whole_power(self.operand(base), int(value))
        if value == 0.5:
            return self._write(op.SQRT, self.operand(base))
        return self._write(op.POWER, self.operand(base), slot=exponent)

    def whole_power(self, base: Operand, exponent: int) -> Operand:
        """Power by repeated squaring."""
        total: Operand | None = None
        square, rest = base, abs(exponent)
        while rest:
            if rest & 1:
                total = square if total is None else self.times(total, square)
            rest >>= 1
            if rest:
                square = self._write(op.SQUARE, square)
        assert total is not None  # a power of zero is the number one
        return total if exponent > 0 else self._write(op.DIVIDE, _ONE, total)

    # ------------------------------------------------------------ functions

    def circular(self, node: Call) -> Operand:
        """sin, cos and tan: of ``w*t + p`` from the coordinates, else by their recurrence."""
        (angle,) = node.arguments
        parts = self.graph.angle(angle)
        if parts is None and node.function == "tan":
            return self.with_slope(op.TAN, self.graph.one, self.operand(angle))
        if parts is None:
            sin, cos = self.pair(op.SIN, op.COS, self.operand(angle))
        else:
            cos, sin = self.harmonics(*parts)
        if node.function == "tan":
            return self._write(op.DIVIDE, sin, cos)
        return sin if node.function == "sin" else cos

    def harmonics(self, frequency: Expression, phase: Expression) -> tuple[Operand, Operand]:
        """cos and sin of ``w*t + p`` by the addition theorem."""
        graph, phase = self.graph, self.graph.imported(phase)
        cos_phase, sin_phase = graph.call("cos", phase), graph.call("sin", phase)
        positive, sign = canonical_frequency(frequency)
        if positive == ZERO:
            return self.operand(cos_phase), self.operand(sin_phase)
        self.code.frequencies.setdefault(positive)
        cos: Operand = Harmonic("cos", positive)
        sin: Operand = Harmonic("sin", positive)
        if sign < 0.0:
            sin = self.combine({sin: self._minus_one})
        if phase is graph.zero:
            return cos, sin
        minus = graph.multiply(self._minus_one, sin_phase)
        return self.combine({cos: cos_phase, sin: minus}), self.combine(
            {sin: cos_phase, cos: sin_phase}
        )

    def pair(self, first: int, second: int, a: Operand) -> tuple[Operand, Operand]:
        """Two functions whose recurrences name each other."""
        if (first, a) not in self._written:
            here = len(self.code.instructions)
            self._written[first, a] = self._append(Instruction(first, a, here + 1))
            self._written[second, a] = self._append(Instruction(second, a, here))
        return self._written[first, a], self._written[second, a]

    def hyperbolic(self, node: Call) -> Operand:
        sinh, cosh = self.pair(op.SINH, op.COSH, self.operand(node.arguments[0]))
        return sinh if node.function == "sinh" else cosh

    def tanh(self, node: Call) -> Operand:
        return self.with_slope(op.TANH, self._minus_one, self.operand(node.arguments[0]))

    def with_slope(self, opcode: int, sign: Expression, a: Operand) -> Operand:
        """tan and tanh: their slope 1 + y^2 or 1 - y^2 follows them."""
        if (opcode, a) not in self._written:
            here = self._append(Instruction(opcode, a))
            self._written[opcode, a] = here
            square = self._write(op.SQUARE, here)
            self.code.instructions[here].b = self.combine({_ONE: self.graph.one, square: sign})
        return self._written[opcode, a]

    def plain(self, node: Call) -> Operand:
        opcode = {"exp": op.EXP, "log": op.LOG, "sqrt": op.SQRT}[node.function]
        return self._write(opcode, self.operand(node.arguments[0]))

    def arc(self, node: Call) -> Operand:
        """atan, asin and acos with the slope that they need before them."""
        a, one = self.operand(node.arguments[0]), self.graph.one
        square = self._write(op.SQUARE, a)
        if node.function == "atan":
            below = self.combine({_ONE: one, square: one})
            return self._write(op.ATAN, a, self._write(op.DIVIDE, _ONE, below))
        below = self._write(op.SQRT, self.combine({_ONE: one, square: self._minus_one}))
        opcode = op.ASIN if node.function == "asin" else op.ACOS
        return self._write(opcode, a, self._write(op.DIVIDE, _ONE, below))

    def arc_of_two(self, node: Call) -> Operand:
        y, x = (self.operand(part) for part in node.arguments)
        one = self.graph.one
        squares = self.combine({self._write(op.SQUARE, x): one, self._write(op.SQUARE, y): one})
        return self._write(op.ATAN2, y, x, squares)


_RULES: dict[str, Callable[[_Writer, Call], Operand]] = {
    "+": _Writer.sum_,
    "neg": _Writer.alone,
    "*": _Writer.alone,
    "/": _Writer.quotient,
    "**": _Writer.power,
    "sin": _Writer.circular,
    "cos": _Writer.circular,
    "tan": _Writer.circular,
    "sinh": _Writer.hyperbolic,
    "cosh": _Writer.hyperbolic,
    "tanh": _Writer.tanh,
    "exp": _Writer.plain,
    "log": _Writer.plain,
    "sqrt": _Writer.plain,
    "asin": _Writer.arc,
    "acos": _Writer.arc,
    "atan": _Writer.arc,
    "atan2": _Writer.arc_of_two,
}
