"""Modes with piecewise texts split into cells, in each of which all texts are smooth.

The signs of the switching functions decide one after the other, innermost calls first, so
the cells of a mode are the leaves of a decision tree: a surface that stands inside one side
of another exists on that side only. A sign that the others and the requirements of the system
exclude makes no cell. Where motion may slide, cells on the surfaces come beside
them (`sliding`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.cells.exclusions import Inequality, excluded
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.equations.switching import Declared, SurfaceKey, SwitchingSurface, Undecided
from nonsmooth.system.text.expressions import Expression, to_text, written_out

__all__ = [
    "MOST_MODES",
    "Cell",
    "MakeResolver",
    "Signs",
    "SplitMode",
    "shown",
    "sides_of",
    "split",
]

MOST_MODES = 1000  # cells counted one by one: their tables take memory, and set-up takes time
_LONGEST = 200  # nodes of a switching function that is shown in full
_SIGNS = {1: "+", 0: "0", -1: "-"}

Signs = dict[SurfaceKey, int]
MakeResolver = Callable[[Mapping[SurfaceKey, int]], Resolver]


@dataclass(frozen=True, eq=False)
class Cell:
    """One leaf: the signs on the way to it, and the surfaces with those signs.

    A cell on a surface, where motion slides, has the sign 0 there, and as ``surfaces`` the others.
    """

    signs: Signs
    surfaces: tuple[SwitchingSurface, ...]

    @property
    def on(self) -> tuple[SurfaceKey, ...]:
        """Surfaces on which the cell lies."""
        return tuple(key for key, sign in self.signs.items() if sign == 0)

    def agrees(self, signs: Mapping[SurfaceKey, int]) -> bool:
        """Whether the cell has the signs given, where it has a sign at all."""
        return all(self.signs.get(key, sign) == sign for key, sign in signs.items())


@dataclass(frozen=True)
class _Branch:
    surface: SwitchingSurface
    above: _Branch | Cell
    below: _Branch | Cell


@dataclass
class SplitMode:
    """A mode as its cells; a smooth mode is one cell without a surface.

    ``cells`` fill space between the surfaces, ``sliding`` ones lie on them.
    """

    equations: ModeEquations
    make_resolver: MakeResolver
    cells: list[Cell] = field(default_factory=list)
    sliding: list[Cell] = field(default_factory=list)
    names: dict[SurfaceKey, str] = field(default_factory=dict)
    nodes: dict[str, Expression] = field(default_factory=dict)
    declared: Mapping[SurfaceKey, Declared] = field(default_factory=dict)
    facts: tuple[Inequality, ...] = ()  # that hold for all values of the parameters
    root: _Branch | Cell | None = None
    _resolvers: dict[frozenset[tuple[SurfaceKey, int]], Resolver] = field(default_factory=dict)

    def leaf(self, signs: Mapping[SurfaceKey, int]) -> Cell:
        """Cell with these signs; on surfaces that they leave out the positive side."""
        place = self.root
        while isinstance(place, _Branch):
            place = place.above if signs.get(place.surface.key, 1) >= 0 else place.below
        assert place is not None
        return place

    def cell(self, signs: Mapping[SurfaceKey, int]) -> Cell:
        """Cell with these signs: the sliding one on most of their surfaces, else a leaf."""
        on = {key for key, sign in signs.items() if sign == 0}
        found = [c for c in self.sliding if on.issuperset(c.on) and c.agrees(signs)]
        return max(found, key=lambda c: len(c.on)) if found else self.leaf(signs)

    def signs_of(self, cell: Cell) -> str:
        """Signs of a cell in the order of the surfaces; '.' where a surface does not exist."""
        return "".join(self._sign(cell, key) for key in self.names)

    def _sign(self, cell: Cell, key: SurfaceKey) -> str:
        sign = cell.signs.get(key)
        turned = key in self.declared and self.declared[key].turned
        return "." if sign is None else _SIGNS[-sign if turned else sign]

    def name_of(self, cell: Cell) -> str:
        """Name of the mode with the signs of a cell."""
        return (
            f"{self.equations.name}[{self.signs_of(cell)}]" if self.names else self.equations.name
        )

    def text_of(self, surface: str) -> str:
        """Switching function of a surface as text; as it is given where it is declared."""
        for declared in self.declared.values():
            if declared.name == surface:
                return str(declared.given.function)
        return shown(self.nodes[surface])

    def surfaces_of(self, cell: Cell) -> Iterator[tuple[str, str]]:
        """Names of the surfaces of a cell with their signs, in the order of `signs_of`."""
        for key in self.names:
            if key in cell.signs:
                yield self.names[key], self._sign(cell, key)

    def through(self, graph: Graph, cell: Cell, surface: SwitchingSurface) -> ExitEquations:
        """Exit of a cell through one of its surfaces."""
        name = self.names[surface.key]
        node = surface.node if cell.signs[surface.key] > 0 else graph.negate(surface.node)
        place = f"modes[{self.equations.name!r}], surface {name}"
        return ExitEquations(name, self.equations.name, Equation(shown(node), place, node), {})

    def resolver(self, signs: Mapping[SurfaceKey, int]) -> Resolver:
        """Nodes of the equations between the surfaces, by signs."""
        given = frozenset(signs.items())
        if given not in self._resolvers:
            self._resolvers[given] = self.make_resolver(signs)
        return self._resolvers[given]


def split(
    equations: ModeEquations,
    declared: Mapping[str, Declared],
    make_resolver: MakeResolver,
    facts: tuple[Inequality, ...] = (),
) -> SplitMode:
    """Cells of a mode; parameter values play no part, but for ``facts`` that are required of them.

    ``declared`` surfaces have names of their own and come first; others are numbered.
    """
    found = SplitMode(
        equations,
        make_resolver,
        declared={each.surface.key: each for each in declared.values()},
        facts=facts,
    )
    found.root = _grown(found, {}, ())
    order = [key for key in found.declared if key in found.names]
    order += [key for key in found.names if key not in found.declared]
    found.names = {key: found.names[key] for key in order}
    found.nodes = {name: found.nodes[name] for name in found.names.values()}
    return found


def _grown(
    found: SplitMode, signs: Signs, surfaces: tuple[SwitchingSurface, ...]
) -> _Branch | Cell:
    try:
        found.resolver(signs).resolved()
    except Undecided as open_:
        surface = open_.surface
    else:
        cell = Cell(signs, surfaces)
        found.cells.append(cell)
        if len(found.cells) > MOST_MODES:
            raise ModelError(
                f"modes[{found.equations.name!r}]: its piecewise texts make more than"
                f" {MOST_MODES} cells; write some of its sides as modes of their own, with exits"
                " between them"
            )
        return cell
    if surface.key not in found.names:
        declared = found.declared.get(surface.key)
        name = _unused(found) if declared is None else declared.name
        found.names[surface.key], found.nodes[name] = name, surface.node
    sides = [{**signs, surface.key: sign} for sign in (1, -1)]
    possible = [side for side in sides if not excluded([*found.facts, *sides_of(side)])]
    if len(possible) == 1:  # the motion is always on that side, so nothing leads through
        return _grown(found, possible[0], surfaces)
    above, below = (_grown(found, side, (*surfaces, surface)) for side in sides)
    return _Branch(surface, above, below)


def sides_of(signs: Mapping[SurfaceKey, int]) -> Iterator[Inequality]:
    """What signs say of the terms of their switching functions."""
    for key, sign in signs.items():
        if sign != 0:
            terms = {factors: sign * Fraction(value) for factors, value in key}
            yield Inequality(terms, strict=True)


def _unused(found: SplitMode) -> str:
    """Name of the next surface that has none."""
    taken = {*found.nodes, *(each.name for each in found.declared.values())}
    return next(name for i in count(1) if (name := f"s{i}") not in taken)


def shown(node: Expression) -> str:
    """Text of a node; a word in place of a very long one."""
    return to_text(node) if written_out([node]) <= _LONGEST else "a long switching function"
