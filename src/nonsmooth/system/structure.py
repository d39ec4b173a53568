"""What the texts of a system mean, before any parameter has a value.

A `Structure` holds the parsed trees and, for each mode, the linear forms of flows,
guards, resets and slaved relations. It does not depend on parameter values, so all
systems made by ``with_parameters`` share one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.equations import Equation, check_references
from nonsmooth.system.expressions import (
    ZERO,
    Call,
    Expression,
    Name,
    Number,
    divide,
    negate,
    subtract,
    walk,
    written_out,
)
from nonsmooth.system.functions import lookup
from nonsmooth.system.grammar import point_at
from nonsmooth.system.linear import (
    Harmonic,
    LinearForm,
    NotLinear,
    Power,
    State,
    linear_form,
)
from nonsmooth.system.parts import STOP, Exit, Mode, Text

if TYPE_CHECKING:
    from nonsmooth.system.system import System

# an equals sign that is not part of a comparison
_EQUALS = re.compile(r"(?<![<>=])=(?!=)")

_MOST_NODES = 250_000  # of slaved states that are solved together

__all__ = ["ExitForms", "ModeForms", "Structure", "is_relation"]


@dataclass(frozen=True, slots=True)
class ExitForms:
    """Linear forms of one exit and the index of the mode entered (-1 ends the run)."""

    name: str
    target: int
    guard: LinearForm
    reset: dict[str, LinearForm]


class Structure:
    """Parsed texts of a system and the linear forms of its modes."""

    def __init__(self, system: System) -> None:
        self.states = system.states
        self.parameters = tuple(system.parameters)
        self.mode_names = tuple(system.modes)
        self.drift = tuple(system.drift)
        names = {*self.states, *self.parameters, "t", "pi"}
        known = names | set(system.definitions)
        self.definitions = {
            key: Equation.read(text, f"definitions[{key!r}]", known)
            for key, text in system.definitions.items()
        }
        known_to_outputs = known | set(system.outputs)
        self.outputs = {
            key: Equation.read(text, f"outputs[{key!r}]", known_to_outputs)
            for key, text in system.outputs.items()
        }
        self.initial = {
            key: Equation.read(text, f"initial[{key!r}]", known)
            for key, text in system.initial.items()
        }
        self.period = (
            None if system.period is None else Equation.read(system.period, "period", known)
        )
        self.modes = {
            name: ModeForms(self, name, mode, known) for name, mode in system.modes.items()
        }

    @cached_property
    def frequencies(self) -> tuple[Expression, ...]:
        """Angular frequencies of all harmonics, in order of appearance."""
        found: dict[Expression, None] = {}
        for form in self.all_forms:
            for basis in form.terms:
                if isinstance(basis, Harmonic):
                    found.setdefault(basis.frequency)
        return tuple(found)

    @cached_property
    def time_order(self) -> int:
        """Highest power of time in any form."""
        orders = [b.order for form in self.all_forms for b in form.terms if isinstance(b, Power)]
        return max(orders, default=0)

    @cached_property
    def all_forms(self) -> tuple[LinearForm, ...]:
        """Every linear form of every mode."""
        return tuple(form for mode in self.modes.values() for form in mode.all_forms)

    @property
    def static_form(self) -> ModeForms:
        """Names resolved where no mode matters: parameters and their definitions."""
        return next(iter(self.modes.values()))


class ModeForms:
    """Names resolved and equations recognised within one mode."""

    def __init__(self, structure: Structure, name: str, mode: Mode, known: set[str]) -> None:
        self.structure = structure
        self.name = name
        place = f"modes[{name!r}]"
        self.definitions: Mapping[str, Equation] = structure.definitions | {
            key: Equation.read(text, f"{place}.definitions[{key!r}]", known)
            for key, text in mode.definitions.items()
        }
        check_references({**self.definitions, **structure.outputs}, structure.states)
        self.flow_equations = {
            key: Equation.read(text, f"{place}.flow[{key!r}]", known)
            for key, text in mode.flow.items()
        }
        self.slaved_equations = {
            key: _relation(text, f"{place}.slaved[{key!r}]", known)
            for key, text in mode.slaved.items()
        }
        self._open: list[str] = []  # names being resolved, to see definitions that go in circles
        self._forms: dict[str, LinearForm] = {}
        self.slaved: dict[str, LinearForm] = {}
        self.slaved = self._solve_slaved()
        self._forms.clear()  # what was read before the slaved states were known
        self.rates = {state: self.rate(state) for state in structure.states}
        self.exits = [
            self._exit(way, f"{place}.exits[{position}]", known)
            for position, way in enumerate(mode.exits)
        ]

    @property
    def all_forms(self) -> list[LinearForm]:
        """Every linear form of the mode."""
        forms = [*self.slaved.values(), *self.rates.values()]
        for way in self.exits:
            forms += [way.guard, *way.reset.values()]
        return forms

    def form(self, equation: Equation) -> LinearForm:
        """Linear form of an equation; an error that points at what is not linear."""
        try:
            return linear_form(equation.tree, self._form_of).with_replaced(self.slaved)
        except NotLinear as fault:
            message = f"{equation.where} in mode {self.name!r}: {fault.reason}; {_cure(fault.node)}"
            place = _place(fault.node, equation)
            raise ModelError(point_at(equation.text, place, message)) from None

    def rate(self, state: str) -> LinearForm:
        """Linear form of the rate of change of a state; derived for a slaved one."""
        key = f"rate({state})"
        if key not in self._forms:
            self._enter(key)
            if state not in self.slaved_equations:
                self._forms[key] = self.form(self.flow_equations[state])
            elif state in self.slaved:
                self._forms[key] = self.slaved[state].rate(self.rate)
            else:
                raise ModelError(
                    f"modes[{self.name!r}].slaved: rate({state}) of a slaved state cannot stand"
                    " in a slaved equation"
                )
            self._open.pop()
        return self._forms[key]

    def _form_of(self, node: Name | Call) -> LinearForm:
        if isinstance(node, Call):
            return self.rate(self._state_of(node))
        name = node.name
        if name == "t":
            return LinearForm.of(Power(1))
        if name == "pi" or name in self.structure.parameters:
            return LinearForm.constant(Name(name))
        if name in self.structure.states:
            return LinearForm.of(State(name))
        if name not in self._forms:
            self._enter(name)
            self._forms[name] = self.form(self.definitions[name])
            self._open.pop()
        return self._forms[name]

    def _state_of(self, node: Call) -> str:
        argument = node.arguments[0]
        assert isinstance(argument, Name)  # the grammar admits nothing else
        if argument.name not in self.structure.states:
            raise ModelError(unknown_name("state in rate()", argument.name, self.structure.states))
        return argument.name

    def _enter(self, name: str) -> None:
        if name in self._open:
            circle = " -> ".join([*self._open[self._open.index(name) :], name])
            raise ModelError(f"modes[{self.name!r}]: {circle} goes in a circle; break it")
        self._open.append(name)

    def _solve_slaved(self) -> dict[str, LinearForm]:
        """Explicit forms of the slaved states: their equations solved together.

        Gauss elimination on coefficients that are expressions of parameters; a pivot that
        vanishes for some values shows as a coefficient that is not finite.
        """
        residuals = {
            state: self._residual(state, equation)
            for state, equation in self.slaved_equations.items()
        }
        solved: dict[str, LinearForm] = {}
        for state, equation in self.slaved_equations.items():
            residual = residuals[state].with_replaced(solved)
            pivot = residual.coefficient(State(state))
            if pivot == ZERO:
                raise ModelError(
                    f"{equation.where}: {state!r} does not appear in {equation.text!r}"
                )
            others = {b: c for b, c in residual.terms.items() if b != State(state)}
            explicit = LinearForm({b: negate(divide(c, pivot)) for b, c in others.items()})
            solved = {k: form.with_replaced({state: explicit}) for k, form in solved.items()}
            solved[state] = explicit
            parts = (value for form in solved.values() for value in form.terms.values())
            if written_out(parts) > _MOST_NODES:
                raise ModelError(
                    f"modes[{self.name!r}].slaved: solved together, the equations of"
                    f" {', '.join(list(solved)[:8])} have more than {_MOST_NODES:,} parts; write"
                    " each slaved state by states that are not slaved"
                )
        return solved

    def _residual(self, state: str, equation: Equation) -> LinearForm:
        """Form that vanishes: left - right of a relation, state - expression otherwise."""
        form = self.form(equation)
        if is_relation(equation.text):
            return form
        return LinearForm.of(State(state)).plus(form.scaled(Number(-1.0)))

    def _exit(self, way: Exit, place: str, known: set[str]) -> ExitForms:
        names = self.structure.mode_names
        target = way.to or self.name
        if target != STOP and target not in names:
            raise ModelError(f"{place}.to: {unknown_name('mode', target, (*names, STOP))}")
        for state in way.reset:
            if state not in self.structure.states:
                raise ModelError(
                    f"{place}.reset: {unknown_name('state', state, self.structure.states)}"
                )
        guard = self.form(Equation.read(way.guard, f"{place}.guard", known))
        if target == self.name and not way.reset:
            raise ModelError(
                f"{place}: the exit leads back to its own mode {target!r} without a reset, so its"
                " guard stays negative; add reset=, or another mode in to="
            )
        return ExitForms(
            name=way.name or target,
            target=-1 if target == STOP else names.index(target),
            guard=guard,
            reset={
                state: self.form(Equation.read(text, f"{place}.reset[{state!r}]", known))
                for state, text in way.reset.items()
            },
        )


def is_relation(text: Text) -> bool:
    """Whether a slaved equation is ``left = right`` instead of an expression."""
    return isinstance(text, str) and bool(_EQUALS.search(text))


def _relation(text: Text, where: str, known: set[str]) -> Equation:
    """Equation of a slaved state; ``left = right`` is read as ``left - right``."""
    if not is_relation(text):
        return Equation.read(text, where, known)
    sides = _EQUALS.split(str(text))
    if len(sides) != 2 or not all(side.strip() for side in sides):
        raise ModelError(
            f"{where}: a relation has one '=' between two expressions, not {text!r:.80}"
        )
    left = Equation.read(sides[0], where, known).tree
    # blanks in place of the left side keep the caret of a message in its column
    right = Equation.read(" " * (len(sides[0]) + 1) + sides[1], where, known).tree
    return Equation(str(text), where, subtract(left, right))


def _cure(node: Expression) -> str:
    piecewise = any(
        isinstance(n, Call) and n.function != "rate" and not lookup(n.function).smooth
        for n in walk(node)
    )
    if piecewise:
        return (
            "piecewise texts are not split into cells in this version:"
            " write one mode per smooth piece"
        )
    return (
        "this version runs modes that are linear in the states, with harmonics cos(w*t + p) and"
        " powers of t; a decaying input can be written as a state of its own"
    )


def _place(node: Expression, equation: Equation) -> int:
    """Position of a node in the text of an equation, unless it came from elsewhere."""
    return node.at if any(node is part for part in walk(equation.tree)) else -1
