"""A system's data with what follows from them: structure, arrays of the engine, numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.linear import LinearForm, Power
from nonsmooth.system.compile.dependence import where_it_stands
from nonsmooth.system.compile.program import Compiled, compile_structure
from nonsmooth.system.compile.structure import SystemStructure, structure_of
from nonsmooth.system.data import SystemData
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.parts import Text
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import Expression, names_in, to_text
from nonsmooth.system.text.grammar import parse

__all__ = ["EvaluatedSystem", "not_finite", "parameter_values", "static_value"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class EvaluatedSystem(SystemData):
    """The data of a system and what follows from them for the present parameter values."""

    @cached_property
    def parameter_values(self) -> dict[str, float]:
        """Values of the parameters as numbers."""
        return parameter_values(self.parameters)

    @cached_property
    def structure(self) -> SystemStructure:
        """What the texts mean; shared by systems that differ in parameter values only."""
        return structure_of(self)

    @cached_property
    def compiled(self) -> Compiled:
        """Arrays for the engine; independent of parameter values, shared like `structure`."""
        return compile_structure(self.structure)

    @cached_property
    def rest_state(self) -> dict[str, float]:
        """Documented rest state with every state in it."""
        state = dict.fromkeys(self.states, 0.0)
        for name, equation in self.structure.initial.items():
            form = self.structure.static_form.form(equation)
            state[name] = static_value(form, self.parameter_values, equation.where)
        return state

    @cached_property
    def open_state(self) -> dict[str, float]:
        """Rest state with nan for states that a mode may give by its equations instead.

        What a start leaves out takes the rest value, or stands as the mode that it begins in
        wants it.
        """
        slaved = {state for mode in self.modes.values() for state in mode.slaved}
        return {
            state: math.nan if state in slaved else value
            for state, value in self.rest_state.items()
        }

    @cached_property
    def period_value(self) -> float | None:
        """Period of the forcing for the present parameters, or None."""
        equation = self.structure.period
        if equation is None:
            return None
        form = self.structure.static_form.form(equation)
        value = static_value(form, self.parameter_values, "period")
        if not (value > 0.0 and math.isfinite(value)):
            raise ModelError(
                f"period: {equation.text!r} is {value}; it must be positive and finite"
            )
        return value

    @cached_property
    def unrepeated(self) -> str:
        """What in the equations does not repeat after any time, in words; empty without it."""
        structure = self.structure
        for name in self.signals:
            return f"the signal {name!r}"
        for name, forms in structure.modes.items():
            grows = structure.codes[name].grows if name in structure.codes else ""
            if forms.linear is not None:
                for where, form, _ in forms.linear.with_place(name):
                    if any(isinstance(basis, Power) and basis.order > 0 for basis in form.terms):
                        grows = where
            if grows:
                return f"t by itself in {grows}"
        return ""

    @property
    def is_driven(self) -> bool:
        """Whether time stands in the equations: as harmonics, as powers, or as signals."""
        structure = self.structure
        return bool(structure.frequencies or structure.time_order or self.signals)

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes that run, in order: piecewise ones by their cells."""
        return tuple(forms.label for forms in self.structure.running)

    @property
    def drift_states(self) -> tuple[str, ...]:
        """Names of the states on which nothing depends: those in ``drift`` but for `angles`."""
        return tuple(name for name in self.drift if name not in self.angles)

    @cached_property
    def forms_of_angles(self) -> dict[str, LinearForm]:
        """What the texts of the periods of angles in ``drift`` mean."""
        if not isinstance(self.drift, Mapping):
            return {}
        known = {*self.parameters, *self.definitions, "pi"}
        read = self.structure.static_form.form
        return {
            name: read(Equation.read(text, f"drift[{name!r}]", known))
            for name, text in self.drift.items()
        }

    @cached_property
    def periods_of_angles(self) -> dict[str, float]:
        """Periods of all angles in ``drift`` for the present parameters."""
        return {
            name: static_value(form, self.parameter_values, f"drift[{name!r}]")
            for name, form in self.forms_of_angles.items()
        }

    @cached_property
    def angles(self) -> dict[str, float]:
        """Periods of the angles on which something depends: a motion repeats up to these."""
        return {
            name: value
            for name, value in self.periods_of_angles.items()
            if where_it_stands(self.structure, name)
        }


def parameter_values(parameters: Mapping[str, Text]) -> dict[str, float]:
    """Numbers of the parameters; a text is a constant expression."""
    values = {}
    for name, given in parameters.items():
        tree = parse(given, where=f"parameters[{name!r}]")
        unknown = [n.name for n in names_in(tree) if n.name != "pi"]
        if unknown:
            raise ModelError(
                f"parameters[{name!r}] = {given!r} uses {unknown[0]!r}; a value is a number or"
                " a constant expression. Put expressions of parameters into definitions"
            )
        value = constant_value(tree, {})
        if not math.isfinite(value):
            raise ModelError(f"parameters[{name!r}] = {given!r} is not a finite number")
        values[name] = value
    return values


def not_finite(where: str, coefficient: Expression, value: float) -> str:
    """Say that a coefficient is infinite or not defined, and why."""
    text, value = to_text(coefficient), float(value)
    if text == str(value):  # such as 1e999
        return f"{where}: a coefficient is {value}; numbers go up to about 1.8e308"
    if names_in(coefficient):
        return (
            f"{where}: {text} is {value} for the parameters given; change them, or forbid such"
            " values in require="
        )
    return f"{where}: {text} is {value}; write a finite number"


def static_value(form: LinearForm, values: Mapping[str, float], where: str) -> float:
    """Value of a form that must depend on parameters only."""
    if not form.is_constant:
        raise ModelError(f"{where}: states and time cannot appear here, only parameters")
    value = constant_value(form.constant_part, values)
    if not math.isfinite(value):
        raise ModelError(not_finite(where, form.constant_part, value))
    return value
