"""Rows of text in columns, numbers with errors, text that no terminal takes for a command."""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["aligned", "harmless", "one_line", "with_error"]

_WIDEST = 48  # characters; a longer cell pushes its own row aside and no other


def aligned(rows: Sequence[Sequence[str]], indent: int = 2) -> list[str]:
    """Lines with the cells of all rows below each other."""
    cells = [[one_line(cell) for cell in row] for row in rows]
    columns = max((len(row) for row in cells), default=0)
    widths = [
        max((len(row[i]) for row in cells if i < len(row) and len(row[i]) <= _WIDEST), default=0)
        for i in range(columns)
    ]
    return [
        (
            " " * indent
            + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False))
        ).rstrip()
        for row in cells
    ]


def one_line(text: str) -> str:
    """Text with blanks for line breaks and tabs, and nothing that a terminal obeys."""
    return harmless(" ".join(text.split()))


def harmless(text: str) -> str:
    """Text with escapes for all control characters but the line break."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def with_error(value: float, error: float, digits: int = 4, of_error: int = 1) -> str:
    """A number with so many digits and its standard error, where there is one.

    An error below the rounding of the digits would tell nothing of them.
    """
    text = f"{value:.{digits}g}"
    size = math.log10(abs(value)) if value and math.isfinite(value) else -math.inf
    rounding = 0.5 * 10.0 ** (math.floor(size) + 1 - digits) if size > -math.inf else 0.0
    return f"{text} +- {error:.{of_error}g}" if rounding < error < math.inf else text
