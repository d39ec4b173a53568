"""Check of the names and expressions that go into the text of a law.

The grammar of equations belongs to systems, which this package does not know; a system looks at the
whole text once more. Here only what would break the text about it is refused.
"""

from __future__ import annotations

import ast
import re
from typing import Any

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import finite

__all__ = ["expression_text"]

_CHARACTERS = re.compile(r"[A-Za-z0-9_.+\-*/(),<>=\s]+")
_LONGEST = 10_000  # characters, as of an equation
_PARTS = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Compare, ast.Call, ast.Name, ast.Constant,
    ast.operator, ast.unaryop, ast.cmpop, ast.expr_context,
)  # fmt: skip


def expression_text(name: str, text: Any) -> str:
    """One expression as it was given, a number as text."""
    if not isinstance(text, str):
        return repr(finite(name, text))
    line = " ".join(text.split())  # Python reads lines, an equation does not
    if not _is_expression(line):
        raise OptionError(
            f"{name} = {quote(text)}: give a name or one whole expression of numbers, names,"
            " + - * / **, parentheses and functions, such as 'crack' or '5 + 1e-3*t'"
        )
    return text


def _is_expression(line: str) -> bool:
    if len(line) > _LONGEST or not _CHARACTERS.fullmatch(line):
        return False
    try:
        tree = ast.parse(line, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    known = all(isinstance(node, _PARTS) for node in ast.walk(tree))
    return known and not isinstance(tree.body, ast.Compare)
