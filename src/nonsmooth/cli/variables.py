"""Variables that a picture shows, checked before a long run."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import names
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    from nonsmooth.system.system import System

__all__ = ["chosen", "first_state", "pair", "single"]


def chosen(
    text: str,
    known: Sequence[str],
    option: str = "--draw",
    kind: str = "variable",
    definitions: Container[str] = (),
) -> list[str]:
    """Names of a text, each of which must be known; ``definitions`` are not, but could be."""
    found = names(text, option)
    for name in found:
        if name in known:
            continue
        sentence = f"{option}: {unknown_name(kind, name, known)}"
        if name in definitions:
            sentence += f"; {name!r} is a definition: name it among the outputs to record it"
        raise OptionError(sentence)
    return found


def single(text: str, known: Sequence[str], option: str = "--draw") -> str:
    """The one name of a text."""
    chosen(text, known, option)
    if text not in known:
        raise OptionError(f"{option}: {text!r} is not one variable, such as {known[0]}")
    return text


def first_state(system: System) -> str:
    """What to draw without a choice: the first state that does not drift away from the picture."""
    return next(
        (name for name in system.states if name not in system.drift_states), system.states[0]
    )


def pair(system: System, text: str | None, option: str = "--draw", *more: str) -> tuple[str, str]:
    """Two variables; by default the first two states that do not drift, or the only one in time."""
    stay = [name for name in system.states if name not in system.drift_states]
    states = stay if len(stay) > 1 else system.states
    if text is None:
        return (states[0], states[1]) if len(states) > 1 else ("time", states[0])
    if len(names(text, option)) != 2:
        raise OptionError(f"{option}: {text!r} is not two variables, such as x,v")
    known = [*system.states, *system.outputs, *more]
    first, second = chosen(text, known, option, definitions=system.definitions)
    return first, second
