"""Checks of what a system declares, before any equation is read.

Mappings are where mappings belong, and every name is well-formed, declared once and allowed where
it stands.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.engine.tables import MAX_AUGMENTED
from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.system.cells.cells import MOST_MODES
from nonsmooth.system.data import SystemData
from nonsmooth.system.parts import STOP, FrozenDict, Mode
from nonsmooth.system.signals import Signal
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.text.functions import FUNCTIONS
from nonsmooth.system.text.grammar import is_name, why_no_name

__all__ = ["MOST_STATES", "ONE_MODE", "check_kinds", "check_words", "modes_of"]

# names with a fixed meaning in the grammar, and those of the parts of runs and sections; other
# results have parts of their own (nonsmooth.runs.part_names)
_RESERVED = {"t", "pi", "rate", STOP, *FUNCTIONS}
_RESULT_NAMES = {
    "time", "event", "state", "mode", "point", "lane", "orbit", "parameter", "phase",
    "period_number", "event_time", "event_period_number", "event_phase", "event_name",
    "event_kind", "event_from", "event_to", "event_path", "event_count", "guard_rate",
    "certified", "estimated", "digits", "state_before", "state_after", "end_state", "anchor_state",
    "direction", "tangent", "state_0", "sensitivity", "parameter_0",
}  # fmt: skip
ONE_MODE = "flow"  # of a system that is written without modes
MOST_STATES = MAX_AUGMENTED - 1  # beside them stands the constant one
_MOST_EXITS = 60  # of a mode: results have six bits for each exit of a path


def check_kinds(system: SystemData) -> None:
    """Mappings where mappings belong."""
    for key in (
        "modes", "parameters", "definitions", "outputs", "require", "initial", "describe",
        "signals", "slow", "surfaces", "symmetry",
    ):  # fmt: skip
        value = getattr(system, key)
        if not isinstance(value, Mapping):
            raise ModelError(f"{key}: give a mapping such as {{name: ...}}, not {quote(value)}")


def modes_of(equations: Any, modes: Mapping[str, Mode]) -> Mapping[str, Mode]:
    """Modes of a system from either of the two ways to write them."""
    if equations is None:
        return modes
    if not isinstance(equations, Mapping):
        raise ModelError(
            f"equations: give a mapping of states to their rates, not {quote(equations)}"
        )
    one = {ONE_MODE: Mode(equations)}
    if modes and modes != one and not _handed_on(modes):
        raise ModelError(_both_given(equations, modes))
    return one


def _both_given(equations: Mapping[str, Any], modes: Any) -> str:
    """What is said of equations beside modes; one of them may be that of a system replaced."""
    if isinstance(equations, FrozenDict):
        return (
            f"modes: the system is written with equations=, which are its one mode {ONE_MODE!r},"
            " and other modes are given now. Take the equations back too:"
            " replace(system, modes=..., equations=None), where"
            f" {ONE_MODE!r}: Mode(system.equations) may be one of the modes; or change the"
            " equations alone: replace(system, equations=...)"
        )
    if isinstance(modes, FrozenDict):
        return (
            f"equations: they are one mode, and the system is written with modes="
            f" ({', '.join(map(str, modes))}). Take these back too: replace(system, equations=...,"
            " modes={}); or change some of them: replace(system, modes={**system.modes, ...})"
        )
    return (
        "equations: they are one mode, and modes= are given as well; write them as one of the"
        " modes, or leave modes= out"
    )


def _handed_on(modes: Mapping[str, Mode]) -> bool:
    """Whether modes are those that another system made of its equations.

    `dataclasses.replace` gives them with the equations that take their place.
    """
    if not isinstance(modes, FrozenDict) or set(modes) != {ONE_MODE}:
        return False
    return bool(modes[ONE_MODE] == Mode(modes[ONE_MODE].flow))


def check_words(system: SystemData) -> None:
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
                f"surfaces[{name!r}] is {quote(surface)}; write Surface('v - v_b', on='stick')"
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
        _check_text(f"require[{quote(condition)}]", reason)


def _check_symmetry(system: SystemData) -> None:
    """A symmetry maps states, and where a user says so modes."""
    for name, image in system.symmetry.items():
        known = [*system.states, *system.modes]
        if name not in known:
            raise ModelError(f"symmetry: {unknown_name('state or mode', name, known)}")
        if name not in system.states and image not in system.modes:
            raise ModelError(f"symmetry[{name!r}]: {unknown_name('mode', image, system.modes)}")


def _check_signals(system: SystemData) -> None:
    for name, signal in system.signals.items():
        if not isinstance(signal, Signal):
            raise ModelError(
                f"signals[{name!r}] is {quote(signal)}; write Signal(times, values), a list of"
                " times and one of values"
            )


def _check_slow(system: SystemData) -> None:
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
        raise ModelError(f"{where}: {quote(text)} is not a text")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ModelError(
            f"{where}: {quote(text)} has half of a surrogate pair in it, which no file can hold"
        ) from None


def _check_name(kind: str, name: object) -> None:
    if not isinstance(name, str) or not is_name(name):
        raise ModelError(
            f"{kind}: {quote(name)} is not a name; use ASCII letters, digits and _, not a reserved"
            f" word{why_no_name(name)}"
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


def _meaning(name: str) -> str:
    """What a name stands for wherever it is used."""
    known = {
        "t": "the time",
        "pi": "the number",
        "rate": "the rate of change of a state or signal",
        STOP: "the target of an exit that ends the run",
    }
    return known.get(name, "a function")


def _check_mode(system: SystemData, name: str, mode: Mode) -> None:
    if not isinstance(mode, Mode):
        raise ModelError(f"modes[{name!r}] is {quote(mode)}; write Mode(flow, exits=...)")
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
