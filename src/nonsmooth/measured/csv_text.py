"""The text of a CSV file: its encoding, delimiter, header, and its columns as numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.measured.channel import split_units

__all__ = ["Table", "cells_of", "numbers_of", "read_table"]


_MOST_BEFORE = 200  # lines of a header
_LOOKED_AT = 20  # lines of numbers by which delimiter and decimal sign are told
_ALIKE = 5  # lines that follow a first one of numbers and text, and have numbers in its places
_COMMENT = ("#", "%")  # signs with which a line begins that holds no numbers
_DELIMITERS = {",": "comma", ";": "semicolon", "\t": "tab", " ": "spaces", "|": "bar"}
_NUMBER = re.compile(r"[+-]?((\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|nan|inf(inity)?)", re.I)
_LINE_END = re.compile(r"\r\n|\r|\n")
_CURE_OF_CELL = "delete what follows the record, and write nan where a sample is missing"
_CURE_OF_TEXT = (
    "the column holds text: name another one; where it holds dates, write times in s, or give"
    " sample_rate= and no time="
)
_SIGNATURES = {
    b"PK\x03\x04": "an Excel workbook or another archive",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook",
    b"\x89HDF": "an HDF5 or netCDF file",
    b"CDF": "a netCDF file",
    b"MATLAB": "a MATLAB file",
    b"TDSm": "a TDMS file",
    b"\x1f\x8b": "a compressed file",
}


@dataclass(frozen=True)
class Table:
    """Lines of a file, and how they are to be read."""

    name: str
    lines: list[str]
    first: int  # line of the first numbers, from 0
    delimiter: str
    decimal: str
    width: int  # cells in the first line of numbers
    headers: list[list[str]]  # rows above the numbers with as many cells, the last one first
    narrower: int  # cells of a row of names just above the numbers, which has fewer, or 0

    @cached_property
    def row_lines(self) -> Sequence[int]:
        """Lines of the rows of numbers, from 0: without comments, and nothing blank at the end."""
        found: Sequence[int] = range(self.first, len(self.lines))
        if any(map(_is_comment, self.lines[self.first :])):
            found = [k for k in found if not _is_comment(self.lines[k])]
        count = len(found)
        while count and not self.lines[found[count - 1]].strip():
            count -= 1
        return found[:count]

    def column(self, wanted: str | int, what: str) -> tuple[int, str]:
        """Number and units of a column by its header or its number."""
        if isinstance(wanted, bool) or not isinstance(wanted, (str, int)):
            raise OptionError(
                f"{what} = {quote(wanted)}: give the header of a column, or its number"
            )
        if isinstance(wanted, int):
            if not 0 <= wanted < self.width:
                raise OptionError(
                    f"{self.name}: {what} is column {wanted}, and columns are numbered from 0 to"
                    f" {self.width - 1}"
                )
            return wanted, self._units(wanted)
        for row in self.headers:
            places = _places(row, wanted)
            if len(places) > 1:
                raise OptionError(
                    f"{self.name}: {len(places)} columns are called {wanted!r}; give the number of"
                    f" the right one, from 0: {', '.join(map(str, places))}"
                )
            if places:
                return places[0], split_units(row[places[0]])[1] or self._units(places[0])
        if not self.headers and self.narrower:
            raise OptionError(
                f"{self.name}: the numbers have {self.width} columns and the header above them has"
                f" {self.narrower}, so no number stands below {wanted!r}; where commas part the"
                " columns and stand for decimal points too, export with semicolons or points, or"
                " give columns by number, from 0"
            )
        if not self.headers:
            raise OptionError(
                f"{self.name} has no header above its {self.width} columns, so there is no column"
                f" {wanted!r}; give columns by number, from 0"
            )
        row = next((r for r in self.headers if any(_is_name(c) for c in r)), self.headers[0])
        known = [split_units(cell)[0] for cell in row if cell]
        raise OptionError(f"{self.name}, {what}: {unknown_name('column', wanted, known)}")

    def header(self, place: int) -> str:
        """Header of a column, empty where it has none."""
        return next((row[place] for row in self.headers if _is_name(row[place])), "")

    def called(self, place: int) -> str:
        """A column in words: by its header, or by its number."""
        header = self.header(place)
        return f"column {quote(header)}" if header else f"column {place} (from 0)"

    def _units(self, place: int) -> str:
        """Units of a column: in its header, or in a row of their own below the headers."""
        for row in self.headers:
            if units := split_units(row[place])[1]:
                return units
        if len(self.headers) > 1:
            return self.headers[0][place].strip("[]() ")
        return ""


def read_table(path: Any, delimiter: str | None, decimal: str | None) -> Table:
    """The lines of a CSV file, with what they show of its form."""
    try:
        file = Path(path)
    except TypeError:
        raise OptionError(f"path = {quote(path)}: give the name of a CSV file") from None
    lines = _LINE_END.split(_decoded(file))  # not the other signs that splitlines takes for ends
    if delimiter is not None and (not isinstance(delimiter, str) or len(delimiter) != 1):
        raise OptionError(f"delimiter = {quote(delimiter)}: give one character, such as ';'")
    if decimal is not None and not is_known(decimal, (".", ",")):
        raise OptionError(f"decimal = {quote(decimal)}: give '.' or ','")
    first, found = _first_numbers(lines, delimiter, decimal, file.name)
    sample = [cells_of(line, found) for line in _from(lines, first, _LOOKED_AT)]
    above = cells_of(_uncommented(lines[first - 1]), found) if first else []
    width = len(sample[0])
    if lines[first].strip(" ").endswith(found) and max(map(len, [above, *sample])) == width + 1:
        width += 1  # the last cell of the first row is empty
    if decimal is None:
        text = "".join(cell for cells in sample for cell in cells if _is_number(cell))
        decimal = "," if "," in text and "." not in text else "."
    headers = []
    for line in reversed(lines[:first]):
        cells = cells_of(_uncommented(line), found)
        if len(cells) == width and any(cells):
            headers.append(cells)
    narrower = len(above) if 1 < len(above) < width and all(map(_is_name, above)) else 0
    return Table(file.name, lines, first, found, decimal, width, headers, narrower)


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of one line, without quotes; an empty one behind the last delimiter is none."""
    return _without_last(_all_cells(line, delimiter))


def _all_cells(line: str, delimiter: str) -> list[str]:
    """Cells of one line, without quotes, also an empty one behind the last delimiter."""
    if delimiter == " ":
        return line.split()
    try:
        row = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:  # a cell of a hundred thousand characters
        row = [line]
    return [cell.strip() for cell in row]


def _without_last(cells: list[str]) -> list[str]:
    """Cells without an empty one behind the last delimiter."""
    return cells[:-1] if len(cells) > 1 and cells[-1] == "" else cells


def _is_comment(line: str) -> bool:
    return line.lstrip(" \t").startswith(_COMMENT)


def _uncommented(line: str) -> str:
    """A line of a header, which may stand in a comment."""
    return line.lstrip("".join(_COMMENT) + " ")


def _from(lines: list[str], first: int, most: int) -> list[str]:
    """So many lines from a first one on that are no comments."""
    return list(islice((line for line in lines[first:] if not _is_comment(line)), most))


def _decoded(file: Path) -> str:
    try:
        data = file.read_bytes()
    except OSError as error:
        reason = error.strerror or "cannot be read"
        raise OptionError(f"{str(file)!r}: {reason}; give the name of a CSV file") from None
    for signature, what in _SIGNATURES.items():
        if data.startswith(signature):
            raise OptionError(f"{file.name} is {what}, not a CSV file; export it as CSV first")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")  # such as a micro sign in a header
    if "\0" in text:
        raise OptionError(f"{file.name} holds bytes that are no text; export it as CSV first")
    return text


def _first_numbers(
    lines: list[str], delimiter: str | None, decimal: str | None, name: str
) -> tuple[int, str]:
    """Line of the first numbers and the delimiter between them.

    Where no line is one of numbers alone, some columns hold text, such as stamps or comments.
    """
    for begins in (_is_numbers, _has_numbers):
        for k, line in enumerate(lines[:_MOST_BEFORE]):
            if _is_comment(line):
                continue
            for candidate in [delimiter] if delimiter else _candidates(line, decimal):
                rows = [cells_of(each, candidate) for each in _from(lines, k, 1 + _ALIKE)]
                if begins(rows):
                    return _first_with_text(lines, k, candidate), candidate
    if not any(line.strip() for line in lines):
        raise OptionError(f"{name} is empty")
    expected = f"separated by {delimiter!r}" if delimiter else (
        f"separated by {', '.join(_DELIMITERS.values())}"
    )  # fmt: skip
    raise OptionError(
        f"{name}: none of the first {min(_MOST_BEFORE, len(lines))} lines is a row of numbers"
        f" {expected}; name another delimiter=, or decimal=',' where commas stand for points"
    )


def _first_with_text(lines: list[str], number: int, delimiter: str) -> int:
    """The first row of those to which a row of numbers belongs, where some have text as well.

    A row that leaves its text out, or that has none, is one of numbers alone.
    """
    row, found = cells_of(lines[number], delimiter), number
    for k in reversed(range(number)):
        if _is_comment(lines[k]):
            continue
        above = cells_of(lines[k], delimiter)
        if len(above) < len(row) or not all(
            _is_number(cell) == (i < len(row) and _is_number(row[i]))
            for i, cell in enumerate(above)
        ):
            break
        found = k
    return found


def _candidates(line: str, decimal: str | None) -> list[str]:
    """Delimiters to try: a comma last but for spaces where it may be a decimal sign."""
    order = [";", "\t", "|", ",", " "] if decimal != "," else [";", "\t", "|", " "]
    found = [sign for sign in order if sign in line.strip()]
    return found or [";" if decimal == "," else ","]


def _is_numbers(rows: list[list[str]]) -> bool:
    """Whether the first row is one of numbers; some cells may be empty, not the first one."""
    cells = rows[0]
    if not cells or not _is_number(cells[0]):
        return False
    return all(_is_number(cell) or not cell for cell in cells)


def _has_numbers(rows: list[list[str]]) -> bool:
    """Whether rows have numbers in the same columns, and text in others."""
    columns = [k for k, cell in enumerate(rows[0]) if _is_number(cell)]
    rows = [row for row in rows if row]  # the last line of a file may be blank
    if not columns or len(rows) == 1 or len({len(row) for row in rows}) > 1:
        return False
    return all(_is_number(row[k]) for row in rows for k in columns)


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell) is not None


def _is_name(cell: str) -> bool:
    return bool(cell) and not _is_number(cell)


def _places(row: list[str], wanted: str) -> list[int]:
    """Columns of a header: the whole text counts first, then what is before the units."""
    asked = wanted.strip()
    for read in (str.strip, lambda text: split_units(text)[0]):
        places = [k for k, cell in enumerate(row) if read(cell) == asked]
        if places:
            return places
    return []


def numbers_of(table: Table, columns: Sequence[int]) -> npt.NDArray[np.float64]:
    """Numbers (column, row) of some columns; those that are nan stay nan."""
    rows = [table.lines[k] for k in table.row_lines]
    if not all(row.strip() for row in rows):
        blank = next(k for k, row in enumerate(rows) if not row.strip())
        raise OptionError(
            f"{table.name}, line {table.row_lines[blank] + 1} is blank and numbers follow; give the"
            " records of a file in files of their own"
        )
    _check_width(table, rows)
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


def _check_width(table: Table, rows: list[str]) -> None:
    """Refuse rows with more numbers than the first one, or fewer: some stand in wrong columns.

    Text at the end of a row may be left out, and an empty cell behind a delimiter is there.
    """
    sign = table.delimiter
    first = _all_cells(rows[0], sign)
    numbers = [k for k in range(table.width) if k >= len(first) or not _is_name(first[k])]
    may_end_empty = len(first) == table.width  # otherwise each row has one delimiter more
    for k, row in enumerate(rows):
        is_plain = sign != " " and '"' not in row and row.count(sign) == len(first) - 1
        if is_plain and (may_end_empty or row.rstrip(" ").endswith(sign)):
            continue
        every = _all_cells(row, sign)
        cells = _without_last(every)
        where = f"{table.name}, line {table.row_lines[k] + 1}"
        wide = f"{len(cells)} cells and the first row of numbers has {table.width}"
        if len(cells) > table.width and all(map(_is_number, cells[table.width :])):
            raise OptionError(
                f"{where} has {wide}; does a delimiter stand for a decimal sign there?"
            )
        there = every if may_end_empty else cells
        is_short = len(every) < len(first) and len(cells) < table.width
        if is_short and any(i >= len(there) or _is_name(there[i]) for i in numbers):
            raise OptionError(
                f"{where} has {wide}, so numbers may stand in wrong columns; was the file cut"
                " there?"
            )


def _prepared(table: Table, rows: list[str]) -> Iterator[str]:
    if table.decimal == ",":
        return (row.replace(",", ".") for row in rows)
    return iter(rows)


def _cell_by_cell(table: Table, rows: list[str], columns: Sequence[int]) -> npt.NDArray[np.float64]:
    """The same, slowly: an empty cell is nan, and the first cell that is no number is told."""
    numbers = np.empty((len(columns), len(rows)))
    for k, row in enumerate(rows):
        cells = cells_of(row, table.delimiter)
        for i, column in enumerate(columns):
            cell = cells[column] if column < len(cells) else ""
            try:
                numbers[i, k] = float(_pointed(cell, table.decimal)) if cell else np.nan
            except ValueError:
                raise OptionError(
                    f"{table.name}, line {table.row_lines[k] + 1}, column {column} (from 0):"
                    f" {quote(cell)} is no number; {_CURE_OF_TEXT if k == 0 else _CURE_OF_CELL}"
                ) from None
    return numbers


def _pointed(cell: str, decimal: str) -> str:
    return cell.replace(",", ".") if decimal == "," else cell
