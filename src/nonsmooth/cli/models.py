"""``nonsmooth models``: what ready-made systems there are, and the equations of a system."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.cli.arguments import build_system, is_file, model_functions
from nonsmooth.cli.console import print_table
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    from nonsmooth.system.parts import Mode
    from nonsmooth.system.system import System

__all__ = ["models"]


def models(
    name: Annotated[
        str | None,
        typer.Argument(metavar="MODEL", help="Print the equations of this one, or of a file."),
    ] = None,
    *,
    toml: Annotated[
        bool, typer.Option("--toml", help="Print it as TOML, to be changed and simulated.")
    ] = False,
) -> None:
    """List the ready-made systems, or print the equations of one."""
    if name is None:
        if toml:
            raise OptionError("--toml: name a model, see: nonsmooth models")
        print_table(
            ("model", "what it is"), [(k, _summary(f)) for k, f in model_functions().items()]
        )
        return
    system = build_system(name, {})
    if toml:
        typer.echo(system.to_toml(), nl=False)
        return
    from nonsmooth.system.columns import aligned, one_line

    about = system.name if is_file(name) else _summary(model_functions()[name])
    typer.echo(one_line(f"{name}: {about}"))
    for title, rows in _tables(system):
        if rows:
            typer.echo("\n".join(["", title, *aligned(rows)]))
    for mode_name, mode in system.modes.items():
        typer.echo("\n".join(["", f"mode {mode_name}", *aligned(list(_equations(mode)))]))


def _summary(function: object) -> str:
    return (inspect.getdoc(function) or "").partition("\n")[0]


def _tables(system: System) -> Iterator[tuple[str, list[tuple[str, str, str]]]]:
    """Parts of a system as rows of name, value and meaning."""
    meaning = system.describe.get
    parameters = [
        (name, f"= {_with_value(text, system.parameter_values[name])}", meaning(name, ""))
        for name, text in system.parameters.items()
    ]
    yield "parameters", parameters
    yield "required", [(condition, "", reason) for condition, reason in system.require.items()]
    if system.period is not None:
        assert system.period_value is not None
        yield "period", [("T", f"= {_with_value(system.period, system.period_value)}", "")]
    states = [
        (name, f"= {system.rest_state[name]:g} at rest", _state_meaning(system, name))
        for name in system.states
    ]
    yield "states", states
    for title, texts in (("definitions", system.definitions), ("outputs", system.outputs)):
        yield title, [(name, f"= {text}", meaning(name, "")) for name, text in texts.items()]


def _with_value(text: object, value: float) -> str:
    return f"{text} = {value:.6g}" if isinstance(text, str) else f"{text:g}"


def _state_meaning(system: System, name: str) -> str:
    label = system.describe.get(name, "")
    if name not in system.drift_states:
        return label
    return f"{label}; drifts" if label else "drifts"


def _equations(mode: Mode) -> Iterator[tuple[str, str, str]]:
    from nonsmooth.system.equations.mode_equations import is_relation

    for name, text in mode.definitions.items():
        yield name, f"= {text}", "in this mode"
    for state, text in mode.flow.items():
        yield f"{state}'", f"= {text}", ""
    for state, text in mode.slaved.items():
        yield state, f"from {text}" if is_relation(text) else f"= {text}", "slaved"
    for way in mode.exits:
        target = f"to {way.to}" if way.to else "to the same mode"
        reset = "".join(f", {state} := {text}" for state, text in way.reset.items())
        yield f"exit {way.name or way.to or ''}".rstrip(), f"when {way.guard} < 0", target + reset
