"""Modes with piecewise texts split into cells, in each of which all texts are smooth.

The signs of the switching functions decide one after the other, innermost calls first, so
the cells of a mode are the leaves of a decision tree: a surface that stands inside one side
of another exists on that side only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from nonsmooth.errors import ModelError
from nonsmooth.system.equations import Equation
from nonsmooth.system.expressions import Expression, to_text, written_out
from nonsmooth.system.graph import Graph
from nonsmooth.system.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.resolve import Resolver
from nonsmooth.system.switching import Surface, SurfaceKey, Undecided

__all__ = ["Cell", "SplitMode", "split"]

_MOST_CELLS = 64  # of one mode
_LONGEST = 200  # nodes of a switching function that is shown in full
_SIGNS = {1: "+", -1: "-"}

Signs = dict[SurfaceKey, int]


@dataclass(frozen=True)
class Cell:
    """One leaf: the signs on the way to it, and the surfaces with those signs."""

    signs: Signs
    surfaces: tuple[Surface, ...]


@dataclass(frozen=True)
class _Branch:
    surface: Surface
    above: _Branch | Cell
    below: _Branch | Cell


@dataclass
class SplitMode:
    """A declared mode as its cells; a smooth mode is one cell without a surface."""

    equations: ModeEquations
    cells: list[Cell] = field(default_factory=list)
    names: dict[SurfaceKey, str] = field(default_factory=dict)
    nodes: dict[str, Expression] = field(default_factory=dict)
    root: _Branch | Cell | None = None

    def leaf(self, signs: Mapping[SurfaceKey, int]) -> Cell:
        """Cell with these signs; on surfaces that they leave out the positive side."""
        place = self.root
        while isinstance(place, _Branch):
            place = place.above if signs.get(place.surface.key, 1) > 0 else place.below
        assert place is not None
        return place

    def signs_of(self, cell: Cell) -> str:
        """Signs of a cell in the order of the surfaces; '.' where a surface does not exist."""
        return "".join(_SIGNS.get(cell.signs.get(key, 0), ".") for key in self.names)

    def name_of(self, cell: Cell) -> str:
        """Name of the mode with the signs of a cell."""
        return (
            f"{self.equations.name}[{self.signs_of(cell)}]" if self.names else self.equations.name
        )

    def text_of(self, surface: str) -> str:
        """Switching function of a surface as text."""
        return _shown(self.nodes[surface])

    def surfaces_of(self, cell: Cell) -> Iterator[tuple[str, str]]:
        """Names of the surfaces of a cell with their signs."""
        for surface in cell.surfaces:
            yield self.names[surface.key], _SIGNS[cell.signs[surface.key]]

    def equations_of(self, graph: Graph, cell: Cell) -> ModeEquations:
        """Equations of a cell: those of the mode, with an exit through each surface first."""
        exits = []
        for surface in cell.surfaces:
            name = self.names[surface.key]
            positive = cell.signs[surface.key] > 0
            node = surface.node if positive else graph.negate(surface.node)
            place = f"modes[{self.equations.name!r}], surface {name}"
            guard = Equation(_shown(node), place, node)
            exits.append(ExitEquations(name, self.equations.name, guard, {}))
        return replace(self.equations, exits=(*exits, *self.equations.exits))

    def targets_of(self, cell: Cell, modes: Mapping[str, SplitMode]) -> Iterator[Cell | None]:
        """Cell that each exit of a cell enters; None where it ends the run.

        Signs that are known here are kept in the mode entered, as far as it has the same
        surfaces: what does not fit settles through the exits there.
        """
        for surface in cell.surfaces:
            yield self.leaf(cell.signs | {surface.key: -cell.signs[surface.key]})
        for way in self.equations.exits:
            entered = modes.get(way.target)
            yield None if entered is None else entered.leaf(cell.signs)


def split(graph: Graph, equations: ModeEquations) -> SplitMode:
    """Cells of a mode; parameter values play no part."""
    found = SplitMode(equations)
    found.root = _grown(graph, found, {}, ())
    return found


def _grown(
    graph: Graph, found: SplitMode, signs: Signs, surfaces: tuple[Surface, ...]
) -> _Branch | Cell:
    try:
        Resolver(graph, found.equations, signs).resolved()
    except Undecided as open_:
        surface = open_.surface
    else:
        cell = Cell(signs, surfaces)
        found.cells.append(cell)
        if len(found.cells) > _MOST_CELLS:
            raise ModelError(
                f"modes[{found.equations.name!r}]: its piecewise texts make more than"
                f" {_MOST_CELLS} cells; write some of its sides as modes of their own, with exits"
                " between them"
            )
        return cell
    name = found.names.setdefault(surface.key, f"s{len(found.names) + 1}")
    found.nodes.setdefault(name, surface.node)
    above, below = (
        _grown(graph, found, {**signs, surface.key: sign}, (*surfaces, surface)) for sign in (1, -1)
    )
    return _Branch(surface, above, below)


def _shown(node: Expression) -> str:
    return to_text(node) if written_out([node]) <= _LONGEST else "a long switching function"
