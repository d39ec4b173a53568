"""A view as the text of a link, and back: ``model=moling&p.b=0.12&between=0.05,0.2``."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from dataclasses import fields
from typing import Any
from urllib.parse import parse_qsl, urlencode

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.explorer.view import View
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import names_in
from nonsmooth.system.text.grammar import parse

__all__ = ["from_link", "read_field", "read_number", "to_link"]

_DEFAULTS = {item.name: item.default for item in fields(View)}
_PAIRS = {"p.": "values", "at.": "initial"}
_NUMBERS = ("between", "height", "region")
_MOST = 200_000  # characters of a text: a short link may stand for a very long one
_LONGEST = 100_000  # characters of a link


def to_link(view: View) -> str:
    """The part of a link behind its ``#``; it has all that differs from an empty view."""
    words: list[tuple[str, str]] = []
    for name, default in _DEFAULTS.items():
        value = getattr(view, name)
        if value == default:
            continue
        if name == "text":
            words.append((name, _packed(value)))
        elif name in _PAIRS.values():
            prefix = next(key for key, of in _PAIRS.items() if of == name)
            words += [(prefix + key, str(item)) for key, item in value]
        elif isinstance(value, tuple):
            words.append((name, ",".join(map(str, value))))
        else:
            words.append((name, str(int(value)) if isinstance(value, bool) else str(value)))
    return urlencode(words, safe=",*/()")


def from_link(link: str) -> View:
    """View of a link; what it says is data, and a word that has no place there is an error."""
    if len(link) > _LONGEST:
        raise OptionError(f"the link has {len(link):,} characters; a page takes {_LONGEST:,}")
    found: dict[str, Any] = {"values": [], "initial": []}
    for name, text in parse_qsl(link.lstrip("#?"), keep_blank_values=True):
        prefix = next((key for key in _PAIRS if name.startswith(key)), "")
        if prefix:
            value = text if prefix == "p." else read_number(name, text)
            found[_PAIRS[prefix]].append((name.removeprefix(prefix), value))
        elif name in _DEFAULTS:
            found[name] = read_field(name, text)
        else:
            raise OptionError(f"link: {unknown_name('word', name, [*_DEFAULTS, *_PAIRS])}")
    words: dict[str, Any] = {
        name: tuple(v) if name in _PAIRS.values() else v for name, v in found.items()
    }
    return View(**words)


def read_field(name: str, text: str) -> Any:
    """Value of a field as a link writes it."""
    default = _DEFAULTS[name]
    if name == "text":
        return _unpacked(text)
    if isinstance(default, bool):
        return text == "1"
    if isinstance(default, int):
        return _whole_number(name, text)
    if isinstance(default, float):
        return read_number(name, text)
    if isinstance(default, tuple):
        parts = [part for part in text.split(",") if part]
        return (
            tuple(read_number(name, part) for part in parts) if name in _NUMBERS else tuple(parts)
        )
    return text


def read_number(name: str, text: str) -> float:
    """A finite number of a text, which may be a constant expression such as ``pi/2``."""
    try:
        value = float(text)
    except ValueError:
        value = _constant(name, text)
    if not math.isfinite(value):
        raise OptionError(f"{name} = {quote(text)} is not a finite number")
    return value


def _constant(name: str, text: str) -> float:
    tree = parse(text, where=name)
    if any(each.name != "pi" for each in names_in(tree)):
        raise OptionError(
            f"{name} = {quote(text)} is not a number, nor a constant expression such as pi/2"
        )
    return constant_value(tree, {})


def _whole_number(name: str, text: str) -> int:
    value = read_number(name, text)
    if not value.is_integer():
        raise OptionError(f"{name} = {quote(text)} is not a whole number")
    return int(value)


def _packed(text: str) -> str:
    return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")


def _unpacked(text: str) -> str:
    """Text of a packed one, of which no more is unpacked than a page takes."""
    try:
        packed = base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
        unpacking = zlib.decompressobj()
        found = unpacking.decompress(packed, _MOST + 1)
        if len(found) > _MOST:
            raise OptionError(f"link: its text has more than {_MOST:,} characters")
        return found.decode()
    except (binascii.Error, zlib.error, UnicodeDecodeError):
        raise OptionError("link: its text is damaged; copy the whole link") from None
