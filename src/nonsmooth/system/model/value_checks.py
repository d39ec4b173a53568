"""Checks of a system for the present values of its parameters, and for many values at once.

`check_values` tests one set of values and says what is wrong with it. `sure_values` tests many sets
at once, as a sweep needs it, and gives no reasons. A test that is added to one of them has to be
added to the other. `System` also checks a declared symmetry, which neither of them does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import FREE, RESTING
from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.compile.dependence import where_it_stands
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.model.evaluated import EvaluatedSystem, not_finite
from nonsmooth.system.parts import Text
from nonsmooth.system.text.evaluate import constant_value, evaluate
from nonsmooth.system.text.expressions import Expression, Name, Number, names_in, to_text
from nonsmooth.system.text.grammar import parse_condition

__all__ = [
    "IS_REQUIRED",
    "check_structure",
    "check_values",
    "condition_of",
    "first_unmet",
    "rests_alike",
    "sure_values",
]

Bools = npt.NDArray[np.bool_]
IS_REQUIRED = " is required"  # what is said of a condition that does not hold
_TURN = 5e-15  # half of what `check_values` allows


def check_structure(system: EvaluatedSystem) -> None:
    """Linear forms exist, and nothing depends on a state that drifts and is no angle."""
    try:
        structure = system.structure
    except RecursionError:
        raise ModelError(
            f"{system.name}: definitions build on each other too deeply; write some of them out"
        ) from None
    known_periods = system.drift if isinstance(system.drift, Mapping) else {}
    for name in system.drift:
        where = "" if name in known_periods else where_it_stands(structure, name)
        if where:
            raise ModelError(
                f"drift: {where} depends on {name!r}, so it cannot be a drift state; where the"
                f" equations repeat with it, as with an angle, give its period: drift={{{name!r}:"
                " '2*pi'}; else leave it out of drift= or rewrite the equation"
            )


def check_values(system: EvaluatedSystem) -> None:
    """Everything that depends on the values of the parameters."""
    values = system.parameter_values
    for condition in system.require:
        for node in _condition_names(condition):
            if node.name not in values and node.name != "pi":
                sentence = unknown_name("parameter", node.name, values)
                raise ModelError(f"require[{condition!r}]: {sentence}")
    unmet = first_unmet(system.require, values)
    if unmet:
        raise ModelError(unmet)
    for name, forms in system.structure.modes.items():
        # of a piecewise guard one side may be a constant, and so may a reaction
        if forms.sides or forms.kind != FREE:
            continue
        at_rest = _moving_at_rest(system.structure, forms.declared)
        for way, guard in zip(forms.exit_names, forms.constant_guards, strict=True):
            if guard is not None and way not in at_rest:
                _check_guard(f"modes[{name!r}], exit {way!r}", guard, values)
    _check_finite(system)
    _check_clips(system)
    _check_holds(system)
    _check_angles(system)
    _ = system.rest_state
    period = system.period_value
    if period is not None:
        _check_period(system, period)


def _check_guard(where: str, guard: Expression, values: Mapping[str, float]) -> None:
    value = constant_value(guard, values)
    if not value > 0.0:
        raise ModelError(
            f"{where}: the guard is the constant {value:g}; a guard is positive inside its mode,"
            " so this mode could never be left or never be entered"
        )


def _moving_at_rest(structure: SystemStructure, declared: str) -> set[str]:
    """Exits of a mode whose guards change while it is at rest, such as those that read a force."""
    return {
        way
        for forms in structure.running
        if forms.declared == declared and forms.kind == RESTING
        for way, guard in zip(forms.exit_names, forms.constant_guards, strict=True)
        if guard is None
    }


def _check_finite(system: EvaluatedSystem) -> None:
    """Every coefficient is a finite number for the present parameters."""
    structure = system.structure
    values = structure.coefficient_values.values(system.parameter_values)
    if all(map(math.isfinite, values)):  # nearly always, and a slider asks often
        return
    for (where, coefficient), value in zip(structure.coefficients, values, strict=True):
        if not math.isfinite(value):
            raise ModelError(not_finite(where, coefficient, value))


def _check_clips(system: EvaluatedSystem) -> None:
    """Lower bounds of ``clip`` are not above the upper ones."""
    for where, low, high in system.structure.clips:
        least, most = (constant_value(bound, system.parameter_values) for bound in (low, high))
        if least > most:
            said = [
                f"{number:g}" if isinstance(bound, Number) else f"{to_text(bound)} = {number:g}"
                for bound, number in ((low, least), (high, most))
            ]
            raise ModelError(
                f"{where}: clip from {said[0]} to {said[1]} for the parameters given; the lower"
                " bound stands first and is not above the upper one: give other values, or swap"
                " the bounds"
            )


def _check_holds(system: EvaluatedSystem) -> None:
    """What a surface holds is no less than what it does while motion passes."""
    for name, text, hold in _held(system):
        value = constant_value(hold, system.parameter_values)
        if not value >= 1.0:
            raise ModelError(
                f"surfaces[{name!r}].hold = {text!r} is {value:g} for the parameters given; it is"
                " static over kinetic friction, 1 or more"
            )


def _held(system: EvaluatedSystem) -> Iterator[tuple[str, Text, Expression]]:
    """Surfaces that hold: their names, the text, and its expression of parameters."""
    found = {}
    for surfaces in system.structure.surfaces.values():
        for name, declared in surfaces.items():
            if declared.hold is not None and declared.given.hold is not None:
                found[name] = (name, declared.given.hold, declared.hold)
    yield from found.values()


def _check_angles(system: EvaluatedSystem) -> None:
    """Periods of angles in ``drift`` are positive."""
    for name, value in system.periods_of_angles.items():
        if not value > 0.0:
            raise ModelError(f"drift[{name!r}] = {value:g}: the period of an angle is positive")


def _check_period(system: EvaluatedSystem, period: float) -> None:
    structure = system.structure
    for frequency in structure.frequencies:
        turns = constant_value(frequency, system.parameter_values) * period / (2.0 * math.pi)
        # a period computed in double precision from its frequency is off by some ulps only
        if abs(turns - round(turns)) > 1e-14 * max(1.0, abs(turns)):
            raise ModelError(
                f"period = {period:g} is not a period of the equations: cos({to_text(frequency)}*t)"
                f" turns {turns:.6g} times in it; give a common period as an expression such as"
                " '2*pi/omega', or none"
            )


def first_unmet(require: Mapping[str, str], values: Mapping[str, float]) -> str:
    """The first condition that some values do not meet, in words; empty without one."""
    for condition, reason in require.items():
        if not _holds(condition, values):
            names = [n.name for n in _condition_names(condition) if n.name != "pi"]
            given = _with_enough_digits(condition, {name: values[name] for name in names})
            return f"{condition}{IS_REQUIRED}, {given} was given: {reason}"
    return ""


def _with_enough_digits(condition: str, values: Mapping[str, float]) -> str:
    """Values as texts, with so many digits that these do not meet the condition either."""
    for digits in (6, 9, 12, 17):
        texts = {name: f"{value:.{digits}g}" for name, value in values.items()}
        if not _holds(condition, {name: float(text) for name, text in texts.items()}):
            break
    return ", ".join(f"{name} = {text}" for name, text in texts.items())


def _holds(condition: str, values: Mapping[str, float]) -> bool:
    return bool(constant_value(condition_of(condition), values))


@lru_cache(maxsize=1024)
def condition_of(text: str) -> Expression:
    """Expression of a condition in ``require``."""
    return parse_condition(text, where=f"require[{text!r}]")


def _condition_names(text: str) -> list[Name]:
    return list({node.name: node for node in names_in(condition_of(text))}.values())


# ---------------------------------------------------------------- many values at once


def sure_values(system: EvaluatedSystem, sets: Mapping[str, npt.NDArray[np.float64]]) -> Bools:
    """Whether `System.with_parameters` takes each of K sets of values for sure, (K,) by name.

    The others need to be asked for one by one, which also tells what is wrong with them.
    """
    known: dict[str, Any] = {**system.parameter_values, **sets}
    structure = system.structure
    sure = np.ones(next(iter(sets.values())).shape, bool)

    def number(expression: Expression) -> Any:
        return evaluate(expression, known)

    with np.errstate(all="ignore"):
        for condition in system.require:
            sure &= np.asarray(number(condition_of(condition)), bool)
        positive = [form.constant_part for form in system.forms_of_angles.values()]
        for forms in structure.modes.values():
            if not forms.sides:
                positive += [guard for guard in forms.constant_guards if guard is not None]
        for expression in positive:
            value = number(expression)
            sure &= (value > 0.0) & np.isfinite(value)
        for value in structure.coefficient_values.values(known):
            sure &= np.isfinite(value)
        for _, low, high in structure.clips:
            sure &= number(low) <= number(high)
        for _, _, hold in _held(system):
            sure &= number(hold) >= 1.0
        for equation in structure.initial.values():
            sure &= np.isfinite(number(structure.static_form.form(equation).constant_part))
        for period in structure.period_nodes:
            length = number(period)
            sure &= (length > 0.0) & np.isfinite(length)
            for frequency in structure.frequencies:
                turns = number(frequency) * length / (2.0 * math.pi)
                sure &= np.abs(turns - np.rint(turns)) <= _TURN * np.maximum(1.0, np.abs(turns))
    return sure


def rests_alike(system: EvaluatedSystem, names: Iterable[str]) -> bool:
    """Whether the rest state is the same for all values of some parameters."""
    form, chosen = system.structure.static_form.form, set(names)
    texts: Mapping[str, Any] = system.structure.initial
    return all(
        chosen.isdisjoint(each.name for each in names_in(form(equation).constant_part))
        for equation in texts.values()
    )
