"""Columns of a CSV file as numbers; a fault is told with its line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.measured.csv_text import Table, cells_of

__all__ = ["numbers_of"]


def numbers_of(table: Table, columns: Sequence[int]) -> npt.NDArray[np.float64]:
    """Numbers (column, row) of some columns; those that are nan stay nan."""
    last = len(table.lines)
    while last > table.first and not table.lines[last - 1].strip():
        last -= 1
    rows = table.lines[table.first : last]
    if not all(row.strip() for row in rows):
        blank = next(k for k, row in enumerate(rows) if not row.strip())
        raise OptionError(
            f"{table.name}, line {table.first + blank + 1} is blank and numbers follow; give the"
            " records of a file in files of their own"
        )
    try:
        found: npt.NDArray[np.float64] = np.loadtxt(
            _prepared(table, rows), dtype=float, comments=None, usecols=list(columns), ndmin=2,
            delimiter=None if table.delimiter == " " else table.delimiter,
            quotechar='"',
        )  # fmt: skip
    except (ValueError, IndexError):
        raise OptionError(_first_fault(table, rows, columns)) from None
    return found.T.copy()


def _prepared(table: Table, rows: list[str]) -> Iterator[str]:
    if table.decimal == ",":
        return (row.replace(",", ".") for row in rows)
    return iter(rows)


def _first_fault(table: Table, rows: list[str], columns: Sequence[int]) -> str:
    """The first cell that is no number, by its line in the file."""
    for k, row in enumerate(rows):
        cells = cells_of(row, table.delimiter)
        where = f"{table.name}, line {table.first + k + 1}"
        if len(cells) <= max(columns):
            return (
                f"{where} has {len(cells)} cells and column {max(columns)} (from 0) is needed: the"
                " file was cut there, or the delimiter is another one"
            )
        for column in columns:
            cell = cells[column]
            try:
                float(cell.replace(",", ".") if table.decimal == "," else cell)
            except ValueError:
                what = f"{cell!r:.40} is no number" if cell else "is empty"
                return (
                    f"{where}, column {column} (from 0): {what}; leave such rows out before, with"
                    " the whole part of the record before or after them"
                )
    return f"{table.name}: the numbers cannot be read"
