"""Where in a typed text a fault lies, so that its message can stand under it."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["TextFault", "find_fault"]

_TOML_PLACE = re.compile(r"line (\d+),? column (\d+)")
_PLACE = re.compile(r"^([\w.\[\]]+): ")
_UNKNOWN_KEY = re.compile(r"^(?:top level|[\w.\[\]]+): unknown key '([^']+)'")
_NUMBER = re.compile(r"\[\d+\]")
_HEAD = re.compile(r"\s*\[\[?([^\]]+)\]\]?")
_SHOWN = "    "  # in front of the text that a message repeats, and of its caret
_ELLIPSIS = "..."


@dataclass(frozen=True)
class TextFault:
    """A message with its place: line and column from 1 on, 0 where it has none."""

    message: str
    line: int = 0
    column: int = 0


def find_fault(text: str, message: str) -> TextFault:
    """Place of a message about a TOML text.

    Errors of the grammar repeat the faulty text with a caret under the fault: that text stands in
    the typed one too, in the line of the key that the message begins with.
    """
    said, *below = message.split("\n")
    lines = text.split("\n")
    of_toml = _TOML_PLACE.search(said)
    if of_toml:
        return TextFault(said, int(of_toml[1]), int(of_toml[2]))
    found = _PLACE.match(said)
    place = found[1] if found else ""
    if len(below) >= 2 and set(below[1].strip()) == {"^"}:
        shown, caret = below[0].removeprefix(_SHOWN), len(below[1]) - 1 - len(_SHOWN)
        lead = len(_ELLIPSIS) if shown.startswith(_ELLIPSIS) else 0
        words = shown[lead:].removesuffix(_ELLIPSIS)
        where = _columns_of(lines, words)
        if where:
            k = max(where, key=lambda k: (_likeness(lines, k, place), -k))
            return TextFault(said, k + 1, where[k] + caret - lead + 1)
    unknown = _UNKNOWN_KEY.match(said)
    if unknown:
        place = f"{place}.{unknown[1]}" if place else unknown[1]
    if place:
        k = max(range(len(lines)), key=lambda k: (_likeness(lines, k, place), -k))
        if _likeness(lines, k, place)[0]:
            return TextFault(said, k + 1, 1)
    return TextFault(said)


def _columns_of(lines: list[str], words: str) -> dict[int, int]:
    """Lines with a text, and where it begins in them; those in which it is the whole of a value."""
    for shape in (rf"""(?<=["'= ]){re.escape(words)}(?=["',]|\s*$)""", re.escape(words)):
        found = {
            k: match.start() for k, row in enumerate(lines) if (match := re.search(shape, row))
        }
        if found and words:
            return found
    return {}


def _likeness(lines: list[str], k: int, place: str) -> tuple[bool, int, bool]:
    """How well a line fits a place such as ``modes.free.exits[1].reset.v``: key, table, number."""
    plain = _NUMBER.sub("", place)
    key = plain.rpartition(".")[2]
    has_key = bool(re.search(rf"""(^|[\s{{,]|["']){re.escape(key)}["']?\s*=""", lines[k]))
    head = _HEAD.match(lines[k])
    if head:  # a table, or one within it
        has_key = f"{head[1].strip()}.".startswith(f"{plain}.")
    table, number = _table_of(lines, k)
    within = len(table) if f"{plain}.".startswith(f"{table}.") else -1
    numbers = _NUMBER.findall(place)
    return has_key, within, not numbers or int(numbers[-1][1:-1]) == number


def _table_of(lines: list[str], k: int) -> tuple[str, int]:
    """Table that a line opens or stands in, and which one of those with that name."""
    heads = [head[1].strip() for row in lines[: k + 1] if (head := _HEAD.match(row))]
    return (heads[-1], heads.count(heads[-1]) - 1) if heads else ("", 0)
