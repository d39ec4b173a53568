"""Variables that a picture shows, checked before a long run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import names
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    from nonsmooth.system.system import System

__all__ = ["chosen", "pair", "single"]


def chosen(
    text: str, known: Sequence[str], option: str = "--draw", kind: str = "variable"
) -> list[str]:
    """Names of a text, each of which must be known."""
    found = names(text)
    for name in found:
        if name not in known:
            raise OptionError(f"{option}: {unknown_name(kind, name, known)}")
    return found


def single(text: str, known: Sequence[str], option: str = "--draw") -> str:
    """The one name of a text."""
    chosen(text, known, option)
    if text not in known:
        raise OptionError(f"{option}: {text!r} is not one variable, such as {known[0]}")
    return text


def pair(system: System, text: str | None, option: str = "--draw", *more: str) -> tuple[str, str]:
    """Two variables; by default the first two states, or the only one in time."""
    states = system.states
    if text is None:
        return (states[0], states[1]) if len(states) > 1 else ("time", states[0])
    if len(names(text)) != 2:
        raise OptionError(f"{option}: {text!r} is not two variables, such as x,v")
    first, second = chosen(text, [*states, *system.outputs, *more], option)
    return first, second
