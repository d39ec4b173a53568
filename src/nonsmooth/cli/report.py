"""What a command says of its result: lines and tables for a reader, and the same as JSON."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import click

from nonsmooth.cli.console import print_table

__all__ = ["Column", "Report", "complex_text"]


Column = tuple[str, str, Callable[[Any], str]]  # heading, name in JSON, text of a value


class _Table(NamedTuple):
    name: str
    columns: Sequence[Column]
    rows: list[tuple[Any, ...]]
    most: int  # rows that are printed


class Report:
    """Lines of label and text, and tables; each with the numbers that they are made of."""

    def __init__(self, system: str, more: str = "") -> None:
        self.title = f"{system}: {more}" if more else system
        self.lines: list[tuple[str, str]] = []
        self.data: dict[str, Any] = {"system": system}
        self.tables: list[_Table] = []

    def add(self, label: str, text: str, **data: Any) -> None:
        """Add a line; as JSON it is `data`, or the text under its label."""
        self.lines.append((label, text))
        self.data |= data or {_key(label): text}

    def number(self, label: str, value: Any, form: str = "") -> None:
        """Add a line with one number."""
        self.add(label, f"{value:{form}}", **{_key(label): value})

    def table(
        self,
        name: str,
        columns: Sequence[Column],
        rows: Iterable[tuple[Any, ...]],
        most: int = sys.maxsize,
    ) -> None:
        """Add a table: heading, name in JSON and text of a value for each column; and its rows."""
        found = list(rows)
        self.tables.append(_Table(name, columns, found, most))
        keys = [key for _, key, _ in columns]
        self.data[_key(name)] = [
            dict(pair for each in zip(keys, row, strict=True) for pair in _entries(*each))
            for row in found
        ]

    def reword(self, change: Callable[[str], str]) -> None:
        """Change the words of all lines, and those of the same texts as JSON."""
        self.lines = [(label, change(text)) for label, text in self.lines]
        spoken = ("status", "message")
        self.data |= {
            key: change(self.data[key]) for key in spoken if isinstance(self.data.get(key), str)
        }

    def print(self) -> None:
        """Print the lines and the tables."""
        from nonsmooth.system.columns import harmless  # names and texts come from files

        width = max((len(label) for label, _ in self.lines), default=0)
        lines = [self.title, *(f"  {label:<{width}}  {text}" for label, text in self.lines)]
        click.echo(harmless("\n".join(lines)))
        for table in self.tables:
            rows = [
                [
                    harmless(text(value))
                    for (_, _, text), value in zip(table.columns, row, strict=True)
                ]
                for row in table.rows[: table.most]
            ]
            filled = [k for k in range(len(table.columns)) if any(row[k] for row in rows)]
            if filled:
                heads = [table.columns[k][0] for k in filled]
                print_table(heads, [[row[k] for k in filled] for row in rows])
            if len(table.rows) > table.most:
                click.echo(f"and {len(table.rows) - table.most} more {table.name}")

    def print_json(self) -> None:
        """Print one JSON document."""
        click.echo(json.dumps(_native(self.data), indent=2, ensure_ascii=False, allow_nan=False))


def complex_text(number: complex) -> str:
    """A multiplier as it is read; of a real one the real part alone."""
    if number != number:
        return ""
    if number.imag == 0.0:
        return f"{number.real:.6g}"
    return f"{number.real:.6g} {'-' if number.imag < 0 else '+'} {abs(number.imag):.6g}i"


def _entries(key: str, value: Any) -> list[tuple[str, Any]]:
    """Entries of a cell; a key such as ``share and share_error`` names both parts of a pair."""
    first, _, second = key.partition(" and ")
    if not second:
        return [(first, value)]
    return list(zip((first, second), (None, None) if value is None else value, strict=True))


def _key(label: str) -> str:
    return label.replace(",", "").replace(" ", "_").replace("-", "_")


def _native(value: Any) -> Any:
    """Value for JSON, which knows neither nan (null) nor infinity (a text) nor complex numbers."""
    if isinstance(value, dict):
        return {str(key): _native(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_native(each) for each in value]
    if hasattr(value, "tolist"):  # of numpy
        return _native(value.tolist())
    if isinstance(value, complex):
        return (
            None if value != value else {"real": _native(value.real), "imag": _native(value.imag)}
        )
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value
