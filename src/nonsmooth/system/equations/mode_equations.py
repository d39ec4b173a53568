"""The equations of one mode as parsed texts, before names have a meaning."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.parts import STOP, Exit, Mode, Text
from nonsmooth.system.text.expressions import Expression, name_set, subtract
from nonsmooth.system.text.grammar import is_name

__all__ = ["ExitEquations", "ModeEquations", "check_guards", "is_relation", "read_mode"]

# an equals sign that is not part of a comparison
_EQUALS = re.compile(r"(?<![<>=])=(?!=)")


@dataclass(frozen=True, slots=True)
class ExitEquations:
    """Guard and reset of one exit, and the mode that it enters."""

    name: str
    target: str
    guard: Equation
    reset: Mapping[str, Equation]
    sticks: str | None = None


@dataclass(frozen=True, slots=True)
class ModeEquations:
    """Equations of one mode; definitions hold those of the system and its outputs too."""

    name: str
    definitions: Mapping[str, Equation]
    flow: Mapping[str, Equation]
    slaved: Mapping[str, Equation]
    exits: tuple[ExitEquations, ...]

    def all(self) -> Iterator[Equation]:
        """Equations in the order in which they count: flow, slaved, guards, resets."""
        yield from self.flow.values()
        yield from self.slaved.values()
        for way in self.exits:
            yield way.guard
        for way in self.exits:
            yield from way.reset.values()

    def with_trees(self, tree: Callable[[Equation], Expression]) -> ModeEquations:
        """Equations with other trees under the same texts."""

        def renew(equations: Mapping[str, Equation]) -> dict[str, Equation]:
            return {key: replace(e, tree=tree(e)) for key, e in equations.items()}

        flow, slaved = renew(self.flow), renew(self.slaved)
        guards = [replace(way.guard, tree=tree(way.guard)) for way in self.exits]
        exits = tuple(
            replace(way, guard=guard, reset=renew(way.reset))
            for way, guard in zip(self.exits, guards, strict=True)
        )
        return replace(self, definitions={}, flow=flow, slaved=slaved, exits=exits)


def read_mode(
    name: str,
    mode: Mode,
    place: str,
    *,
    states: tuple[str, ...],
    modes: tuple[str, ...],
    known: set[str],
    definitions: Mapping[str, Equation],
) -> ModeEquations:
    """Parse the texts of a mode; every name in them must be known."""
    own = {
        key: Equation.read(text, f"{place}.definitions[{key!r}]", known)
        for key, text in mode.definitions.items()
    }
    flow_place = place if place == "equations" else f"{place}.flow"
    flow = {
        key: Equation.read(mode.flow[key], f"{flow_place}[{key!r}]", known)
        for key in states
        if key in mode.flow
    }
    slaved = {
        key: _relation(text, f"{place}.slaved[{key!r}]", known) for key, text in mode.slaved.items()
    }
    exits = tuple(
        _exit(way, f"{place}.exits[{position}]", name, states, modes, known)
        for position, way in enumerate(mode.exits)
    )
    return ModeEquations(name, {**definitions, **own}, flow, slaved, exits)


def _exit(
    way: Exit,
    place: str,
    mode: str,
    states: tuple[str, ...],
    modes: tuple[str, ...],
    known: set[str],
) -> ExitEquations:
    target = way.to or mode
    if target != STOP and target not in modes:
        raise ModelError(f"{place}.to: {unknown_name('mode', target, (*modes, STOP))}")
    for state in way.reset:
        if state not in states:
            raise ModelError(f"{place}.reset: {unknown_name('state', state, states)}")
    guard = Equation.read(way.guard, f"{place}.guard", known)
    if target == mode and not way.reset:
        raise ModelError(
            f"{place}: the exit leads back to its own mode {target!r} without a reset, so its"
            " guard stays negative; add reset=, or another mode in to="
        )
    reset = {
        state: Equation.read(text, f"{place}.reset[{state!r}]", known)
        for state, text in way.reset.items()
    }
    if way.sticks is not None and target != mode:
        raise ModelError(
            f"{place}: sticks={way.sticks!r} is for an exit that rebounds, and this one leads to"
            f" {target!r}; leave out to= or sticks="
        )
    if way.sticks is not None and (not way.reset or way.sticks in modes):
        cure = "add reset=" if not way.reset else "choose another name"
        why = "has no reset" if not way.reset else "is the name of a mode already"
        raise ModelError(f"{place}: sticks={way.sticks!r} {why}; {cure}")
    return ExitEquations(way.name or target, target, guard, reset, way.sticks)


def check_guards(mode: ModeEquations, moving: set[str]) -> None:
    """Refuse guards in which nothing stands that changes: a wall where only its place is told.

    moving: states, signals, the time and parameters that are slow
    """
    for way in mode.exits:
        found, left = set(), name_set(way.guard.tree)
        while left:
            found |= left
            left = {
                name
                for each in left & set(mode.definitions)
                for name in name_set(mode.definitions[each].tree)
            } - found
        if found.isdisjoint(moving):
            guard = way.guard.text.strip()
            place = guard if is_name(guard) else "g"
            raise ModelError(
                f"{way.guard.where}: {quote(guard)} depends on no state and not on the time, so it"
                f" never changes; write a distance such as {place} - x, positive inside the mode"
                " and negative beyond"
            )


def is_relation(text: Text) -> bool:
    """Whether a slaved equation is ``left = right`` instead of an expression."""
    return isinstance(text, str) and bool(_EQUALS.search(text))


def _relation(text: Text, where: str, known: set[str]) -> Equation:
    """Equation of a slaved state; ``left = right`` is read as ``left - right``."""
    if not is_relation(text):
        return Equation.read(text, where, known)
    sides = _EQUALS.split(str(text))
    if len(sides) != 2 or not all(side.strip() for side in sides):
        raise ModelError(
            f"{where}: a relation has one '=' between two expressions, not {quote(text)}"
        )
    left = Equation.read(sides[0], where, known).tree
    # blanks in place of the left side keep the caret of a message in its column
    right = Equation.read(" " * (len(sides[0]) + 1) + sides[1], where, known).tree
    return Equation(str(text), where, subtract(left, right))
