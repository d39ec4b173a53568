"""What the equations of one mode come to: linear forms, expressions for Taylor series, or both."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from nonsmooth.engine.tables import FREE, RESTING
from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.differentiate import derivative
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import LinearForm, NotLinear
from nonsmooth.system.algebra.quadratic import quadratic
from nonsmooth.system.cells.pieces import RELEASE, Piece
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.linear_mode import LinearReader, NonlinearText
from nonsmooth.system.equations.mode_equations import ExitEquations, ModeEquations
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.text.expressions import Expression, to_text
from nonsmooth.system.text.grammar import point_at

__all__ = ["ExitForms", "Forms", "ModeForms"]

T = TypeVar("T")
_SHOWN = 100  # letters of an equation up to which it is repeated


@dataclass(frozen=True, slots=True)
class ExitForms(Generic[T]):
    """Guard and reset of one exit and the index of the mode entered (-1 ends the run).

    ``products`` of two forms each belong to the guard of a linear mode, beside ``guard``.
    """

    name: str
    target: int
    guard: T
    reset: Mapping[str, T]
    products: Sequence[tuple[T, T]] = ()


@dataclass(frozen=True, slots=True)
class Forms(Generic[T]):
    """Rates, relations of slaved states and exits of a mode.

    ``implicit`` relations vanish for the slaved states that they hold for; these have rates too.
    """

    rates: Mapping[str, T]
    slaved: Mapping[str, T]
    exits: Sequence[ExitForms[T]]
    implicit: Mapping[str, T] = field(default_factory=dict)

    def with_place(self, mode: str) -> Iterator[tuple[str, T, str]]:
        """Every form, where it stands, and the state that a reset sets."""
        for state, form in self.rates.items():
            yield f"the rate of {state!r} in mode {mode!r}", form, ""
        for state, form in self.slaved.items():
            yield f"the slaved equation of {state!r} in mode {mode!r}", form, ""
        for state, form in self.implicit.items():
            yield f"the slaved equation of {state!r} in mode {mode!r}", form, ""
        for way in self.exits:
            for form in (way.guard, *(factor for pair in way.products for factor in pair)):
                yield f"the guard of {way.name!r} in mode {mode!r}", form, ""
            for state, form in way.reset.items():
                yield f"the reset of {state!r} by {way.name!r} in mode {mode!r}", form, state


class ModeForms:
    """One mode that runs: ``linear`` holds its forms, or ``taylor`` its expressions.

    A linear mode with a guard that is quadratic, or with a reset that is not linear, has both:
    its flow is that of ``linear``, its guards and resets at an instant are those of ``taylor``.
    ``nonlinear`` says what keeps a mode from being linear. A mode with piecewise
    texts runs as several, its cells: ``parent`` is the name of all of them, ``name``
    that of one, ``label`` what results call it, ``sides`` its surfaces with their signs.
    ``surfaces`` are the switching functions as texts.
    ``kind`` tells cells on a surface and modes at rest from others; ``declared`` is the mode whose
    texts these are. Exits from ``n_searched`` on lead ``onto`` the surfaces of others.
    """

    def __init__(
        self,
        graph: Graph,
        piece: Piece,
        numbers: Mapping[int, int],
        *,
        name: str,
        label: str,
    ) -> None:
        mode, cell = piece.family.split, piece.cell
        self.graph = graph
        self.name = name
        self.label = label
        self.family = piece.family.name
        self.parent = piece.family.name
        self.declared = piece.family.declared
        self.cell = cell
        self.kind = piece.kind
        self.sides = tuple(mode.surfaces_of(cell))
        self.surfaces = {surface: mode.text_of(surface) for surface in mode.nodes}
        self.equations = equations = piece.equations
        self.resolver = resolver = piece.resolver
        self.targets = tuple(
            -1 if target is None else numbers[id(target)] for target in piece.targets
        )
        self.onto = piece.onto
        self.choices = piece.choices
        self.n_searched = piece.n_searched
        self.resolved = resolver.resolved(equations.exits)
        self._as_written = not (resolver.met_piecewise or resolver.rates)
        # as written where nothing is piecewise, so that definitions stay whole
        read = equations if self._as_written else self.resolved
        self.reader = LinearReader(graph, read)
        self.linear: Forms[LinearForm] | None = None
        self.taylor: Forms[Expression] | None = None
        self.nonlinear: NonlinearText | None = None
        try:
            self.linear = self._linear(read)
        except NonlinearText as fault:
            self.nonlinear = fault
            self.reader = LinearReader(graph, read)
            exits = (e for way in read.exits for e in (way.guard, *way.reset.values()))
            self.linear = self._linear_flow() if any(e is fault.equation for e in exits) else None
            self.taylor = self._taylor()

    @property
    def rates(self) -> Mapping[str, LinearForm]:
        """Linear forms of the rates of all states; empty where the mode is not linear."""
        return self.linear.rates if self.linear else {}

    @property
    def slaved(self) -> Mapping[str, LinearForm]:
        """Linear forms of the slaved states; empty where the mode is not linear."""
        return self.linear.slaved if self.linear else {}

    @property
    def exit_names(self) -> tuple[str, ...]:
        """Names of the exits in the order in which they are tried."""
        return tuple(way.name for way in self.equations.exits)

    def exit_in_words(self, number: int) -> str:
        """An exit by its name and what the user has written for it; of sliding and rest in words.

        The guards that end sliding and rest are derived, and nobody would know them again.
        """
        way = self.equations.exits[number]
        if number < 2 * len(self.cell.on):
            return f"the limit of what the surface {way.name!r} holds"
        if self.is_surface(number):
            return f"the surface {way.name!r} ({self.surfaces[way.name]} = 0)"
        if way.guard.where.endswith(f", {RELEASE}"):
            return "the limit at which nothing presses any more"
        return f"{way.name!r} ({way.guard.text} = 0)"

    def is_surface(self, number: int) -> bool:
        """Whether an exit leads through a surface of a piecewise text, and is none of the mode."""
        way = self.equations.exits[number]
        return way.name in self.surfaces and not way.guard.where.endswith(".guard")

    @property
    def all_forms(self) -> list[LinearForm]:
        """Every linear form of the mode."""
        if self.linear is None:
            return []
        forms = [*self.linear.slaved.values(), *self.linear.rates.values()]
        for way in self.linear.exits:
            forms += [way.guard, *way.reset.values()]
            forms += [factor for pair in way.products for factor in pair]
        return forms

    @property
    def constant_guards(self) -> list[Expression | None]:
        """Guards that depend on parameters only; None for the others."""
        if self.linear is not None and self.taylor is None:
            guards = [way.guard for way in self.linear.exits]
            return [guard.constant_part if guard.is_constant else None for guard in guards]
        assert self.taylor is not None
        nodes = [way.guard for way in self.taylor.exits]
        return [None if self.graph.moves(node) else node for node in nodes]

    def depends(self, node: Expression, drifting: str, own: str) -> bool:
        """Whether an expression of a mode depends on a state that drifts.

        The reset of the drifting state itself may move it, by what does not depend on it.
        """
        assert self.taylor is not None
        relations = self.taylor.slaved

        def partial(state: str) -> Expression:
            if state in relations:
                return derivative(self.graph, relations[state], partial)
            return self.graph.one if state == drifting else self.graph.zero

        if own == drifting:
            return derivative(self.graph, node, partial) is not self.graph.one
        found = self.graph.states_in(node)
        while (
            more := {
                state
                for slaved in found & set(relations)
                for state in self.graph.states_in(relations[slaved])
            }
            - found
        ):
            found |= more
        return drifting in found

    def form(self, equation: Equation) -> LinearForm:
        """Linear form of what should depend on parameters only; the error points at the rest."""
        try:
            return self.reader.form(equation)
        except NonlinearText as fault:
            message = f"{equation.where}: states and time cannot appear here, only parameters"
            raise ModelError(point_at(equation.text, fault.at, message)) from None

    def value_of(self, name: str) -> LinearForm | Expression:
        """What an output or a definition is in this mode: a linear form where there is one.

        Piecewise calls that do not decide on the cell stay in the expression.
        """
        equation = self.equations.definitions[name]
        if self.taylor is None and self._as_written:
            try:
                return self.reader.form(equation)
            except NonlinearText:
                pass
        return self._readable.tree(equation)

    @property
    def reason(self) -> str:
        """What makes the mode nonlinear, in words; empty for a linear one.

        A cell reads piecewise texts in a form that nobody has written, so the equation is told
        there as it was written.
        """
        if self.nonlinear is None:
            return ""
        reason, equation = self.nonlinear.reason, self.nonlinear.equation
        if self._as_written:
            return f"{reason}: {to_text(self.nonlinear.node)}"
        if self.kind != FREE:
            place = "where the exit sticks" if self.kind == RESTING else "along the surface"
            return f"{reason}, in the equations of the motion {place}"
        written = f" = {equation.text!r}" if len(equation.text) <= _SHOWN else ""
        return f"{reason}, in {equation.where}{written}"

    @property
    def _readable(self) -> Resolver:
        return self.resolver.lenient()

    def _linear(self, read: ModeEquations) -> Forms[LinearForm]:
        reader = self.reader
        reader.solve()
        rates = {state: reader.rate(state) for state in self.graph.states}
        return Forms(rates, reader.slaved, self._exits(read, reader.form))

    def _linear_flow(self) -> Forms[LinearForm] | None:
        """Forms of a mode whose flow is linear while an exit is not; None where there is more."""
        read = self.resolved
        reader = LinearReader(self.graph, read)
        try:
            reader.solve()
            rates = {state: reader.rate(state) for state in self.graph.states}
            exits = [
                _curved_exit(reader, way, target)
                for way, target in zip(read.exits, self.targets, strict=True)
            ]
        except (NonlinearText, NotLinear):
            return None
        return Forms(rates, reader.slaved, exits)

    def _taylor(self) -> Forms[Expression]:
        read, relations = self.resolved, self.resolver.relations
        rates = {state: equation.tree for state, equation in read.flow.items()}
        rates |= {state: self.resolver.rate(state) for state in relations.implicit}
        exits = self._exits(read, lambda equation: equation.tree)
        return Forms(rates, relations.explicit, exits, relations.implicit)

    def _exits(self, read: ModeEquations, form: Callable[[Equation], T]) -> list[ExitForms[T]]:
        return [
            ExitForms(way.name, target, form(way.guard), {s: form(e) for s, e in way.reset.items()})
            for way, target in zip(read.exits, self.targets, strict=True)
        ]


def _curved_exit(reader: LinearReader, way: ExitEquations, target: int) -> ExitForms[LinearForm]:
    """An exit of a linear flow: a guard quadratic at most; resets that are not linear left out."""
    guard = quadratic(way.guard.tree, reader.form_of)
    products = [
        (left.with_replaced(reader.slaved), right.with_replaced(reader.slaved))
        for left, right in guard.products
    ]
    resets = {}
    for state, equation in way.reset.items():
        try:
            resets[state] = reader.form(equation)
        except NonlinearText:
            continue
    return ExitForms(way.name, target, guard.linear.with_replaced(reader.slaved), resets, products)
