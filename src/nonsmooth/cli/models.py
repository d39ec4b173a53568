"""Commands that show systems: which are ready-made, what stands in one, and how it moves."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from nonsmooth.cli.arguments import build_system, is_file
from nonsmooth.cli.command import Task
from nonsmooth.cli.console import print_table
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    from nonsmooth.system.parts import Mode
    from nonsmooth.system.system import System

__all__ = ["explain", "explore", "models"]


def models(task: Task) -> None:
    """``nonsmooth models``."""
    from nonsmooth.models.ready_made import ready_made

    name = task["model"]
    if name is None:
        if task["toml"]:
            raise OptionError("--toml: name a model, see: nonsmooth models")
        rows = [(known, _summary(function)) for known, function in ready_made().items()]
        if task["json"]:
            models = [{"model": known, "summary": text} for known, text in rows]
            click.echo(json.dumps({"models": models}, indent=2, ensure_ascii=False))
            return
        print_table(("model", "what it is"), rows)
        return
    system = build_system(name, {})
    if task["toml"]:
        if task["json"]:
            raise OptionError("give one of --toml and --json: each is a document of its own")
        click.echo(system.to_toml(), nl=False)
        return
    _print_model(task, name, system)


def _print_model(task: Task, name: str, system: System) -> None:
    """Print parameters, states and equations of a system, each as a name, a text and a meaning."""
    from nonsmooth.models.ready_made import ready_made
    from nonsmooth.system.columns import aligned, one_line

    about = system.name if is_file(name) else _summary(ready_made()[name])
    parts = {title: rows for title, rows in _tables(system) if rows}
    modes = {mode: list(_equations(equations)) for mode, equations in system.modes.items()}
    if task["json"]:
        document: dict[str, Any] = {"model": name, "summary": about}
        document |= {title: _named(rows) for title, rows in parts.items()}
        document["modes"] = {mode: _named(rows) for mode, rows in modes.items()}
        numbers = {key: float(value) for key, value in system.parameter_values.items()}
        document["parameter_values"] = numbers
        click.echo(json.dumps(document, indent=2, ensure_ascii=False))
        return
    click.echo(one_line(f"{name}: {about}"))
    for title, rows in [*parts.items(), *((f"mode {mode}", rows) for mode, rows in modes.items())]:
        click.echo("\n".join(["", title, *aligned(rows)]))


def _named(rows: list[tuple[str, str, str]]) -> list[dict[str, str]]:
    return [
        {"name": name, "text": text.removeprefix("= "), "meaning": meaning}
        for name, text, meaning in rows
    ]


def explain(task: Task) -> None:
    """``nonsmooth explain``."""
    task.system.explain()


def explore(task: Task) -> None:
    """``nonsmooth explore``."""
    from nonsmooth.explorer.explore import explore as open_page

    system = None if task["model"] is None else task.system
    if system is not None and task["link"]:
        raise OptionError("--link has a system of its own: leave out the model, or --link")
    options = task.options("explore") | {"allow_origin": task["allow_origin"] or ()}
    open_page(system, browser=not task["no_browser"], wait=True, **options)


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
