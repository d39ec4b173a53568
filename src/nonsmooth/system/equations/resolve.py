"""Names of one mode to what they stand for: equations become nodes of a graph.

Definitions, outputs and rates are put in; piecewise calls of states or time are replaced by
the side on which their switching function lies, as far as its sign is given.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.differentiate import rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import substituted, vanishes
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.equations.slaved import Relations, implicit_rates, read_relations
from nonsmooth.system.equations.switching import SurfaceKey, Switch, Undecided, switching_function
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import Call, Expression, Name, Number, names_in
from nonsmooth.system.text.functions import lookup

__all__ = ["Resolver", "calls_of_motion"]

_Lazy = Callable[[], Expression]
_LINEAR = ("+", "neg")  # in what jumps


class Resolver:
    """Nodes of the equations of one mode.

    ``signs`` says on which side of its surfaces the mode lies. A surface without a sign
    raises `Undecided`, or its call is kept where the resolver is not ``strict``. On a surface,
    sign 0, calls that jump there take what lies between their sides by ``controls``: the
    equivalent value of the sign, from -1 to 1. ``rates`` are known beforehand, whatever the
    texts of the flow say; ``on_surface`` are states that follow from the surface, and ``motion``
    the calls that stand in the equations of motion beside it, see `calls_of_motion`.
    """

    def __init__(
        self,
        graph: Graph,
        equations: ModeEquations,
        signs: Mapping[SurfaceKey, int],
        *,
        strict: bool = True,
        controls: Mapping[SurfaceKey, Expression] | None = None,
        rates: Mapping[str, Expression] | None = None,
        on_surface: Mapping[str, Expression] | None = None,
        motion: frozenset[Expression] = frozenset(),
    ) -> None:
        self.graph = graph
        self.equations = equations
        self.signs = signs
        self.strict = strict
        self.controls = controls or {}
        self.rates = rates or {}
        self.on_surface = on_surface or {}
        self.motion = motion
        self.met_piecewise = False
        self._known: dict[int, tuple[Expression, Expression]] = {}  # parts of texts, and nodes
        self._named: dict[str, Expression] = {}
        self._open: list[str] = []
        self._relations: Relations | None = None
        self._implicit_rates: dict[str, Expression] | None = None

    def tree(self, equation: Equation) -> Expression:
        """Node of an equation."""
        return self._tree(equation.tree)

    @cached_property
    def _beside(self) -> tuple[Resolver, Resolver]:
        """The same on both sides of the first surface on which the mode lies."""
        first, *others = self.controls
        above, below = (
            Resolver(
                self.graph,
                self.equations,
                {**self.signs, first: sign},
                strict=self.strict,
                controls={key: self.controls[key] for key in others},
                rates=self.rates,
                on_surface=self.on_surface,
                motion=self.motion,
            )
            for sign in (1, -1)
        )
        return above, below

    def resolved(self, exits: tuple[ExitEquations, ...] | None = None) -> ModeEquations:
        """Equations of the mode with nodes for trees, with its own exits or with others."""
        flow = {
            state: replace(e, tree=self.rate(state)) for state, e in self.equations.flow.items()
        }
        exits = self.equations.exits if exits is None else exits
        return replace(
            replace(self.equations, flow={}, exits=exits).with_trees(self.tree), flow=flow
        )

    def lenient(self) -> Resolver:
        """The same for reading: calls of surfaces without a sign are kept."""
        return Resolver(
            self.graph,
            self.equations,
            self.signs,
            strict=False,
            controls=self.controls,
            rates=self.rates,
            on_surface=self.on_surface,
            motion=self.motion,
        )

    def rate(self, state: str) -> Expression:
        """Node of the rate of change of a state; derived for a slaved one."""
        return self._by_name(f"rate({state})", lambda: self._rate(state))

    @property
    def relations(self) -> Relations:
        """Slaved states by their equations."""
        if self._relations is None:
            trees = {
                state: self._by_name(f"relation of {state}", partial(self.tree, equation))
                for state, equation in self.equations.slaved.items()
            }
            self._relations = read_relations(self.graph, self.equations, trees)
        return self._relations

    def _rate(self, state: str) -> Expression:
        if state in self.rates:
            return self.rates[state]
        if state in self.equations.flow:
            return self.tree(self.equations.flow[state])
        if any(name.startswith("relation of ") for name in self._open):
            raise ModelError(
                f"modes[{self.equations.name!r}].slaved: rate({state}) of a slaved state cannot"
                " stand in a slaved equation"
            )
        relations = self.relations
        if state in relations.explicit:
            return rate_of_change(self.graph, relations.explicit[state], self.rate)
        if self._implicit_rates is None:
            self._implicit_rates = implicit_rates(self.graph, self.equations, relations, self.rate)
        return self._implicit_rates[state]

    def _by_name(self, name: str, make: _Lazy) -> Expression:
        if name not in self._named:
            if name in self._open:
                circle = " -> ".join([*self._open[self._open.index(name) :], name])
                raise ModelError(
                    f"modes[{self.equations.name!r}]: {circle} goes in a circle; break it"
                )
            self._open.append(name)
            try:
                self._named[name] = make()
            finally:
                self._open.pop()
        return self._named[name]

    def _tree(self, node: Expression) -> Expression:
        if isinstance(node, Number):
            return self.graph.number(node.value)
        known = self._known.get(id(node))
        if known is None:  # the part is kept beside its node, so that its number stays its own
            known = self._known[id(node)] = node, self._between_sides(node)
        return known[1]

    def _between_sides(self, node: Name | Call) -> Expression:
        """What a part of a text means on the surfaces.

        Motion on a surface chatters between both sides, as a limit, and its rates are the mean over
        these. So is whatever part of them jumps, as a force. That is what the part is for the
        equivalent value of a sign that stands in it linearly; not within a ``clip``, or a square.
        Other texts are functions of these parts, and no means: what holds a mass has a size.
        """
        if not self.controls:
            return self._resolved(node)
        if node not in self.motion:
            try:
                return self._resolved(node)
            except Undecided:  # only what lies between the sides is known
                pass
        above, below = (side._tree(node) for side in self._beside)
        if above is below:
            return above
        mean = self._mean(above, below, next(iter(self.controls.values())))
        try:
            own = self._resolved(node)
        except Undecided:  # the equivalent value lies on no known side of another surface
            return mean
        apart = self.graph.add(own, self.graph.negate(mean))
        if vanishes([substituted(self.graph, apart, self.on_surface)]):
            return own
        return mean

    def _resolved(self, node: Name | Call) -> Expression:
        if isinstance(node, Name):
            equation = self.equations.definitions.get(node.name)
            if equation is None:
                return self.graph.name(node.name)
            return self._by_name(node.name, lambda: self.tree(equation))
        if node.function == "rate":
            signal = self.graph.signal_of(node)
            if signal is not None:
                return self.graph.signal(*signal)
            (state,) = node.arguments
            assert isinstance(state, Name)  # the grammar admits nothing else
            return self.rate(state.name)
        if node.function == "where":
            return self._where(node)
        arguments = [self._tree(argument) for argument in node.arguments]
        if node.function == "atan2" and any(map(self.graph.moves, arguments)):
            return self._angle(*arguments)
        if lookup(node.function).smooth or not any(map(self.graph.moves, arguments)):
            return self.graph.call(node.function, *arguments)
        return self._piecewise(node.function, arguments)

    # ------------------------------------------------------------ piecewise calls

    def _where(self, node: Call) -> Expression:
        graph = self.graph
        condition, yes, no = node.arguments
        assert isinstance(condition, Call)  # the grammar admits nothing else
        left, right = (self._tree(side) for side in condition.arguments)
        comparison = condition.function

        def decided(left: Expression, right: Expression) -> Expression:
            condition = graph.call(comparison, left, right)
            return self._selected(condition, lambda: self._tree(yes), lambda: self._tree(no))

        if not graph.moves(left) and not graph.moves(right):
            return decided(left, right)
        sides = (yes, no) if comparison in (">", ">=") else (no, yes)
        return self._switched(
            _difference(graph, left, right),
            lambda: self._tree(sides[0]),
            lambda: self._tree(sides[1]),
            constant=lambda difference: decided(difference, graph.zero),
            kept=lambda: graph.call(
                "where", graph.call(comparison, left, right), self._tree(yes), self._tree(no)
            ),
        )

    def _piecewise(self, function: str, arguments: list[Expression]) -> Expression:
        graph, u = self.graph, arguments[0]
        if function == "clip":
            raised = self._greater("max", u, arguments[1])
            return self._greater("min", raised, arguments[2])
        if function in ("min", "max"):
            for other in arguments[1:]:
                u = self._greater(function, u, other)
            return u
        above, below = {
            "abs": (u, graph.negate(u)),
            "sign": (graph.one, graph.number(-1.0)),
            "heaviside": (graph.one, graph.zero),
        }[function]
        return self._switched(
            u,
            lambda: above,
            lambda: below,
            constant=lambda value: graph.call(function, value),
            kept=lambda: graph.call(function, u),
            jumps=function != "abs",
        )

    def _angle(self, y: Expression, x: Expression) -> Expression:
        """``atan2``, which jumps behind the origin: upper and lower half-plane, each smooth."""
        graph = self.graph
        quarter = graph.number(0.5 * math.pi)
        whole = graph.call("atan2", y, x)
        return self._switched(
            y,
            lambda: graph.add(quarter, graph.call("atan2", graph.negate(x), y)),
            lambda: graph.add(graph.negate(quarter), graph.call("atan2", x, graph.negate(y))),
            constant=lambda _: whole,
            kept=lambda: whole,
        )

    def _greater(self, function: str, u: Expression, other: Expression) -> Expression:
        """``max`` or ``min`` of two."""
        graph = self.graph
        if not graph.moves(u) and not graph.moves(other):
            return graph.call(function, u, other)
        above, below = (u, other) if function == "max" else (other, u)
        return self._switched(
            _difference(graph, u, other),
            lambda: above,
            lambda: below,
            constant=lambda value: self._selected(
                graph.call(">=", value, graph.zero), lambda: above, lambda: below
            ),
            kept=lambda: graph.call(function, u, other),
            jumps=False,
        )

    def _switched(
        self,
        u: Expression,
        above: _Lazy,
        below: _Lazy,
        *,
        constant: Callable[[Expression], Expression],
        kept: _Lazy,
        jumps: bool = True,
    ) -> Expression:
        """One side of a switching function, by its sign; ``constant`` where it has but one."""
        self.met_piecewise = True
        switch = switching_function(self.graph, u)
        if switch.surface is None:
            return constant(switch.constant)
        side = self.signs.get(switch.surface.key)
        if side is None:
            if self.strict:
                raise Undecided(switch.surface)
            return kept()
        if side == 0:
            return self._between(above(), below(), switch, jumps)
        return above() if side * switch.sign > 0.0 else below()

    def _between(
        self, above: Expression, below: Expression, switch: Switch, jumps: bool
    ) -> Expression:
        """What a call is on its surface: by the equivalent control, where its sides differ."""
        graph = self.graph
        if not jumps or above is below or switch.surface is None:
            return above if graph.moves(below) else below
        control = self.controls[switch.surface.key]
        if switch.sign < 0.0:
            control = graph.negate(control)
        numbers = [side.value for side in (above, below) if isinstance(side, Number)]
        if len(numbers) == 2:
            mean, step = 0.5 * (numbers[0] + numbers[1]), 0.5 * (numbers[0] - numbers[1])
            return graph.add(graph.number(mean), graph.multiply(graph.number(step), control))
        return self._mean(above, below, control)

    def _mean(self, above: Expression, below: Expression, control: Expression) -> Expression:
        graph, half = self.graph, self.graph.number(0.5)
        mean = graph.multiply(half, graph.add(above, below))
        step = graph.multiply(half, graph.add(above, graph.negate(below)))
        return graph.add(mean, graph.multiply(step, control))

    def _selected(self, condition: Expression, yes: _Lazy, no: _Lazy) -> Expression:
        """Selection by a condition on parameters: the two sides weighted by one and zero."""
        graph = self.graph
        if not names_in(condition):
            return yes() if constant_value(condition, {}) else no()
        above, below = yes(), no()
        if not self.strict or not (graph.moves(above) or graph.moves(below)):
            return graph.call("where", condition, above, below)
        return graph.add(
            graph.multiply(graph.call("where", condition, graph.one, graph.zero), above),
            graph.multiply(graph.call("where", condition, graph.zero, graph.one), below),
        )


def calls_of_motion(equations: ModeEquations) -> frozenset[Expression]:
    """Calls that stand in the equations of motion of a mode, in those of definitions too.

    Sums are left out: they are means where their parts are.
    """
    found: set[Expression] = set()
    seen: set[int] = set()  # parts that are shared are met once
    open_yet = [
        equation.tree for equation in (*equations.flow.values(), *equations.slaved.values())
    ]
    while open_yet:
        part = open_yet.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, Call):
            if part.function not in _LINEAR:
                found.add(part)
            open_yet.extend(part.arguments)
        elif isinstance(part, Name) and part.name in equations.definitions:
            open_yet.append(equations.definitions[part.name].tree)
    return frozenset(found)


def _difference(graph: Graph, left: Expression, right: Expression) -> Expression:
    return graph.add(left, graph.negate(right))
