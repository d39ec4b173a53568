"""Derivatives of expressions, node by node.

The seeds say what the derivative of each name is: rates of the states and one for ``t``
give the rate of change in time; one for a single state and zero for all else give a partial
derivative.
"""

from __future__ import annotations

from collections.abc import Callable

from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.text.expressions import Call, Expression, Name

__all__ = ["derivative", "rate_of_change"]


def rate_of_change(
    graph: Graph, node: Expression, rate_of_state: Callable[[str], Expression]
) -> Expression:
    """Rate of change of an expression in time."""

    def seed(name: str) -> Expression:
        return graph.one if name == "t" else rate_of_state(name)

    return derivative(graph, node, seed, in_time=True)


def derivative(
    graph: Graph, root: Expression, seed: Callable[[str], Expression], *, in_time: bool = False
) -> Expression:
    """Derivative of an expression; ``seed`` gives that of each state and of ``t``.

    Signals move ``in_time`` only.
    """
    known: dict[int, Expression] = {}

    def of(node: Expression) -> Expression:
        if not graph.moves(node):
            return graph.zero
        signal = graph.signal_of(node)
        if signal is not None:
            return graph.signal(signal[0], signal[1] + 1) if in_time else graph.zero
        if isinstance(node, Name):
            return seed(node.name)
        if id(node) not in known:
            assert isinstance(node, Call)
            known[id(node)] = _of_call(graph, node, of)
        return known[id(node)]

    return of(root)


def _of_call(graph: Graph, node: Call, of: Callable[[Expression], Expression]) -> Expression:
    parts = node.arguments
    rates = [of(part) for part in parts]
    if all(rate is graph.zero for rate in rates):
        return graph.zero
    if node.function == "+":
        return graph.add(*rates)
    if node.function == "neg":
        return graph.negate(rates[0])
    if node.function == "*":
        products = [
            graph.multiply(rate, *parts[:i], *parts[i + 1 :]) for i, rate in enumerate(rates)
        ]
        return graph.add(*products)
    if node.function == "/":
        (x, y), (dx, dy) = parts, rates
        change = graph.add(dx, graph.negate(graph.multiply(node, dy)))
        return graph.call("/", change, y)
    if node.function == "**":
        return _of_power(graph, node, rates)
    if node.function == "atan2":
        (y, x), (dy, dx) = parts, rates
        across = graph.add(graph.multiply(x, dy), graph.negate(graph.multiply(y, dx)))
        return graph.call("/", across, graph.add(_square(graph, x), _square(graph, y)))
    return graph.multiply(_INNER[node.function](graph, parts[0], node), rates[0])


def _of_power(graph: Graph, node: Call, rates: list[Expression]) -> Expression:
    (base, exponent), (d_base, d_exponent) = node.arguments, rates
    terms = []
    if d_base is not graph.zero:
        less = graph.call("**", base, _less_one(graph, exponent))
        terms.append(graph.multiply(exponent, less, d_base))
    if d_exponent is not graph.zero:
        terms.append(graph.multiply(node, graph.call("log", base), d_exponent))
    return graph.add(*terms)


def _less_one(graph: Graph, exponent: Expression) -> Expression:
    value = getattr(exponent, "value", None)
    if value is not None:
        return graph.number(value - 1.0)
    return graph.add(exponent, graph.number(-1.0))


def _square(graph: Graph, x: Expression) -> Expression:
    return graph.call("**", x, graph.number(2.0))


def _reciprocal(graph: Graph, x: Expression) -> Expression:
    return graph.call("/", graph.one, x)


def _arc(graph: Graph, x: Expression) -> Expression:
    below = graph.call("sqrt", graph.add(graph.one, graph.negate(_square(graph, x))))
    return _reciprocal(graph, below)


# derivative of f(x) by x from x and y = f(x)
_INNER: dict[str, Callable[[Graph, Expression, Expression], Expression]] = {
    "sin": lambda g, x, y: g.call("cos", x),
    "cos": lambda g, x, y: g.negate(g.call("sin", x)),
    "tan": lambda g, x, y: g.add(g.one, _square(g, y)),
    "asin": lambda g, x, y: _arc(g, x),
    "acos": lambda g, x, y: g.negate(_arc(g, x)),
    "atan": lambda g, x, y: _reciprocal(g, g.add(g.one, _square(g, x))),
    "sinh": lambda g, x, y: g.call("cosh", x),
    "cosh": lambda g, x, y: g.call("sinh", x),
    "tanh": lambda g, x, y: g.add(g.one, g.negate(_square(g, y))),
    "exp": lambda g, x, y: y,
    "log": lambda g, x, y: _reciprocal(g, x),
    "sqrt": lambda g, x, y: _reciprocal(g, g.multiply(g.number(2.0), y)),
}
