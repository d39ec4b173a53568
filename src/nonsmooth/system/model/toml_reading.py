"""A system from TOML: the plain data of the text become the words of the constructors.

Here the shape of the data is checked, key by key and type by type, in the words of a TOML
file. What the texts mean is checked by `System`, for files and scripts alike.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.system.model.toml_text import parse_toml, read_source
from nonsmooth.system.model.toml_writing import FORMAT_VERSION, key_text
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.signals import Signal
from nonsmooth.system.surfaces import Surface

__all__ = ["read_system"]

T = TypeVar("T")

_PLACE = re.compile(r"\w+(\['\w+'\]|\.\w+|\[\d+\])+(?=[:. ])")
_KEY = re.compile(r"\['(\w+)'\]")
_ENTRY = re.compile(r"\bflow\[\"(\w+)\"\]")  # in the middle, where the place is told already
_ARGUMENT = re.compile(r"\b([a-z_]+)=(?=[\s,;:.)]|$)")  # as in: leave modes= out


def read_system(make: Callable[..., T], source: str | os.PathLike[str]) -> T:
    """System of a TOML text or file, made by the class given; errors name the file."""
    text, file = read_source(source)
    try:
        document = parse_toml(text)
        try:
            return make(**_system_words(document))
        except ModelError as fault:
            told = _in_words_of_file(str(fault), "equations" in document)
            raise ModelError(f"{told}{_misplaced(document)}") from None
    except ModelError as fault:
        raise ModelError(f"{file}: {fault}" if file else str(fault)) from None


def _in_words_of_file(message: str, equations: bool) -> str:
    """A message with keys of the file in place of arguments of Python.

    The place at its beginning is ``modes.free.flow`` in place of brackets; `equations` tells that
    the file has those in place of a mode.
    """
    message = _ENTRY.sub(r"\1", _ARGUMENT.sub(r"\1", message))
    place = _PLACE.match(message)
    if place is None:
        return message
    where = _KEY.sub(r".\1", place[0])
    if equations:
        where = re.sub(r"^modes\.flow(\.flow)?$", "equations", where)
    return where + message[place.end() :]


def _system_words(document: dict[str, Any]) -> dict[str, Any]:
    """Arguments of `System`."""
    _check_format(document)
    readers = _SYSTEM
    for key in document:
        if key != "format" and key not in readers:
            sentence = unknown_name("key", key, ["format", *readers])
            raise ModelError(f"top level: {sentence}")
    if "states" not in document:
        raise ModelError('states is missing; write states = ["x", "v"] above the first [table]')
    if "modes" not in document and "equations" not in document:
        raise ModelError(
            "modes is missing; write the flow of each mode under [modes.NAME.flow], or that of a"
            " system of one mode under [equations]"
        )
    return {key: readers[key](document[key], key) for key in readers if key in document}


def _check_format(document: dict[str, Any]) -> None:
    """The format is this one; a file written by hand need not say so."""
    version = document.get("format", FORMAT_VERSION)
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        raise ModelError(
            f"format: {_kind(version)} is no version of the format; write"
            f" format = {FORMAT_VERSION}, or leave it out"
        )
    if version > FORMAT_VERSION:
        raise ModelError(
            f"format: the text is of format {_number(version)}, and this version of nonsmooth"
            f" reads format {FORMAT_VERSION}; upgrade nonsmooth to read it"
        )


def _modes(value: Any, where: str) -> dict[str, Mode]:
    return {name: _mode(words, _at(where, name)) for name, words in _table(value, where).items()}


def _mode(value: Any, where: str) -> Mode:
    known = {"flow": _expressions, "slaved": _expressions, "definitions": _expressions}
    words = _table(value, where)
    for key in words:
        if key not in (*known, "exits", "cells"):
            sentence = unknown_name("key", key, [*known, "exits", "cells"])
            raise ModelError(f"{where}: {sentence}; a flow stands under [{where}.flow]")
    given: dict[str, Any] = {"flow": {}}
    given |= {key: read(words[key], _at(where, key)) for key, read in known.items() if key in words}
    if "exits" in words:
        given["exits"] = _exits(words["exits"], f"{where}.exits")
    if "cells" in words:
        given["cells"] = _texts(words["cells"], f"{where}.cells")
    return _made(Mode, given, where)


def _exits(value: Any, where: str) -> list[Exit]:
    if not isinstance(value, list):
        raise ModelError(
            f"{where}: {_kind(value)}, where an array of tables belongs; write [[{where}]] with"
            " two brackets above each exit"
        )
    return [_exit(words, f"{where}[{position}]") for position, words in enumerate(value)]


def _exit(value: Any, where: str) -> Exit:
    known = {
        "guard": _expression, "to": _text, "reset": _expressions, "name": _text, "sticks": _text
    }  # fmt: skip
    words = _table(value, where)
    for key in words:
        if key not in known:
            raise ModelError(f"{where}: {unknown_name('key', key, known)}")
    if "guard" not in words:
        raise ModelError(f'{where}: guard is missing; write guard = "x - 1", positive inside')
    given = {key: read(words[key], _at(where, key)) for key, read in known.items() if key in words}
    return _made(Exit, given, where)


def _surfaces(value: Any, where: str) -> dict[str, Surface]:
    return {name: _surface(words, _at(where, name)) for name, words in _table(value, where).items()}


def _surface(value: Any, where: str) -> Surface:
    known = {
        "function": _expression, "below": _text, "on": _text, "above": _text,
        "hold": _expression, "on_nonunique": _text,
    }  # fmt: skip
    words = _table(value, where)
    for key in words:
        if key not in known:
            raise ModelError(f"{where}: {unknown_name('key', key, known)}")
    if "function" not in words:
        raise ModelError(f'{where}: function is missing; write function = "v - v_b"')
    given = {key: known[key](item, _at(where, key)) for key, item in words.items()}
    return _made(Surface, given, where)


def _signals(value: Any, where: str) -> dict[str, Signal]:
    return {name: _signal(words, _at(where, name)) for name, words in _table(value, where).items()}


def _signal(value: Any, where: str) -> Signal:
    known = {"times": _numbers, "values": _numbers, "method": _text}
    words = _table(value, where)
    for key in words:
        if key not in known:
            raise ModelError(f"{where}: {unknown_name('key', key, known)}")
    for key in ("times", "values"):
        if key not in words:
            raise ModelError(f"{where}: {key} is missing; write {key} = [0.0, 0.1, 0.2]")
    given = {key: known[key](item, _at(where, key)) for key, item in words.items()}
    return _made(Signal, given, where)


def _made(make: Callable[..., T], words: dict[str, Any], where: str) -> T:
    try:
        return make(**words)
    except ModelError as fault:
        told = str(fault).removeprefix(f"{make.__name__}: ")
        told = re.sub(r"^(\w+)=(?=\S)", r"\1 = ", told)  # as the file has it
        raise ModelError(f"{where}: {told}") from None


def _drift(value: Any, where: str) -> list[str] | dict[str, Text]:
    if isinstance(value, dict):
        return _expressions(value, where)
    return _names(value, where)


def _names(value: Any, where: str) -> list[str]:
    if not isinstance(value, list):
        raise ModelError(f'{where}: {_kind(value)}, where an array belongs, such as ["x", "v"]')
    return [_text(item, f"{where}[{position}]") for position, item in enumerate(value)]


def _numbers(value: Any, where: str) -> list[float]:
    if not isinstance(value, list):
        raise ModelError(f"{where}: {_kind(value)}, where an array of numbers belongs")
    for position, item in enumerate(value):
        if isinstance(item, bool) or not isinstance(item, int | float):
            raise ModelError(f"{where}[{position}]: {_kind(item)}, where a number belongs")
    return value


def _expressions(value: Any, where: str) -> dict[str, Text]:
    return {key: _expression(item, _at(where, key)) for key, item in _table(value, where).items()}


def _texts(value: Any, where: str) -> dict[str, str]:
    return {key: _text(item, _at(where, key)) for key, item in _table(value, where).items()}


def _table(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ModelError(f"{where}: {_kind(value)}, where a table belongs; write [{where}]")
    return value


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise ModelError(f"{where}: {_kind(value)}, where a text in quotes belongs")
    return value


def _expression(value: Any, where: str) -> Text:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ModelError(
            f'{where}: {_kind(value)}, where a number or an expression in quotes belongs, "2*pi"'
        )
    if isinstance(value, float) and not math.isfinite(value):
        raise ModelError(f"{where}: {value} is not a finite number")
    return value


_SYSTEM: dict[str, Callable[[Any, str], Any]] = {
    "name": _text,
    "states": _names,
    "period": _expression,
    "drift": _drift,
    "parameters": _expressions,
    "definitions": _expressions,
    "outputs": _expressions,
    "require": _texts,
    "initial": _expressions,
    "describe": _texts,
    "equations": _expressions,
    "modes": _modes,
    "slow": _expressions,
    "signals": _signals,
    "surfaces": _surfaces,
    "symmetry": _expressions,
}


def _at(where: str, key: str) -> str:
    """Place of a key in a table, as a TOML file would spell it."""
    return f"{where}.{key_text(key):.80}"


def _kind(value: Any) -> str:
    """What a value of TOML is, in TOML's words."""
    if isinstance(value, bool):
        return f"the boolean {str(value).lower()}"
    if isinstance(value, int | float):
        return f"the number {_number(value)}"
    if isinstance(value, str):
        return f"the text {quote(value)}"
    if isinstance(value, dict):
        return "a table"
    return "an array" if isinstance(value, list) else "a date or a time"


def _number(value: float) -> str:
    # hexadecimal integers may be longer than Python is willing to write in decimals
    return f"{quote(value)}" if isinstance(value, float) or abs(value) < 10**30 else "above 1e30"


def _misplaced(document: Mapping[str, Any]) -> str:
    """Hint for keys of the system that a table in front of them has swallowed."""
    names = ("equations", "parameters", "definitions", "outputs", "require", "initial", "describe")
    tables = {name: document.get(name) for name in names}
    modes = document.get("modes")
    for name, mode in modes.items() if isinstance(modes, dict) else ():
        if isinstance(mode, dict):
            tables |= {f"modes.{name}": mode, f"modes.{name}.flow": mode.get("flow")}
    for table, inside in tables.items():
        if isinstance(inside, dict):
            for key in ("states", "period", "drift", "name"):
                if key in inside and key not in document:
                    return (
                        f"\n    {key!r} stands in the table [{table}]; if it belongs to the"
                        f" system, move its line above the first [table]"
                    )
    return ""
