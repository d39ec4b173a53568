"""Values of expressions on numbers or numpy arrays, node by node from the function table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from nonsmooth.system.text.expressions import Call, Expression, Name, Number, to_text
from nonsmooth.system.text.functions import lookup

__all__ = ["constant_value", "evaluate", "evaluate_shared"]


def evaluate(expression: Expression, values: Mapping[str, Any]) -> Any:
    """Value of an expression, names taken from ``values``; arrays broadcast.

    The rate of a state is asked for under the name ``rate(state)``. Parts that the expression
    shares are worked out once.

    Division by zero and the like give ``inf`` or ``nan`` as numpy does; callers that
    need a finite value check it and say which text it came from.
    """

    def rate(node: Expression) -> Any:
        is_rate = isinstance(node, Call) and node.function == "rate"
        return values[to_text(node)] if is_rate else None

    return evaluate_shared(expression, values, {}, rate)


def _applied(function: str, arguments: list[Any]) -> Any:
    if function == "**":
        # numpy refuses integer arrays with negative powers and returns ints otherwise
        arguments = [np.asarray(a, dtype=float) for a in arguments]
    with np.errstate(all="ignore"):
        return lookup(function).evaluate(*arguments)


def evaluate_shared(
    expression: Expression,
    values: Mapping[str, Any],
    known: dict[int, Any],
    special: Callable[[Expression], Any],
) -> Any:
    """Value of an expression whose parts are shared; each is worked out once, into ``known``.

    ``special`` may give the value of a node, or None.
    """
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Name):
        return math.pi if expression.name == "pi" else values[expression.name]
    if id(expression) not in known:
        value = special(expression)
        if value is None:
            arguments = [
                evaluate_shared(argument, values, known, special)
                for argument in expression.arguments
            ]
            value = _applied(expression.function, arguments)
        known[id(expression)] = value
    return known[id(expression)]


def constant_value(expression: Expression, values: Mapping[str, float]) -> float:
    """Value of an expression of parameters only, as a float."""
    return float(evaluate(expression, values))
