"""Checks of a system: what is declared, what hangs together, what values are allowed.

Three rounds, from cheap to dear: words (before anything is parsed), structure (linear
forms), values (everything that depends on the numbers of the parameters).
"""

from __future__ import annotations

import keyword
import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from nonsmooth.engine.tables import FREE, MAX_AUGMENTED, RESTING
from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.cells import MOST_MODES
from nonsmooth.system.equations import Equation
from nonsmooth.system.evaluate import constant_value
from nonsmooth.system.expressions import ONE, Expression, Name, names_in, to_text
from nonsmooth.system.functions import FUNCTIONS
from nonsmooth.system.grammar import is_name, parse, parse_condition
from nonsmooth.system.linear import LinearForm, Power, State
from nonsmooth.system.parts import STOP, Mode, Text
from nonsmooth.system.signals import Signal
from nonsmooth.system.surfaces import Surface

if TYPE_CHECKING:
    from nonsmooth.system.structure import Structure
    from nonsmooth.system.system import System

__all__ = [
    "MOST_STATES",
    "ONE_MODE",
    "angle_periods",
    "check_kinds",
    "check_structure",
    "check_values",
    "check_words",
    "condition_of",
    "first_unmet",
    "modes_of",
    "parameter_values",
    "period_value",
    "rest_state",
    "unrepeated",
]

# names with a fixed meaning in the grammar, and the dimensions of every result
_RESERVED = {"t", "pi", "rate", STOP, *FUNCTIONS}
_RESULT_NAMES = {
    "time", "event", "state", "mode", "point", "lane", "orbit", "parameter", "phase",
    "period_number", "event_time", "event_period_number", "event_phase", "event_name",
    "event_kind", "event_from", "event_to", "event_path", "event_count", "guard_rate",
    "certified", "state_before", "state_after", "end_state", "anchor_state",
    "direction",
}  # fmt: skip
ONE_MODE = "flow"  # of a system that is written without modes
MOST_STATES = MAX_AUGMENTED - 1  # beside them stands the constant one
_MOST_EXITS = 60  # of a mode: results have six bits for each exit of a path


def check_kinds(system: System) -> None:
    """Mappings where mappings belong."""
    for key in (
        "modes", "parameters", "definitions", "outputs", "require", "initial", "describe",
        "signals", "slow", "surfaces", "symmetry",
    ):  # fmt: skip
        value = getattr(system, key)
        if not isinstance(value, Mapping):
            raise ModelError(f"{key}: give a mapping such as {{name: ...}}, not {value!r:.60}")


def modes_of(equations: Any, modes: Mapping[str, Mode]) -> Mapping[str, Mode]:
    """Modes of a system from either of the two ways to write them."""
    if equations is None:
        return modes
    if not isinstance(equations, Mapping):
        raise ModelError(
            f"equations: give a mapping of states to their rates, not {equations!r:.60}"
        )
    one = {ONE_MODE: Mode(equations)}
    if modes and modes != one:
        raise ModelError(
            "equations: they are one mode, and modes= are given as well; write them as one of the"
            " modes, or leave modes= out"
        )
    return one


def check_words(system: System) -> None:
    """Every name is well-formed, declared once and allowed where it stands."""
    _check_text("name", system.name)
    if len(system.modes) > MOST_MODES:
        raise ModelError(f"modes: {len(system.modes)} modes; at most {MOST_MODES} are supported")
    if len(system.states) > MOST_STATES:
        raise ModelError(
            f"states: {len(system.states)} states; at most {MOST_STATES} can run: reduce the model,"
            " for example to its slowest natural modes"
        )
    if not system.states:
        raise ModelError("states: a system needs at least one state")
    if not system.modes:
        raise ModelError("modes: a system needs at least one mode, or equations=")
    owner: dict[str, str] = {}
    for kind in ("states", "parameters", "definitions", "outputs", "signals", "surfaces"):
        for name in getattr(system, kind):
            _check_name(kind, name)
            if name in owner:
                raise ModelError(f"{kind}: {name!r} is declared already in {owner[name]}")
            owner[name] = kind
    _check_signals(system)
    _check_slow(system)
    for name, surface in system.surfaces.items():
        if not isinstance(surface, Surface):
            raise ModelError(
                f"surfaces[{name!r}] is {surface!r:.60}; write Surface('v - v_b', on='stick')"
            )
    for name, mode in system.modes.items():
        _check_name("modes", name)
        _check_mode(system, name, mode)
    for name in system.drift:
        if not isinstance(name, str) or name not in system.states:
            raise ModelError(f"drift: {unknown_name('state', name, system.states)}")
    _check_symmetry(system)
    for name in system.initial:
        if name not in system.states:
            raise ModelError(f"initial: {unknown_name('state', name, system.states)}")
    for name, label in system.describe.items():
        if name not in owner and name != "time":
            raise ModelError(f"describe: {unknown_name('name', name, [*owner, 'time'])}")
        _check_text(f"describe[{name!r}]", label)
    for condition, reason in system.require.items():
        _check_text(f"require[{condition!r:.60}]", reason)


def _check_symmetry(system: System) -> None:
    """A symmetry maps states, and where a user says so modes."""
    for name, image in system.symmetry.items():
        known = [*system.states, *system.modes]
        if name not in known:
            raise ModelError(f"symmetry: {unknown_name('state or mode', str(name), known)}")
        if name not in system.states and image not in system.modes:
            raise ModelError(
                f"symmetry[{name!r}]: {unknown_name('mode', str(image), system.modes)}"
            )


def _check_signals(system: System) -> None:
    for name, signal in system.signals.items():
        if not isinstance(signal, Signal):
            raise ModelError(
                f"signals[{name!r}] is {signal!r:.60}; write Signal(times, values), a list of times"
                " and one of values"
            )


def _check_slow(system: System) -> None:
    for name in system.slow:
        if name not in system.parameters:
            raise ModelError(f"slow: {unknown_name('parameter', name, system.parameters)}")
        if name in _RESULT_NAMES:
            raise ModelError(
                f"slow: {name!r} is the name of a variable of results, and a slow parameter is one"
                " too; choose another name"
            )
        if system.period is None:
            raise ModelError(
                f"slow: {name!r} changes from period to period, and the system has no period;"
                " declare period=, which where nothing drives the system may be any time for which"
                " the parameter is to be kept, or write the change as a definition in t"
            )


def _check_text(where: str, text: object) -> None:
    """Names, labels and reasons are texts that a file can hold."""
    if not isinstance(text, str):
        raise ModelError(f"{where}: {text!r:.60} is not a text")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ModelError(
            f"{where}: {text!r:.60} has half of a surrogate pair in it, which no file can hold"
        ) from None


def _check_name(kind: str, name: object) -> None:
    if not isinstance(name, str) or not is_name(name):
        raise ModelError(
            f"{kind}: {name!r:.60} is not a name; use letters, digits and _, not a reserved word"
            f"{_why_no_name(name)}"
        )
    if name in _RESERVED:
        raise ModelError(
            f"{kind}: {name!r} has a fixed meaning, {_meaning(name)}; choose another name, such as"
            f" {name}_"
        )
    if kind in ("states", "outputs") and name in _RESULT_NAMES:
        raise ModelError(
            f"{kind}: {name!r} is the name of a variable of results; choose another name"
        )


def _why_no_name(name: object) -> str:
    if not isinstance(name, str) or not keyword.iskeyword(name):
        return ""
    return f": equations are read as Python reads them, where {name} is one; write {name}_"


def _meaning(name: str) -> str:
    """What a name stands for wherever it is used."""
    known = {
        "t": "the time",
        "pi": "the number",
        "rate": "the rate of change of a state or signal",
        STOP: "the target of an exit that ends the run",
    }
    return known.get(name, "a function")


def _check_mode(system: System, name: str, mode: Mode) -> None:
    if not isinstance(mode, Mode):
        raise ModelError(f"modes[{name!r}] is {mode!r:.60}; write Mode(flow, exits=...)")
    if len(mode.exits) > _MOST_EXITS:
        raise ModelError(
            f"modes[{name!r}]: {len(mode.exits)} exits; at most {_MOST_EXITS} are supported"
        )
    for state in (*mode.flow, *mode.slaved):
        if state not in system.states:
            raise ModelError(f"modes[{name!r}]: {unknown_name('state', state, system.states)}")
    for state in system.states:
        if state in mode.flow and state in mode.slaved:
            raise ModelError(
                f"modes[{name!r}]: {state!r} has a flow and is slaved; keep one of them"
            )
        if state not in mode.flow and state not in mode.slaved:
            raise ModelError(
                f"modes[{name!r}]: state {state!r} has neither a flow nor a slaved equation;"
                f' add flow["{state}"], "0" if it does not change'
            )
    for position, way in enumerate(mode.exits):
        if way.sticks is not None:
            _check_name(f"modes[{name!r}].exits[{position}].sticks", way.sticks)
    for key in mode.definitions:
        if key not in system.definitions:
            raise ModelError(
                f"modes[{name!r}].definitions: a mode overrides definitions of the system;"
                f" {unknown_name('definition', key, system.definitions)}"
            )


def check_structure(system: System) -> None:
    """Linear forms exist and nothing depends on a drifting state."""
    try:
        structure = system.structure
    except RecursionError:
        raise ModelError(
            f"{system.name}: definitions build on each other too deeply; write some of them out"
        ) from None
    for drifting in system.drift_states:
        for where, depends in _dependences(structure, drifting):
            if depends:
                raise ModelError(
                    f"drift: {where} depends on {drifting!r}, so it cannot be a drift state;"
                    " leave it out of drift= or rewrite the equation"
                )


def _dependences(structure: Structure, drifting: str) -> Iterator[tuple[str, bool]]:
    """Everything that a drift must not enter, and whether it does."""
    for forms in structure.modes.values():
        if forms.taylor is not None:
            for where, node, own in forms.taylor.with_place(forms.name):
                yield where, forms.depends(node, drifting, own)
        elif forms.linear is not None:
            for where, form, own in forms.linear.with_place(forms.name):
                yield where, _form_depends(form, drifting, own)


def _form_depends(form: LinearForm, drifting: str, own: str) -> bool:
    if own != drifting:
        return State(drifting) in form.terms
    moved = {b: c for b, c in form.terms.items() if b != State(drifting)}
    stays = form.coefficient(State(drifting)) == ONE
    return not stays or any(isinstance(b, State) for b in moved)


def check_values(system: System) -> None:
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
    _check_holds(system)
    _check_angles(system)
    _ = system.rest_state
    period = system.period_value
    if period is not None:
        _check_period(system, period)
    _ = system.mirror


def _check_finite(system: System) -> None:
    """Every coefficient is a finite number for the present parameters."""
    structure = system.structure
    values = structure.coefficient_values.values(system.parameter_values)
    for (where, coefficient), value in zip(structure.coefficients, values, strict=True):
        if not math.isfinite(value):
            raise ModelError(
                f"{where}: {to_text(coefficient)} is {float(value)} for the parameters given;"
                " change them, or forbid such values in require="
            )


def _check_holds(system: System) -> None:
    """What a surface holds is no less than what it does while motion passes."""
    for name, text, hold in _held(system):
        value = constant_value(hold, system.parameter_values)
        if not value >= 1.0:
            raise ModelError(
                f"surfaces[{name!r}].hold = {text!r} is {value:g} for the parameters given; it is"
                " static over kinetic friction, 1 or more"
            )


def _held(system: System) -> Iterator[tuple[str, Text, Expression]]:
    """Surfaces that hold: their names, the text, and its expression of parameters."""
    found = {}
    for surfaces in system.structure.surfaces.values():
        for name, declared in surfaces.items():
            if declared.hold is not None and declared.given.hold is not None:
                found[name] = (name, declared.given.hold, declared.hold)
    yield from found.values()


def _check_angles(system: System) -> None:
    """Periods of angles in ``drift`` are positive."""
    for where, text, form in angle_periods(system):
        if not static_value(form, system.parameter_values, where) > 0.0:
            raise ModelError(f"{where} = {text!r}: the period of an angle is positive")


def angle_periods(system: System) -> Iterator[tuple[str, Text, LinearForm]]:
    """Where the period of each angle in ``drift`` stands, its text, and what it means."""
    if not isinstance(system.drift, Mapping):
        return
    known = {*system.parameters, *system.definitions, "pi"}
    for state, text in system.drift.items():
        where = f"drift[{state!r}]"
        yield where, text, system.structure.static_form.form(Equation.read(text, where, known))


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


def rest_state(system: System) -> dict[str, float]:
    """Documented rest state: ``initial``, zero where it says nothing."""
    state = dict.fromkeys(system.states, 0.0)
    for name, equation in system.structure.initial.items():
        form = system.structure.static_form.form(equation)
        state[name] = static_value(form, system.parameter_values, equation.where)
    return state


def period_value(system: System) -> float | None:
    """Period as a number, positive and finite."""
    equation = system.structure.period
    if equation is None:
        return None
    form = system.structure.static_form.form(equation)
    value = static_value(form, system.parameter_values, "period")
    if not (value > 0.0 and math.isfinite(value)):
        raise ModelError(f"period: {equation.text!r} is {value}; it must be positive and finite")
    return value


def static_value(form: LinearForm, values: Mapping[str, float], where: str) -> float:
    """Value of a form that must depend on parameters only."""
    if not form.is_constant:
        raise ModelError(f"{where}: states and time cannot appear here, only parameters")
    value = constant_value(form.constant_part, values)
    if not math.isfinite(value):
        raise ModelError(
            f"{where}: {to_text(form.constant_part)} is {value} for the parameters given"
        )
    return value


def first_unmet(require: Mapping[str, str], values: Mapping[str, float]) -> str:
    """The first condition that some values do not meet, in words; empty without one."""
    for condition, reason in require.items():
        if not _holds(condition, values):
            names = [n.name for n in _condition_names(condition) if n.name != "pi"]
            given = ", ".join(f"{name} = {values[name]:g}" for name in names)
            return f"{condition} is required, {given} was given: {reason}"
    return ""


def _holds(condition: str, values: Mapping[str, float]) -> bool:
    return bool(constant_value(condition_of(condition), values))


@lru_cache(maxsize=1024)
def condition_of(text: str) -> Expression:
    """Expression of a condition in ``require``."""
    return parse_condition(text, where=f"require[{text!r}]")


def _condition_names(text: str) -> list[Name]:
    return list({node.name: node for node in names_in(condition_of(text))}.values())


def _moving_at_rest(structure: Structure, declared: str) -> set[str]:
    """Exits of a mode whose guards change while it is at rest, such as those that read a force."""
    return {
        way
        for forms in structure.running
        if forms.declared == declared and forms.kind == RESTING
        for way, guard in zip(forms.exit_names, forms.constant_guards, strict=True)
        if guard is None
    }


def _check_guard(where: str, guard: Expression, values: Mapping[str, float]) -> None:
    value = constant_value(guard, values)
    if not value > 0.0:
        raise ModelError(
            f"{where}: the guard is the constant {value:g}; a guard is positive inside its mode,"
            " so this mode could never be left or never be entered"
        )


def _check_period(system: System, period: float) -> None:
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


def unrepeated(system: System) -> str:
    """What in the equations does not repeat after any time, in words; empty without it."""
    structure = system.structure
    for name in system.signals:
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
