"""Names of the degrees of freedom: a node, then a direction, such as ``3x`` and ``3rx``."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from nonsmooth.errors import ModelError, NonsmoothError, OptionError, quote, unknown_name

__all__ = [
    "NodePlane",
    "coordinate_names",
    "exchanged",
    "in_direction",
    "is_rotation",
    "node_plane",
    "place_of",
    "places_of",
    "planes",
]

_NAME = re.compile(r"(?P<node>.*?)(?P<space>[\s_.:-]*)(?P<direction>r?[xyz])")


class NodePlane(NamedTuple):
    """Two coordinates of one node, in x and y, by their places; a shaft turns from x to y."""

    node: str
    x: int
    y: int


def coordinate_names(given: Any, size: int) -> tuple[str, ...]:
    """Names of all coordinates, each another; numbered where none are given."""
    if given is None or (isinstance(given, tuple) and not given):
        return tuple(f"q{i}" for i in range(size))
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ModelError(f"coordinates = {quote(given)}: give a list of {size} names")
    names = tuple(given)
    for name in names:
        if not isinstance(name, str) or not name.strip():
            raise ModelError(f"coordinates: {quote(name)} is no name; give a text such as '3x'")
    if len(names) != size:
        raise ModelError(
            f"coordinates: {len(names)} names for {size} degrees of freedom; give one for each"
        )
    if len(set(names)) < size:
        twice = next(name for i, name in enumerate(names) if name in names[:i])
        raise ModelError(f"coordinates: {twice!r} stands twice; each has a name of its own")
    return tuple(map(str, names))


def _parted(name: str) -> tuple[str, str]:
    """Node and direction of a name; no direction where it ends otherwise."""
    found = _NAME.fullmatch(name)
    # a letter before the direction belongs to a word, such as "relax"
    if found is None or (not found["space"] and found["node"][-1:].isalpha()):
        return name, ""
    return found["node"], found["direction"]


def is_rotation(name: str) -> bool:
    """Whether a coordinate is an angle, which the last letters of its name say."""
    return _parted(name)[1].startswith("r")


def exchanged(x: str, y: str) -> bool:
    """Whether what stands for x is the y of a node, and what stands for y its x."""
    (node, first), (other, second) = _parted(x), _parted(y)
    return node == other and (first, second) in (("y", "x"), ("ry", "rx"))


def planes(names: Sequence[str], kind: str = "") -> list[NodePlane]:
    """Nodes that have displacements in both x and y, in order; of kind ``r``, their rotations."""
    place = {name: i for i, name in enumerate(names)}
    found = []
    for name in names:
        node, direction = _parted(name)
        other = f"{name[:-1]}y"
        if direction == f"{kind}x" and other in place:
            found.append(NodePlane(node, place[name], place[other]))
    return found


def node_plane(node: Any, names: Sequence[str], where: str) -> NodePlane:
    """The x and y of one node, given by its name or number."""
    known = planes(names)
    for each in known:
        if not isinstance(node, bool) and each.node in (str(node), f"node {node}"):
            return each
    raise OptionError(
        f"{where}: {unknown_name('node', node, [each.node for each in known])}; nodes are what"
        " stands before x and y in the names of coordinates"
    )


def place_of(
    name: Any, names: Sequence[str], where: str, error: type[NonsmoothError] = OptionError
) -> int:
    """Place of a coordinate, given by its name or number."""
    if isinstance(name, str):
        if name not in names:
            raise error(f"{where}: {unknown_name('coordinate', name, names)}")
        return list(names).index(name)
    try:
        place = operator.index(name)
    except TypeError:
        place = -1
    if isinstance(name, bool) or not 0 <= place < len(names):
        raise error(
            f"{where}: there is no coordinate {quote(name)}; give a name, or a number from 0 to"
            f" {len(names) - 1}"
        )
    return place


def places_of(
    given: Any, names: Sequence[str], where: str, error: type[NonsmoothError] = OptionError
) -> list[int]:
    """Places of several coordinates, or of one; None stands for all."""
    if given is None:
        return list(range(len(names)))
    single = isinstance(given, str) or not isinstance(given, Iterable)
    listed = [given] if single else list(given)
    if not listed:
        raise error(f"{where}: there is none; give at least one coordinate")
    found = [place_of(each, names, where, error) for each in listed]
    if len(set(found)) < len(found):
        raise error(f"{where} = {quote(given)}: a coordinate stands twice")
    return found


def in_direction(direction: str, names: Sequence[str]) -> list[int]:
    """Places of the displacements in one direction, ``x``, ``y`` or ``z``."""
    return [i for i, name in enumerate(names) if _parted(name)[1] == direction]
