"""A mode read as linear: forms of its equations, names resolved, slaved states solved for."""

from __future__ import annotations

from collections.abc import Mapping

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import Input, LinearForm, NotLinear, Power, State, linear_form
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ModeEquations
from nonsmooth.system.equations.slaved import residual, solve_slaved
from nonsmooth.system.text.expressions import (
    Call,
    Expression,
    Name,
    walk,
)

__all__ = ["LinearReader", "NonlinearText"]


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
        # of parts of trees, which equations share: a table of a bearing stands in each of them
        self._parts: dict[int, LinearForm | NotLinear] = {}
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
        self._parts.clear()

    def form(self, equation: Equation) -> LinearForm:
        """Linear form of an equation."""
        depth = len(self._open)
        try:
            return linear_form(equation.tree, self.form_of, self._parts).with_replaced(self.slaved)
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
