"""Every cell that runs, with its exits and where they lead.

Between the surfaces of a mode lie its leaves; on them lie sliding cells; and where exits stick
there are modes at rest, with cells of their own. An exit through a surface, or one that
rebounds, may have another one beside it that leads ``onto`` the surface: it is never searched
for, and is taken when both sides point at the surface, or when rebounds have accumulated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

from nonsmooth.engine.tables import CROSS, FREE, NO_CHOICE, RESTING, SLIDES, STAY
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import substituted, vanishes
from nonsmooth.system.algebra.points import put_on
from nonsmooth.system.cells.cells import Cell, SplitMode, shown, split
from nonsmooth.system.cells.exclusions import Inequality
from nonsmooth.system.cells.intersections import meetings_of
from nonsmooth.system.cells.sliding import Slide, related, slides_of, solved_for
from nonsmooth.system.cells.sticking import (
    Rest,
    contacts_at_rest,
    leaves_at_rest,
    may_rest,
    rest_of,
)
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.equations.switching import Declared, SurfaceKey
from nonsmooth.system.text.expressions import Expression

__all__ = ["RELEASE", "Family", "Piece", "families_of", "pieces_of"]

RELEASE = "release"  # exit of a mode of rest, where nothing presses any more


@dataclass(eq=False)
class Family:
    """A mode with all its cells: a declared one, or one with some of its exits at rest."""

    name: str
    split: SplitMode
    declared: str  # mode whose exits these are
    free: SplitMode  # that mode
    resting: tuple[int, ...] = ()  # its exits at rest
    slides: dict[int, Slide] = field(default_factory=dict)  # by id of their cells


@dataclass(frozen=True)
class Way:
    """An exit of a cell, the cell that it enters (None ends the run), and what lies beside it.

    ``onto`` leads onto the surface of the exit. Where the exit itself does, because the surface
    holds what arrives, ``across`` leads to the other side: a reset may jump there.
    ``choice`` is what a start does on the surface where both sides lead away from it.
    """

    exit: ExitEquations
    target: Cell | None
    onto: Way | None = None
    across: Way | None = None
    choice: int = NO_CHOICE


@dataclass(frozen=True)
class Piece:
    """A cell that runs."""

    family: Family
    cell: Cell
    kind: int
    equations: ModeEquations
    resolver: Resolver
    targets: tuple[Cell | None, ...]
    onto: tuple[int, ...]
    choices: tuple[int, ...]
    n_searched: int


def families_of(
    graph: Graph,
    modes: list[ModeEquations],
    declared: Mapping[str, Mapping[str, Declared]],
    facts: tuple[Inequality, ...] = (),
) -> dict[str, Family]:
    """Modes and modes at rest, by name; ``declared`` surfaces by mode and name.

    ``facts`` are what is required of the parameters.
    """
    found: dict[str, Family] = {}
    for equations in modes:
        own = declared[equations.name]

        def free(signs: Mapping[SurfaceKey, int], equations: ModeEquations = equations) -> Resolver:
            return Resolver(graph, equations, signs)

        mode = split(equations, own, free, facts)
        found[equations.name] = Family(equations.name, mode, equations.name, mode)
    for family in list(found.values()):
        equations = family.split.equations
        together = partial(_together, graph, family.split)
        for which in contacts_at_rest(equations, together):
            words = dict.fromkeys(str(equations.exits[i].sticks) for i in which)
            name = _unused("+".join(words), found)
            mode = _at_rest(graph, family.split, which, name, declared[equations.name])
            found[name] = Family(name, mode, equations.name, family.split, which)
    for family in found.values():
        _add_slides(graph, family)
    return found


def _together(graph: Graph, mode: SplitMode, which: tuple[int, ...]) -> bool:
    """Whether exits can be at rest at the same time in some cell of their mode."""
    return any(
        may_rest(graph, mode.equations, mode.resolver(cell.signs), which) for cell in mode.cells
    )


def _unused(name: str, taken: Mapping[str, object]) -> str:
    """Name with a number where modes of several exits stick by the same word."""
    count, made = 1, name
    while made in taken:
        count += 1
        made = f"{name}_{count}"
    return made


def _at_rest(
    graph: Graph,
    mode: SplitMode,
    which: tuple[int, ...],
    name: str,
    declared: Mapping[str, Declared],
) -> SplitMode:
    """Cells of a mode with some of its exits at rest."""

    def resting(signs: Mapping[SurfaceKey, int]) -> Resolver:
        rest = rest_of(graph, mode.equations, mode.resolver(signs), which)
        equations = related(replace(mode.equations, name=name), rest.relations, "at rest")
        return Resolver(graph, equations, signs, rates=rest.rates)

    found = split(replace(mode.equations, name=name), declared, resting, mode.facts)
    # states that follow are the same in all cells, but for texts that no machine has
    found.equations = resting(found.cells[0].signs).equations
    return found


def _add_slides(graph: Graph, family: Family) -> None:
    mode = family.split
    if not mode.names:
        return
    slides = list(slides_of(graph, mode))
    slides += meetings_of(graph, mode, [slide.cell.on[0] for slide in slides])
    for slide in slides:
        if not slide.attracting:
            continue
        mode.sliding.append(slide.cell)
        family.slides[id(slide.cell)] = slide


def pieces_of(graph: Graph, families: Mapping[str, Family]) -> Iterator[Piece]:
    """All cells in the order in which a start tries them: leaves before cells on surfaces."""
    for family in families.values():
        for cell in family.split.cells:
            yield _Maker(graph, families, family, cell).piece()
    for family in families.values():
        for cell in family.split.sliding:
            yield _Maker(graph, families, family, cell).piece()


class _Maker:
    """Makes the exits of one cell."""

    def __init__(
        self, graph: Graph, families: Mapping[str, Family], family: Family, cell: Cell
    ) -> None:
        self.graph = graph
        self.families = families
        self.family = family
        self.mode = family.split
        self.cell = cell
        self.slide = family.slides.get(id(cell))

    def piece(self) -> Piece:
        searched = [*self._along(), *self._releases(), *self._declared()]
        beside = [b for way in searched for b in (way.onto, way.across) if b is not None]
        beside += [self._beside("meeting", cell) for cell in self._meetings()]
        ways = [*searched, *beside]
        resolver = self._resolver
        equations = replace(resolver.equations, exits=tuple(way.exit for way in ways))
        kind = RESTING if self.family.resting else (FREE if self.slide is None else SLIDES)
        return Piece(
            self.family,
            self.cell,
            kind,
            equations,
            resolver,
            tuple(way.target for way in ways),
            _onto(ways),
            tuple(way.choice for way in ways),
            len(searched),
        )

    @cached_property
    def _resolver(self) -> Resolver:
        """Nodes of the cell; its exits are made here."""
        if self.slide is None:
            return self.mode.resolver(self.cell.signs)
        return self.slide.resolver(self.graph, self.mode)

    # ------------------------------------------------------------ through and off surfaces

    def _along(self) -> Iterator[Way]:
        mode, signs = self.mode, self.cell.signs
        if self.slide is not None:
            for (key, sign), guard in self.slide.guards.items():
                yield self._way(mode.names[key], guard, mode.cell({**signs, key: sign}))
        for surface in self.cell.surfaces:
            key = surface.key
            through = mode.through(self.graph, self.cell, surface)
            on = self._cell_on(key)
            declared = mode.declared.get(key)
            target = mode.cell({**signs, key: -signs[key]})
            if on is not None and declared is not None and declared.hold is not None:
                yield Way(through, on, across=self._beside(through.name, target))
                continue
            onto = None if on is None else self._beside(through.name, on)
            yield Way(through, target, onto, choice=_choice(declared, signs[key]))

    def _cell_on(self, key: SurfaceKey) -> Cell | None:
        """Cell on one more surface, where there is one."""
        wanted = {**self.cell.signs, key: 0}
        found = self.mode.cell(wanted)
        return found if len(found.on) == len(self.cell.on) + 1 else None

    def _meetings(self) -> list[Cell]:
        """Cells where two surfaces of this one meet: motion may wind itself into them."""
        signs = {key: sign for key, sign in self.cell.signs.items() if sign != 0}
        n_on = len(self.cell.on)
        return [
            cell
            for cell in self.mode.sliding
            if len(cell.on) == n_on + 2
            and set(self.cell.on) < set(cell.on)
            and cell.agrees({k: s for k, s in signs.items() if k not in cell.on})
        ]

    # ------------------------------------------------------------ off contacts

    def _releases(self) -> Iterator[Way]:
        which = self.family.resting
        if not which:
            return
        rest = rest_of(self.graph, self.family.free.equations, self._free, which, self._leaf)
        for i, reaction in rest.reactions.items():
            fewer = self._resting(tuple(k for k in which if k != i))
            assert fewer is not None
            yield self._way(RELEASE, reaction, fewer.split.cell(self.cell.signs))

    @cached_property
    def _free(self) -> Resolver:
        """Nodes of the mode without contacts at rest, in the same cell."""
        free = self.family.free
        cell = free.cell(self.cell.signs)
        if cell.on:
            home = self.families[self.family.declared]
            slide = home.slides[id(cell)]
            return slide.resolver(self.graph, free)
        return free.resolver(cell.signs)

    @property
    def _leaf(self) -> Resolver:
        """The same in a cell beside the surfaces."""
        free = self.family.free
        return free.resolver(free.leaf(self.cell.signs).signs)

    def _resting(self, which: tuple[int, ...]) -> Family | None:
        """Family of the same mode with these exits at rest, where they can be so together."""
        home = self.family.declared
        found = (f for f in self.families.values() if (f.declared, f.resting) == (home, which))
        return next(found, None)

    # ------------------------------------------------------------ exits of the mode

    def _declared(self) -> Iterator[Way]:
        which, equations = self.family.resting, self.family.free.equations
        for i, way in enumerate(equations.exits):
            if i in which:
                continue
            entered = self.families.get(way.target)
            target = None if entered is None else entered.split.cell(self._signs_behind(way))
            more = tuple(sorted((*which, i)))
            resting = None if way.sticks is None else self._resting(more)
            # what happens elsewhere leaves at rest what is at rest
            stays = not which or self._stays_at_rest(i)
            if which and stays and way.target == self.family.declared:
                target = self.mode.cell(self._signs_behind(way))
            elif which and not way.reset:
                same = self._at_rest_in(way.target)
                target = target if same is None else same.split.cell(self.cell.signs)
            if resting is None or not stays or not self._comes_to_rest(i, more):
                yield Way(way, target)
                continue
            rest = rest_of(self.graph, equations, self._free, more)
            onto = self._beside(
                str(way.sticks), resting.split.cell(self.cell.signs), self._reset(rest, way)
            )
            yield Way(way, target, onto)

    def _at_rest_in(self, other: str) -> Family | None:
        """Another mode with the same contacts at rest, which nothing has to strike anew there."""
        entered = self.families.get(other)
        if entered is None:
            return None
        here = self.family.free.equations.exits
        there = [self._contact(entered.free, way) for way in entered.free.equations.exits]
        wanted = [self._contact(self.family.free, here[i]) for i in self.family.resting]
        if any(contact not in there for contact in wanted):
            return None
        resting = tuple(sorted(there.index(contact) for contact in wanted))
        found = (f for f in self.families.values() if (f.declared, f.resting) == (other, resting))
        return next(found, None)

    def _contact(self, mode: SplitMode, way: ExitEquations) -> tuple[object, ...]:
        """What an exit does that sticks, to be compared with those of other modes."""
        resolver = mode.resolver(mode.leaf(self.cell.signs).signs)
        reset = {state: resolver.tree(e) for state, e in way.reset.items()}
        return way.sticks, way.target == mode.equations.name, resolver.tree(way.guard), reset

    def _stays_at_rest(self, i: int) -> bool:
        """Whether an exit does not move what is at rest."""
        which, equations = self.family.resting, self.family.free.equations
        return leaves_at_rest(self.graph, equations, self._leaf, which, i)

    def _comes_to_rest(self, i: int, more: tuple[int, ...]) -> bool:
        """Whether an exit may come to rest beside those of the cell; sliding may leave no way."""
        if not self.cell.on:
            return True
        equations = self.family.free.equations
        kept = self._signs_behind(equations.exits[i]) == self.cell.signs
        return kept and may_rest(self.graph, equations, self._free, more)

    def _signs_behind(self, way: ExitEquations) -> dict[SurfaceKey, int]:
        """Signs of the cell without those of surfaces that a reset leaves."""
        signs = dict(self.cell.signs)
        if way.reset and self.cell.on:
            resolver = self._resolver
            resets = {state: resolver.tree(e) for state, e in way.reset.items()}
            nodes = [self.mode.nodes[self.mode.names[key]] for key in self.cell.on]
            points = put_on(self.graph, nodes, solved_for(self.graph, self.mode.equations, nodes))
            for key, node in zip(self.cell.on, nodes, strict=True):
                behind = substituted(self.graph, node, resets)
                if behind is not node and not vanishes([behind], [self.graph.one], points):
                    del signs[key]
        return signs

    def _reset(self, rest: Rest, way: ExitEquations) -> dict[str, Equation]:
        place = f"{way.guard.where.removesuffix('.guard')}, at rest"
        return {
            state: Equation(shown(node), f"{place}, {state}", node)
            for state, node in rest.arrival.items()
        }

    # ------------------------------------------------------------ ways that are no texts

    def _way(self, name: str, guard: Expression, target: Cell) -> Way:
        place = f"modes[{self.family.name!r}], {name}"
        equation = Equation(shown(guard), place, guard)
        return Way(ExitEquations(name, self.family.name, equation, {}), target)

    def _beside(self, name: str, target: Cell, reset: Mapping[str, Equation] | None = None) -> Way:
        """Exit that is never searched for: its guard is the constant one."""
        way = self._way(name, self.graph.one, target)
        return replace(way, exit=replace(way.exit, reset=reset or {}))


def _onto(ways: list[Way]) -> tuple[int, ...]:
    """Number of the way that leads onto the surface of each one, itself where it holds; or -1."""
    numbers = {id(way): i for i, way in enumerate(ways)}
    found = {i: numbers[id(way.onto)] for i, way in enumerate(ways) if way.onto is not None}
    for i, way in enumerate(ways):
        if way.across is not None:
            found[i] = found[numbers[id(way.across)]] = i
    return tuple(found.get(i, -1) for i in range(len(ways)))


def _choice(declared: Declared | None, sign: int) -> int:
    """What a start on one side of a surface does where both sides lead away from it."""
    if declared is None or declared.given.on_nonunique is None:
        return NO_CHOICE
    above = (declared.given.on_nonunique == "above") != declared.turned
    return STAY if above == (sign > 0) else CROSS
