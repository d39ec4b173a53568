"""One shape of a drawing: read from a table, checked, and worked out for all frames at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.drawings import outlines
from nonsmooth.drawings.frames import DrawnShape
from nonsmooth.drawings.roles import ROLES
from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.system.text.evaluate import constant_value, evaluate
from nonsmooth.system.text.expressions import Expression, names_in
from nonsmooth.system.text.grammar import parse, parse_condition

__all__ = ["ALONG", "Shape"]

ALONG = "s"  # runs from 0 to 1 along a curve
_ALONG_POINTS = 121
_COMMON = ("kind", "role", "modes", "when")
_MOST = 200  # turns or strokes

Coordinate = Expression | tuple["Coordinate", ...]


class _Kind(NamedTuple):
    """What a kind of shape is made of: its coordinates by sort, and what draws them."""

    drawn: Literal["area", "line", "text"]
    coordinates: Mapping[str, str]  # "number", "size", "pair" or "points"
    outline: Callable[..., outlines.Outline]
    number: tuple[str, int] | None = None  # name and default of a whole number
    role: str = "body"


_KINDS = {
    "rectangle": _Kind("area", {"x": "pair", "y": "pair"}, outlines.rectangle),
    "circle": _Kind("area", {"centre": "pair", "radius": "size"}, outlines.circle),
    "polygon": _Kind("area", {"points": "points"}, outlines.polyline),
    "region": _Kind("area", {"x": "number", "y": "number"}, lambda x, y: (x, y)),
    "line": _Kind("line", {"points": "points"}, outlines.polyline, role="rod"),
    "curve": _Kind("line", {"x": "number", "y": "number"}, lambda x, y: (x, y), role="rod"),
    "spring": _Kind(
        "line", {"start": "pair", "end": "pair", "width": "number"}, outlines.spring,
        ("turns", 5), "spring",
    ),
    "damper": _Kind(
        "line", {"start": "pair", "end": "pair", "width": "number"}, outlines.damper, role="damper"
    ),
    "ground": _Kind(
        "line", {"start": "pair", "end": "pair", "depth": "number"}, outlines.ground,
        ("strokes", 12), "ground",
    ),
    "arrow": _Kind(
        "line", {"start": "pair", "end": "pair", "head": "size"}, outlines.arrow, role="force"
    ),
    "text": _Kind("text", {"at": "pair"}, lambda at: outlines.polyline([at]), role="label"),
}  # fmt: skip


@dataclass(frozen=True)
class Shape:
    """A shape whose coordinates are expressions."""

    kind: str
    coordinates: Mapping[str, Coordinate]
    role: str
    count: int | None = None
    modes: tuple[str, ...] | None = None
    when: Expression | None = None
    text: str = ""

    @classmethod
    def read(cls, table: Any, where: str) -> Shape:
        """Shape of a table of TOML."""
        if not isinstance(table, Mapping):
            raise ModelError(f"{where}: a shape is a table, such as kind = 'circle' and so on")
        name = table.get("kind")
        if name not in _KINDS:
            raise ModelError(f"{where}: {unknown_name('kind', name, _KINDS)}")
        kind, where = _KINDS[str(name)], f"{where} ({name})"
        more = ["text"] if kind.drawn == "text" else []
        more += [kind.number[0]] if kind.number else []
        for key in table:
            if key not in (*_COMMON, *kind.coordinates, *more):
                known = [*kind.coordinates, *more, *_COMMON]
                raise ModelError(f"{where}: {unknown_name('key', key, known)}")
        for key in (*kind.coordinates, *more[: kind.drawn == "text"]):
            if key not in table:
                raise ModelError(f"{where}: {key} is missing")
        return cls(
            kind=str(name),
            coordinates={
                key: _coordinate(table[key], sort, f"{where}: {key}")
                for key, sort in kind.coordinates.items()
            },
            role=_role(table.get("role", kind.role), where),
            count=_count(table, kind.number, where) if kind.number else None,
            modes=_modes(table["modes"], where) if "modes" in table else None,
            when=parse_condition(table["when"], where=f"{where}: when")
            if "when" in table
            else None,
            text=_text(table.get("text", ""), f"{where}: text"),
        )

    def expressions(self) -> Iterator[tuple[str, Expression]]:
        """All expressions, with the keys that they stand under."""
        for key, value in self.coordinates.items():
            yield from ((key, one) for one in _leaves(value))
        if self.when is not None:
            yield "when", self.when

    @property
    def runs_along(self) -> bool:
        """Whether ``s`` is a name in the coordinates."""
        return self.kind in ("curve", "region")

    def drawn(
        self, values: Mapping[str, Any], modes: npt.NDArray[np.str_], words: Callable[[str], str]
    ) -> DrawnShape:
        """The shape in all frames; ``words`` puts numbers into a text."""
        kind = _KINDS[self.kind]
        if self.runs_along:
            values = {name: np.asarray(value)[..., None] for name, value in values.items()}
            values[ALONG] = np.linspace(0.0, 1.0, _ALONG_POINTS)
        made = {key: _evaluated(value, values) for key, value in self.coordinates.items()}
        counted = () if self.count is None else (self.count,)
        x, y = kind.outline(*made.values(), *counted)
        x, y = np.broadcast_arrays(np.atleast_2d(x), np.atleast_2d(y))
        visible = np.ones(1, bool)
        if self.when is not None:
            visible = np.atleast_1d(np.asarray(evaluate(self.when, values), bool)).reshape(-1)
        if self.modes is not None:
            visible = visible & np.isin(modes, self.modes)
        return DrawnShape(kind.drawn, x, y, visible, self.role, words(self.text))


def _leaves(value: Coordinate) -> Iterator[Expression]:
    if isinstance(value, tuple):
        for each in value:
            yield from _leaves(each)
    else:
        yield value


def _evaluated(value: Coordinate, values: Mapping[str, Any]) -> Any:
    if isinstance(value, tuple):
        return [_evaluated(each, values) for each in value]
    return evaluate(value, values)


def _coordinate(given: Any, sort: str, where: str) -> Coordinate:
    if sort in ("number", "size"):
        found = parse(given, where=where)
        if sort == "size" and not names_in(found) and not constant_value(found, {}) >= 0.0:
            raise ModelError(f"{where} = {quote(given)}: a size is not negative")
        return found
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise ModelError(f"{where} = {quote(given)}: give a list")
    if sort == "pair":
        if len(given) != 2:
            raise ModelError(f"{where} = {quote(given)}: give two numbers or texts")
        return tuple(parse(each, where=where) for each in given)
    if len(given) < 2:
        raise ModelError(f"{where} = {quote(given)}: give two points or more")
    return tuple(_coordinate(each, "pair", where) for each in given)


def _role(given: Any, where: str) -> str:
    if given not in ROLES:
        raise ModelError(f"{where}: {unknown_name('role', given, ROLES)}")
    return str(given)


def _count(table: Mapping[str, Any], count: tuple[str, int], where: str) -> int:
    name, usual = count
    given = table.get(name, usual)
    if not isinstance(given, int) or isinstance(given, bool) or not 1 <= given <= _MOST:
        raise ModelError(
            f"{where}: {name} = {quote(given)} must be a whole number from 1 to {_MOST}"
        )
    return given


def _modes(given: Any, where: str) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
        raise ModelError(f"{where}: modes = {quote(given)}: give a list of names of modes")
    return tuple(given)


def _text(given: Any, where: str) -> str:
    if not isinstance(given, str):
        raise ModelError(f"{where} = {quote(given)}: give a text")
    return given
