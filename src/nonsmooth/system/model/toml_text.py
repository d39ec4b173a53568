"""TOML text from where the user keeps it, and its plain data: dicts, lists, texts, numbers.

A text is bounded in size and nesting before the parser of the standard library sees it:
that one recurses into brackets and takes quadratic time for long dotted names.
"""

from __future__ import annotations

import codecs
import os
import re
import tomllib
from pathlib import Path
from typing import Any

from nonsmooth.errors import ModelError, quote
from nonsmooth.system.text.grammar import point_at

__all__ = ["MAX_CHARACTERS", "parse_toml", "read_source"]

MAX_CHARACTERS = 10_000_000  # a signal with as many knots as it may have
_TOO_LONG = f"the TOML text has more than {MAX_CHARACTERS:,} characters, which is not read"
_MOST_BRACKETS = 8
_MOST_DOTS = 8
_BYTE_ORDER_MARK = "\ufeff"
# Strings and comments, whole, so that what stands in them does not count; then the marks
# that do. A string that is never closed reaches to its end: no second look, no backtracking.
_MARK = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"{3,5}|\\?\Z)'
    r"|'''.*?(?:'{3,5}|\Z)"
    r'|"(?:\\[^\n]|[^"\\\n])*"?'
    r"|'[^'\n]*'?"
    r"|#[^\n]*"
    r"|[\[\]{}.,=\n]",
    re.DOTALL,
)
_PLACE = re.compile(r" \(at (?:line (?P<line>\d+), column (?P<column>\d+)|end of document)\)$")
_HINTS = {
    "Invalid value": 'an expression stands in quotes, as in x = "2*v"',
    "Invalid statement": "a line is key = value, [table] or [[array of tables]], and a key without"
    + " quotes has ASCII letters, digits, _ and - only",
    "Expected newline or end of document after a statement": "one key = value on each line, and "
    + 'an expression in quotes, as in x = "2*v"',
    "Cannot overwrite a value": "this is given already, or given both as [table] and as [[array "
    + "of tables]]",
    "Illegal character '\\n'": "a text in quotes ends on its line; several lines stand in "
    + 'three quotes: """..."""',
}


def read_source(source: str | os.PathLike[str]) -> tuple[str, str]:
    """TOML text of a source and the name of its file, empty where the source is the text."""
    if isinstance(source, str):
        if "\n" in source or "\r" in source:
            return source.removeprefix(_BYTE_ORDER_MARK), ""
    elif not isinstance(source, os.PathLike):
        raise ModelError(
            f"from_toml: give TOML text or the path of a file, not {type(source).__name__}"
        )
    if not os.fspath(source):
        raise ModelError("from_toml: the text is empty; give TOML text or the path of a file")
    shown = f"{quote(os.fspath(source))}"
    most = 4 * MAX_CHARACTERS  # bytes, of which a character takes at most four
    try:
        with Path(source).open("rb") as file:
            data = file.read(most + 1)  # no more than that, should the file never end
    except FileNotFoundError:
        hint = "; TOML text has one key a line, so more than one line"
        raise ModelError(
            f"there is no file {shown}{hint if isinstance(source, str) else ''}"
        ) from None
    except (OSError, ValueError, TypeError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise ModelError(f"the file {shown} cannot be read: {reason}") from None
    if len(data) > most:
        raise ModelError(f"the file {shown}: {_TOO_LONG}")
    try:
        return data.decode("utf-8-sig"), str(source)
    except UnicodeDecodeError:
        wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        kind = "is UTF-16 text" if wide else "is not UTF-8 text"
        raise ModelError(f"the file {shown} {kind}; TOML is UTF-8, so save it as that") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Plain data of a TOML text."""
    if len(text) > MAX_CHARACTERS:
        raise ModelError(_TOO_LONG)
    text = text.replace("\r\n", "\n")  # as the parser does, which counts columns after that
    _check_nesting(text)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise ModelError(_syntax_error(text, str(fault))) from None
    except ValueError:  # of Python, which refuses to convert integers that long
        raise ModelError("TOML: a number has thousands of digits; a double has 17") from None
    except RecursionError:  # of a caller that has used up the stack
        raise ModelError("TOML: brackets nest deeper than the stack allows") from None


def _check_nesting(text: str) -> None:
    """Refuse brackets in brackets and dotted names beyond what a system needs."""
    depth = dots = 0
    for mark in _MARK.finditer(text):
        sign = mark.group()
        if sign == ".":
            dots += 1
        elif sign in "[]{},=\n":
            dots = 0
            depth = depth + 1 if sign in "[{" else max(0, depth - (sign in "]}"))
        if depth > _MOST_BRACKETS or dots > _MOST_DOTS:
            what = "brackets nest" if depth > _MOST_BRACKETS else "dotted names go"
            line = text.count("\n", 0, mark.start())
            column = mark.start() - text.rfind("\n", 0, mark.start()) - 1
            raise ModelError(_pointed(text, line, column, f"{what} deeper than a system needs"))


def _syntax_error(text: str, message: str) -> str:
    """Message of the parser with the line that it is about and a caret under the place."""
    place = _PLACE.search(message)
    if place is None:
        return f"TOML: {message}"
    said = message[: place.start()]
    hint = _HINTS.get(said)
    said = said[:1].lower() + said[1:] + (f"; {hint}" if hint else "")
    if place["line"] is None:
        lines = text.rstrip().split("\n")
        return _pointed(text, len(lines) - 1, len(lines[-1]), said)
    return _pointed(text, int(place["line"]) - 1, int(place["column"]) - 1, said)


def _pointed(text: str, line: int, column: int, message: str) -> str:
    """Message with a line of the text and a caret; both counted from zero here."""
    shown = text.split("\n")[line]
    return point_at(shown, column, f"TOML, line {line + 1}, column {column + 1}: {message}")
