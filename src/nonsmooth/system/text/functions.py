"""The fixed list of functions and operators that equations may use.

One table serves the grammar (names, number of arguments), the evaluation on numpy
arrays and the parameter tape of the engine, so that the three cannot disagree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from nonsmooth.engine import opcodes

__all__ = ["COMPARISONS", "FUNCTIONS", "OPERATORS", "Function", "lookup"]


@dataclass(frozen=True, slots=True)
class Function:
    """One callable of the grammar.

    ``opcode`` is its instruction on the engine's tape; functions of more than two
    arguments are lowered to several instructions and have none of their own.
    """

    name: str
    least: int
    most: int | None
    evaluate: Callable[..., Any]
    opcode: int | None
    smooth: bool = True


def _sum(*terms: Any) -> Any:
    return reduce(np.add, terms)


def _product(*factors: Any) -> Any:
    return reduce(np.multiply, factors)


def _heaviside(x: Any) -> Any:
    # one at zero, so that heaviside(x - e) and where(x > e, ...) differ only at x = e
    return np.heaviside(x, 1.0)


def _least(*values: Any) -> Any:
    return reduce(np.minimum, values)


def _greatest(*values: Any) -> Any:
    return reduce(np.maximum, values)


OPERATORS: dict[str, Function] = {
    "+": Function("+", 2, None, _sum, opcodes.ADD),
    "neg": Function("neg", 1, 1, np.negative, opcodes.NEGATE),
    "*": Function("*", 2, None, _product, opcodes.MULTIPLY),
    "/": Function("/", 2, 2, np.divide, opcodes.DIVIDE),
    "**": Function("**", 2, 2, np.power, opcodes.POWER),
}

COMPARISONS: dict[str, Function] = {
    ">": Function(">", 2, 2, np.greater, opcodes.GREATER, smooth=False),
    ">=": Function(">=", 2, 2, np.greater_equal, opcodes.GREATER_EQUAL, smooth=False),
    "<": Function("<", 2, 2, np.less, opcodes.LESS, smooth=False),
    "<=": Function("<=", 2, 2, np.less_equal, opcodes.LESS_EQUAL, smooth=False),
}

FUNCTIONS: dict[str, Function] = {
    "sin": Function("sin", 1, 1, np.sin, opcodes.SIN),
    "cos": Function("cos", 1, 1, np.cos, opcodes.COS),
    "tan": Function("tan", 1, 1, np.tan, opcodes.TAN),
    "asin": Function("asin", 1, 1, np.arcsin, opcodes.ASIN),
    "acos": Function("acos", 1, 1, np.arccos, opcodes.ACOS),
    "atan": Function("atan", 1, 1, np.arctan, opcodes.ATAN),
    "atan2": Function("atan2", 2, 2, np.arctan2, opcodes.ATAN2),
    "sinh": Function("sinh", 1, 1, np.sinh, opcodes.SINH),
    "cosh": Function("cosh", 1, 1, np.cosh, opcodes.COSH),
    "tanh": Function("tanh", 1, 1, np.tanh, opcodes.TANH),
    "exp": Function("exp", 1, 1, np.exp, opcodes.EXP),
    "log": Function("log", 1, 1, np.log, opcodes.LOG),
    "sqrt": Function("sqrt", 1, 1, np.sqrt, opcodes.SQRT),
    "sign": Function("sign", 1, 1, np.sign, opcodes.SIGN, smooth=False),
    "abs": Function("abs", 1, 1, np.abs, opcodes.ABS, smooth=False),
    "min": Function("min", 2, None, _least, opcodes.MINIMUM, smooth=False),
    "max": Function("max", 2, None, _greatest, opcodes.MAXIMUM, smooth=False),
    "heaviside": Function("heaviside", 1, 1, _heaviside, opcodes.HEAVISIDE, smooth=False),
    "clip": Function("clip", 3, 3, np.clip, None, smooth=False),
    "where": Function("where", 3, 3, np.where, None, smooth=False),
}


def lookup(name: str) -> Function:
    """Return the table entry of an operator, comparison or function by its name."""
    return OPERATORS.get(name) or COMPARISONS.get(name) or FUNCTIONS[name]
