"""Equations: a text, where it stands, and its tree; and how they refer to each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.parts import Text
from nonsmooth.system.text.expressions import Call, Expression, Name, names_in, walk
from nonsmooth.system.text.grammar import parse, point_at

__all__ = ["Equation", "check_references"]

_MOST_NODES = 250_000  # of a definition with everything that it refers to written out


@dataclass(frozen=True, slots=True)
class Equation:
    """A text, where it stands in the system, and its tree."""

    text: str
    where: str
    tree: Expression

    @classmethod
    def read(cls, text: Text, where: str, known: set[str]) -> Equation:
        """Parse a text and check that every name in it is declared."""
        tree = parse(text, where=where)
        for name in names_in(tree):
            if name.name not in known:
                sentence = unknown_name("name", name.name, known - {"pi", "t"})
                raise ModelError(point_at(str(text), name.at, f"{where}: {sentence}"))
        return cls(str(text), where, tree)


def check_references(equations: Mapping[str, Equation], states: Iterable[str]) -> None:
    """Refuse definitions in a circle, rates of what is no state, and exploding chains.

    Walked without recursion: chains may be longer than Python's stack is deep.
    """
    known = set(states)
    sizes: dict[str, int] = {}
    for first in equations:
        if first in sizes:
            continue
        path: dict[str, Iterator[str]] = {
            first: iter(_references(equations[first], equations, known))
        }
        while path:
            name = next(reversed(path))
            step = next(path[name], None)
            if step is None:
                sizes[name] = _written_out(equations, name, known, sizes)
                path.pop(name)
            elif step in path:
                circle = " -> ".join([*path, step])
                raise ModelError(f"{equations[step].where}: {circle} goes in a circle; break it")
            elif step not in sizes:
                path[step] = iter(_references(equations[step], equations, known))


def _written_out(
    equations: Mapping[str, Equation], name: str, states: set[str], sizes: dict[str, int]
) -> int:
    """Nodes of an equation with all definitions in it written out."""
    equation = equations[name]
    own = sum(1 for _ in walk(equation.tree))
    total = own + sum(sizes[other] for other in _references(equation, equations, states))
    if total > _MOST_NODES:
        raise ModelError(
            f"{equation.where}: with its definitions written out it has more than"
            f" {_MOST_NODES:,} parts; shorten the chain of definitions"
        )
    return total


def _references(
    equation: Equation, equations: Mapping[str, Equation], states: set[str]
) -> list[str]:
    """Names of other equations in an equation, one for each time that they appear."""
    found = []
    for node in walk(equation.tree):
        if isinstance(node, Call) and node.function == "rate":
            argument = node.arguments[0]
            if isinstance(argument, Name) and argument.name not in states:
                message = unknown_name("state or signal in rate()", argument.name, states)
                raise ModelError(
                    point_at(equation.text, argument.at, f"{equation.where}: {message}")
                )
        elif isinstance(node, Name) and node.name in equations:
            found.append(node.name)
    return found
