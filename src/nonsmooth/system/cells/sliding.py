"""Cells on the surfaces of a mode, where motion slides by Filippov's convex combination.

Across a surface h = 0 the field jumps from f- to f+. Where both sides point at it, motion stays on
it with f = (1 + u)/2 f+ + (1 - u)/2 f-, and u such that h stays zero:

    u = (h_x f+ + h_x f-) / (h_x f- - h_x f+).

So a sliding cell is a cell as any other: it has rates, a state that follows from h = 0, and
exits where u reaches 1 or -1, written without a quotient. What is linear stays linear.
See A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988, and for the
algorithm P. Piiroinen and Y. Kuznetsov, An event-driven method to simulate Filippov systems, 2008.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from nonsmooth.system.algebra.differentiate import rate_of_change
from nonsmooth.system.algebra.frequencies import monomials
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import simplified, substituted, vanishes
from nonsmooth.system.algebra.linear import LinearForm, NotLinear, State
from nonsmooth.system.algebra.points import Points, put_on
from nonsmooth.system.algebra.rational import quotient, signed_sum, without_squares
from nonsmooth.system.cells.attraction import may_attract
from nonsmooth.system.cells.cells import Cell, Signs, SplitMode, shown
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ModeEquations
from nonsmooth.system.equations.resolve import Resolver, calls_of_motion
from nonsmooth.system.equations.switching import SurfaceKey, SwitchingSurface, switching_function
from nonsmooth.system.text.expressions import ZERO, Expression, Number, negate

__all__ = [
    "Slide", "attract", "between", "cell_on", "have_place", "related", "sides_on", "slides_of",
    "solved_for",
]  # fmt: skip

Sides = dict[Hashable, float]  # of surfaces, by what stands for them

_SURE = 1e-9  # of the numbers in a function, what it must be away from zero to be told from it
_SAME = 1e-12  # in which ratios of factors agree that are the same for all parameters


@dataclass(frozen=True)
class Slide:
    """Motion on one or two surfaces.

    ``guards`` are positive while motion stays, by surface and by the side on which it leaves.
    Where the sides cannot both point at the surface, it is not ``attracting``, and nothing more is
    told of it: motion stays on it at most where it slides on another one too.
    """

    cell: Cell
    rates: Mapping[str, Expression] = field(default_factory=dict)
    controls: Mapping[SurfaceKey, Expression] = field(default_factory=dict)
    relations: Mapping[str, Expression] = field(default_factory=dict)
    guards: Mapping[tuple[SurfaceKey, int], Expression] = field(default_factory=dict)
    attracting: bool = True

    def resolver(self, graph: Graph, mode: SplitMode) -> Resolver:
        """Nodes of the equations of a mode on the surfaces."""
        return Resolver(
            graph, self.equations(mode), self.cell.signs, controls=self.controls, rates=self.rates,
            on_surface=self.relations, motion=calls_of_motion(mode.equations),
        )  # fmt: skip

    def equations(self, mode: SplitMode) -> ModeEquations:
        """Equations of the mode with states that follow from the surfaces."""
        return related(mode.equations, self.relations, "on the surface")


def slides_of(graph: Graph, mode: SplitMode) -> Iterator[Slide]:
    """Motion on each surface of a mode across which the field jumps."""
    for key in mode.names:
        beside = [cell for cell in mode.cells if any(s.key == key for s in cell.surfaces)]
        above = [cell for cell in beside if cell.signs[key] == 1]
        below = [cell for cell in beside if cell.signs[key] == -1]
        faces: dict[int, _Faces] = {}
        for a in above:
            node = next(s.node for s in a.surfaces if s.key == key)
            if not graph.states_in(node):
                continue  # time passes
            if id(node) not in faces:
                faces[id(node)] = _Faces(graph, mode, node)
            elsewhere = {k: sign for k, sign in a.signs.items() if k != key}
            for b in below:
                if not b.agrees(elsewhere):
                    continue
                if faces[id(node)].meet(a, b):
                    slide = _slide(faces[id(node)], key, a, b)
                    if slide is not None:
                        yield slide


class _Faces:
    """The cells beside a surface as they are on it; what they share is worked out once.

    Nested piecewise functions make many cells, and each may lie beside each across a surface.
    """

    def __init__(self, graph: Graph, mode: SplitMode, node: Expression) -> None:
        self.graph = graph
        self.mode = mode
        self.node = node
        self.relations = solved_for(graph, mode.equations, [node])
        self.points = put_on(graph, [node], self.relations)
        self._rates: dict[int, Expression] = {}
        self._sides: dict[int, Sides | None] = {}

    def points_of(self, width: Expression) -> Points | None:
        """Points of the surface where the difference of two rates does not vanish; None for none.

        A surface such as ``(x - 1)*(y - 2) - 1e-9`` has branches, and on one of them what y does
        may come to nothing.
        """
        if not vanishes([width], points=self.points):
            return self.points
        for state in sorted(self.graph.states_in(self.node)) if not self.relations else ():
            points = put_on(self.graph, [self.node], {}, state)
            if not vanishes([width], points=points):
                return points
        return None

    def meet(self, a: Cell, b: Cell) -> bool:
        """Whether two cells beside the surface may have a place on it in common."""
        return have_place([self._sides_of(a), self._sides_of(b)])

    def _sides_of(self, cell: Cell) -> Sides | None:
        if id(cell) not in self._sides:
            self._sides[id(cell)] = sides_on(self.graph, cell, [self.node], self.on_surface)
        return self._sides[id(cell)]

    def on_surface(self, node: Expression) -> Expression:
        """An expression with the states that follow from the surface."""
        return simplified(self.graph, substituted(self.graph, node, self.relations))

    def rate(self, cell: Cell) -> Expression:
        """Rate of the switching function on the side of a cell."""
        if id(cell) not in self._rates:
            rate = self.mode.resolver(cell.signs).rate
            self._rates[id(cell)] = self.on_surface(rate_of_change(self.graph, self.node, rate))
        return self._rates[id(cell)]


def sides_on(
    graph: Graph, cell: Cell, nodes: Sequence[Expression],
    on_surface: Callable[[Expression], Expression],
) -> Sides | None:  # fmt: skip
    """On which side of its other surfaces a cell lies where some are zero; None where it is not.

    One may come no nearer than some distance, as ``x < -1`` to ``x = 0``.
    """
    numbers = [number for node in nodes for number in monomials(node).values()]
    found: Sides = {}
    for surface in cell.surfaces:
        if any(surface.node is node for node in nodes):
            continue
        switch = switching_function(graph, on_surface(surface.node))
        sign = switch.sign * cell.signs[surface.key]
        if switch.surface is not None:
            place: Hashable = switch.surface.key
        elif isinstance(switch.constant, Number):
            largest = max(map(abs, [*monomials(surface.node).values(), *numbers]))
            if switch.constant.value * sign < -_SURE * largest:
                return None
            continue
        else:
            place = switch.constant
        if found.setdefault(place, sign) != sign:
            return None
    return found


def have_place(sides: Sequence[Sides | None]) -> bool:
    """Whether cells may have a place in common, by their `sides_on` the surfaces between them.

    Other surfaces may become one there, and the cells lie on different sides of it. Then a jump
    between their rates is none that a motion meets.
    """
    together: Sides = {}
    for each in sides:
        if each is None or any(together.setdefault(k, sign) != sign for k, sign in each.items()):
            return False
    return True


def _slide(faces: _Faces, key: SurfaceKey, a: Cell, b: Cell) -> Slide | None:
    graph, mode, relations = faces.graph, faces.mode, faces.relations
    on_surface = faces.on_surface
    up, down = faces.rate(a), faces.rate(b)
    if up is down:
        return None
    width = on_surface(signed_sum(graph, (down, up), (1, -1)))
    points = faces.points_of(width)
    if points is None:
        return None
    cell = cell_on(mode, (a, b), (key,))
    sides = [mode.resolver(c.signs) for c in (a, b)]
    hold = _hold(mode, key)
    if hold is None and not attract(graph, mode, [faces.node], [up, down]):
        return Slide(cell, attracting=False)
    up, down = without_squares(graph, up, down)
    width = on_surface(graph.add(down, graph.negate(up)))
    control = quotient(graph, on_surface(graph.add(up, down)), width)
    rates = {}
    for state in mode.equations.flow:
        if state not in relations:
            plus, minus = (on_surface(side.rate(state)) for side in sides)
            rate = between(graph, plus, minus, control, points)
            # the only state of a surface that does not move stays where it is: what rounding leaves
            # of its rate would couple it to the others, and make their motions nearly defective
            alone = graph.states_in(faces.node) == {state} and vanishes([rate])
            rates[state] = graph.zero if alone else rate
    guards = _guards(graph, key, up, down, hold)
    return Slide(cell, rates, {key: control}, relations, guards)


def attract(
    graph: Graph, mode: SplitMode, surfaces: list[Expression], rates: Sequence[Expression]
) -> bool:
    """Whether the rates of a switching function around surfaces may have different signs.

    Here states that are given by equations count as free: that only finds more signs.
    """
    relations = solved_for(graph, mode.equations, surfaces, graph.states)
    if not relations:
        return True
    return may_attract([substituted(graph, rate, relations) for rate in rates])


def _hold(mode: SplitMode, key: SurfaceKey) -> Expression | None:
    declared = mode.declared.get(key)
    return None if declared is None else declared.hold


def _guards(
    graph: Graph, key: SurfaceKey, up: Expression, down: Expression, hold: Expression | None
) -> dict[tuple[SurfaceKey, int], Expression]:
    """Positive while u stays between -1 and 1, or as far as the surface holds."""
    if hold is None:
        return {(key, 1): graph.negate(up), (key, -1): down}
    # hold (L- - L+) -+ (L+ + L-), both sides of the inequalities times the width
    held = graph.multiply(hold, graph.add(down, graph.negate(up)))
    pull = graph.add(up, down)
    return {
        (key, 1): simplified(graph, graph.add(held, graph.negate(pull))),
        (key, -1): simplified(graph, graph.add(held, pull)),
    }


def cell_on(mode: SplitMode, corners: tuple[Cell, ...], on: tuple[SurfaceKey, ...]) -> Cell:
    """Cell on some surfaces, between its corners."""
    signs: Signs = {}
    for cell in corners:
        signs |= cell.signs
    signs = {key: signs[key] for key in mode.names if key in signs} | dict.fromkeys(on, 0)
    surfaces: dict[SurfaceKey, SwitchingSurface] = {}
    for cell in corners:
        surfaces |= {s.key: s for s in cell.surfaces if s.key not in on}
    return Cell(signs, tuple(surfaces.values()))


def between(
    graph: Graph, plus: Expression, minus: Expression, control: Expression, points: Points
) -> Expression:
    """What lies between two sides; one of them where they are the same on the surface."""
    step = simplified(graph, signed_sum(graph, (plus, minus), (1, -1)))
    if plus is minus or vanishes([step], points=points):
        return minus
    half = graph.number(0.5)
    mean = graph.multiply(half, simplified(graph, graph.add(plus, minus)))
    return graph.add(mean, graph.multiply(half, step, control))


# ---------------------------------------------------------------- states that follow from surfaces


def solved_for(
    graph: Graph,
    equations: ModeEquations,
    nodes: list[Expression],
    among: Collection[str] | None = None,
) -> dict[str, Expression]:
    """States that follow from functions that are zero; none where a function is not linear.

    Without them motion stays on the surfaces all the same, up to rounding: its rates see to that.
    ``among`` are the states that may follow; those that flow unless others are given.
    """
    among = equations.flow if among is None else among
    found: dict[str, Expression] = {}
    for node in nodes:
        try:
            form = graph.form(substituted(graph, node, found))
        except NotLinear:
            return {}
        pivot = _pivot(form, among)
        if pivot is None:
            return {}
        rest = LinearForm({b: c for b, c in form.terms.items() if b != pivot})
        solution = graph.from_form(rest.divided(negate(form.coefficient(pivot))))
        found = {s: substituted(graph, e, {pivot.name: solution}) for s, e in found.items()}
        found[pivot.name] = solution
    return found


def _pivot(form: LinearForm, among: Collection[str]) -> State | None:
    """State for which a form that is zero is solved; its factor vanishes for no values.

    A factor of parameters that all states share is none: where it vanishes there is no function.
    """
    factors = {b: c for b, c in form.terms.items() if isinstance(b, State) and c != ZERO}
    able = [basis for basis in factors if basis.name in among]
    sure = [basis for basis in able if isinstance(factors[basis], Number)]
    if sure:
        return sure[-1]
    return able[-1] if able and _proportional(list(factors.values())) else None


def _proportional(factors: list[Expression]) -> bool:
    """Whether expressions of parameters have the same ratios for all values."""
    rows = Points().of(factors)
    rows = rows[:, np.isfinite(rows).all(axis=0)]
    if not rows.shape[1] or not rows[0].all():
        return False
    ratios = rows[1:] / rows[0]
    return bool((np.abs(ratios - ratios[:, :1]) <= _SAME * np.abs(ratios[:, :1])).all())


def related(
    equations: ModeEquations, relations: Mapping[str, Expression], why: str
) -> ModeEquations:
    """Equations in which some states follow from others instead of flowing."""
    if not relations:
        return equations
    flow = {state: e for state, e in equations.flow.items() if state not in relations}
    added = {
        state: Equation(shown(node), f"modes[{equations.name!r}], {state} {why}", node)
        for state, node in relations.items()
    }
    return replace(equations, flow=flow, slaved={**equations.slaved, **added})
