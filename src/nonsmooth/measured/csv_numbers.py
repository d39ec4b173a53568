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
    if table.decimal == table.delimiter:  # cells are quoted
        return _cell_by_cell(table, rows, columns)
    try:
        found: npt.NDArray[np.float64] = np.loadtxt(
            _prepared(table, rows), dtype=float, comments=None, usecols=list(columns), ndmin=2,
            delimiter=None if table.delimiter == " " else table.delimiter,
            quotechar='"',
        )  # fmt: skip
    except (ValueError, IndexError):
        return _cell_by_cell(table, rows, columns)
    return found.T.copy()


def _prepared(table: Table, rows: list[str]) -> Iterator[str]:
    if table.decimal == ",":
        return (row.replace(",", ".") for row in rows)
    return iter(rows)


def _cell_by_cell(table: Table, rows: list[str], columns: Sequence[int]) -> npt.NDArray[np.float64]:
    """The same, slowly: an empty cell is nan, and the first cell that is no number is told."""
    numbers = np.empty((len(columns), len(rows)))
    for k, row in enumerate(rows):
        cells = cells_of(row, table.delimiter)
        where = f"{table.name}, line {table.first + k + 1}"
        if len(cells) < table.width - 1 or len(cells) < max(columns):
            raise OptionError(
                f"{where} has {len(cells)} cells and the first row of numbers has {table.width};"
                " was the file cut there?"
            )
        for i, column in enumerate(columns):
            cell = cells[column] if column < len(cells) else ""
            try:
                numbers[i, k] = float(_pointed(cell, table.decimal)) if cell else np.nan
            except ValueError:
                raise OptionError(
                    f"{where}, column {column} (from 0): {cell!r:.40} is no number; delete what"
                    " follows the record, and write nan where a sample is missing"
                ) from None
    return numbers


def _pointed(cell: str, decimal: str) -> str:
    return cell.replace(",", ".") if decimal == "," else cell
