"""Where in a typed text a fault lies, so that its message can stand under it."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["Fault", "find_fault"]

_TOML_PLACE = re.compile(r"line (\d+),? column (\d+)")
_PLACE = re.compile(r"^([\w.\[\]]+): ")
_LAST_WORD = re.compile(r"(\w+)(?:\[\d+\])?$")
_SHOWN = "    "  # in front of the text that a message repeats, and of its caret
_ELLIPSIS = "..."


@dataclass(frozen=True)
class Fault:
    """A message with its place: line and column from 1 on, 0 where it has none."""

    message: str
    line: int = 0
    column: int = 0


def find_fault(text: str, message: str) -> Fault:
    """Place of a message about a TOML text.

    Errors of the grammar repeat the faulty text with a caret under the fault: that text stands in
    the typed one too, in the line of the key that the message begins with.
    """
    rows = message.split("\n")
    said, lines = rows[0], text.split("\n")
    of_toml = _TOML_PLACE.search(said)
    if of_toml:
        return Fault(said, int(of_toml[1]), int(of_toml[2]))
    if len(rows) >= 3 and set(rows[2].strip()) == {"^"}:
        shown, column = rows[1].removeprefix(_SHOWN), len(rows[2]) - 1 - len(_SHOWN)
        lead = len(_ELLIPSIS) if shown.startswith(_ELLIPSIS) else 0
        words = shown[lead:].removesuffix(_ELLIPSIS)
        places = [(k, row.find(words)) for k, row in enumerate(lines) if words and words in row]
        place = _PLACE.match(said)
        best = _best(lines, [k for k, _ in places], place[1] if place else "")
        if best is not None:
            at = dict(places)[best]
            return Fault(said, best + 1, at + column - lead + 1)
    place = _PLACE.match(said)
    if place:
        k = _best(lines, list(range(len(lines))), place[1], strict=True)
        if k is not None:
            return Fault(said, k + 1, 1)
    return Fault(said)


def _best(lines: list[str], among: list[int], place: str, *, strict: bool = False) -> int | None:
    """The line that a place such as ``modes.free.flow.v`` means: of its key, in its table."""
    word = _LAST_WORD.search(place)
    key = word[1] if word else ""
    table = place.rpartition(".")[0]
    found = [k for k in among if re.match(rf'\s*["\']?{re.escape(key)}["\']?\s*=', lines[k])]
    in_table = [k for k in found if _table_of(lines, k) in (table, re.sub(r"\[\d+\]", "", table))]
    if "[" in table and in_table:  # the n-th of several tables of one name
        number = int(re.findall(r"\[(\d+)\]", table)[-1])
        in_table = in_table[number:] or in_table
    for chosen in (in_table, found, [] if strict else among):
        if chosen:
            return chosen[0]
    return None


def _table_of(lines: list[str], k: int) -> str:
    for row in reversed(lines[:k]):
        head = re.match(r"\s*\[\[?([^\]]+)\]\]?", row)
        if head:
            return head[1].strip()
    return ""
