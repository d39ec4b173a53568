"""A mode read as linear: forms of its equations, names resolved, slaved states solved for."""

from __future__ import annotations

from collections.abc import Mapping

from nonsmooth.errors import ModelError
from nonsmooth.system.equations import Equation
from nonsmooth.system.expressions import (
    ZERO,
    Call,
    Expression,
    Name,
    Number,
    divide,
    negate,
    walk,
    written_out,
)
from nonsmooth.system.graph import Graph
from nonsmooth.system.linear import Input, LinearForm, NotLinear, Power, State, linear_form
from nonsmooth.system.mode_equations import ModeEquations, is_relation

__all__ = ["LinearReader", "NonlinearText", "residual", "solve_slaved"]

_MOST_NODES = 250_000  # of slaved states that are solved together


class NonlinearText(Exception):
    """An equation is not linear; carries the reason, the node and the equation."""

    def __init__(self, reason: str, node: Expression, equation: Equation) -> None:
        super().__init__(reason)
        self.reason = reason
        self.node = node
        self.equation = equation

    @property
    def at(self) -> int:
        """Place of the node in the text of the equation; -1 where it came from elsewhere."""
        inside = any(self.node is part for part in walk(self.equation.tree))
        return self.node.at if inside else -1


class LinearReader:
    """Linear forms of the equations of one mode; `NonlinearText` where there is none."""

    def __init__(self, graph: Graph, equations: ModeEquations) -> None:
        self.graph = graph
        self.states = set(graph.states)
        self.equations = equations
        self._open: list[str] = []  # names being resolved, to see definitions that go in circles
        self._forms: dict[str, LinearForm] = {}
        self.slaved: Mapping[str, LinearForm] = {}
        self._solved = False

    def solve(self) -> None:
        """Find the forms of the slaved states; from then on they are replaced."""
        residuals = {
            state: residual(state, equation, self.form(equation))
            for state, equation in self.equations.slaved.items()
        }
        self.slaved = solve_slaved(self.equations.name, self.equations.slaved, residuals)
        self._solved = True
        self._forms.clear()  # what was read before the slaved states were known

    def form(self, equation: Equation) -> LinearForm:
        """Linear form of an equation."""
        depth = len(self._open)
        try:
            return linear_form(equation.tree, self.form_of).with_replaced(self.slaved)
        except NotLinear as fault:
            raise NonlinearText(fault.reason, fault.node, equation) from None
        finally:
            del self._open[depth:]

    def rate(self, state: str) -> LinearForm:
        """Linear form of the rate of change of a state; derived for a slaved one."""
        key = f"rate({state})"
        if key not in self._forms:
            self._enter(key)
            if state not in self.equations.slaved:
                self._forms[key] = self.form(self.equations.flow[state])
            elif self._solved:
                self._forms[key] = self.slaved[state].rate(self.rate)
            else:
                raise ModelError(
                    f"modes[{self.equations.name!r}].slaved: rate({state}) of a slaved state"
                    " cannot stand in a slaved equation"
                )
            self._open.pop()
        return self._forms[key]

    def form_of(self, node: Name | Call) -> LinearForm:
        """Linear form of a name, or of a rate."""
        signal = self.graph.signal_of(node)
        if signal is not None:
            return LinearForm.of(Input(*signal))
        if isinstance(node, Call):
            argument = node.arguments[0]
            assert isinstance(argument, Name)  # the grammar admits nothing else
            return self.rate(argument.name)
        name = node.name
        if name == "t":
            return LinearForm.of(Power(1))
        if name in self.states:
            return LinearForm.of(State(name))
        if name not in self.equations.definitions:
            return LinearForm.constant(Name(name))
        if name not in self._forms:
            self._enter(name)
            self._forms[name] = self.form(self.equations.definitions[name])
            self._open.pop()
        return self._forms[name]

    def _enter(self, name: str) -> None:
        if name in self._open:
            circle = " -> ".join([*self._open[self._open.index(name) :], name])
            raise ModelError(f"modes[{self.equations.name!r}]: {circle} goes in a circle; break it")
        self._open.append(name)


def residual(state: str, equation: Equation, form: LinearForm) -> LinearForm:
    """Form that vanishes: left - right of a relation, state - expression otherwise."""
    if is_relation(equation.text):
        return form
    return LinearForm.of(State(state)).plus(form.scaled(Number(-1.0)))


def solve_slaved(
    mode: str, equations: Mapping[str, Equation], residuals: Mapping[str, LinearForm]
) -> dict[str, LinearForm]:
    """Explicit forms of slaved states: their equations solved together.

    Gauss elimination on coefficients that are expressions of parameters; a pivot that
    vanishes for some values shows as a coefficient that is not finite.
    """
    solved: dict[str, LinearForm] = {}
    for state, given in residuals.items():
        open_ = given.with_replaced(solved)
        pivot = open_.coefficient(State(state))
        if pivot == ZERO:
            equation = equations[state]
            raise ModelError(f"{equation.where}: {state!r} does not appear in {equation.text!r}")
        others = {b: c for b, c in open_.terms.items() if b != State(state)}
        explicit = LinearForm({b: negate(divide(c, pivot)) for b, c in others.items()})
        solved = {k: form.with_replaced({state: explicit}) for k, form in solved.items()}
        solved[state] = explicit
        parts = (value for form in solved.values() for value in form.terms.values())
        if written_out(parts) > _MOST_NODES:
            raise ModelError(
                f"modes[{mode!r}].slaved: solved together, the equations of"
                f" {', '.join(list(solved)[:8])} have more than {_MOST_NODES:,} parts; write"
                " each slaved state by states that are not slaved"
            )
    return solved
