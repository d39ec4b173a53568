"""A view as a script of Python, as commands of the shell, and as TOML.

All are written from the same calls that the page makes, so they give the same digits.
"""

from __future__ import annotations

import shlex
from typing import Any

from nonsmooth.explorer import calls
from nonsmooth.explorer.calls import EvenValues, Result, VerbCall
from nonsmooth.explorer.view import View

__all__ = ["command_text", "pictures", "python_text", "toml_text"]

_COMMANDS = {
    "run": "simulate",
    "diagram": "diagram",
    "basins": "basins",
    "points": "strobe",
    "orbit": "orbit",
    "branch": "continue",
}
_FILE = "machine.toml"
# names of options that the shell calls otherwise
_OPTIONS = {("basins", "samples"): "starts", ("orbit", "period"): "order"}


def python_text(view: View) -> str:
    """Script that computes what the page shows, and draws it."""
    lines = ["import numpy as np", "", "import nonsmooth as ns", ""]
    lines += [f"system = {_system_code(view)}", ""]
    done: set[str] = set()
    for title, made, drawn in _parts(view):
        lines.append(f"# {title}")
        for call in made:
            if call.name not in done:
                done.add(call.name)
                lines.append(f"{call.name} = ns.{call.verb}({_arguments_code(call)})")
        lines += [f"ns.plot.{drawn}.figure.savefig({title.replace(' ', '-') + '.png'!r})", ""]
    body = "\n".join(lines)
    return body if "np." in body else body.replace("import numpy as np\n\n", "", 1)


def _parts(view: View) -> list[tuple[str, list[VerbCall], str]]:
    """What a page shows: a title, the calls, and what draws their result."""
    x, y = view.portrait
    motion = calls.motion(view)
    drawn = dict(pictures(view))
    parts = [
        ("time history", motion, drawn["history"]),
        ("phase portrait", motion, drawn["portrait"]),
    ]
    if view.over:
        parts.append(("bifurcation diagram", calls.diagram(view), drawn["diagram"]))
    if view.turn > 0:
        parts.append(
            (
                "orbit",
                [*motion, *calls.orbit(view)],
                f"periodic_orbit(ns.orbit_samples(orbit), {x!r}, {y!r})",
            )
        )
        if view.branch and view.over:
            parts.append(("branch", calls.branch(view), drawn["branch"]))
    if view.plane and view.picture == "basins" and view.region:
        parts.append(("basins", calls.basins(view), drawn["basins"]))
    if view.plane and view.picture == "section":
        parts.append(("section", calls.points(view), drawn["section"]))
    return parts


def pictures(view: View) -> list[tuple[str, str]]:
    """Functions of `nonsmooth.plot` with their arguments, as code, by what they show."""
    x, y = view.portrait
    across, up = view.plane or view.portrait
    return [
        ("history", f"phases(run, {list(view.drawn)!r})"),
        ("portrait", f"phase_portrait(run, {x!r}, {y!r}, phases=True)"),
        ("diagram", f"bifurcation(diagram, {view.shown!r})"),
        ("branch", f"branch(branch, {view.shown!r}, diagram=diagram)"),
        ("basins", "basins(basins)"),
        ("section", f"section(points, {across!r}, {up!r})"),
    ]


def _system_code(view: View) -> str:
    values = ", ".join(f"{name}={_value_code(value)}" for name, value in view.values)
    if not view.text:
        return f"ns.models.{view.model}({values})"
    # a text of three quotes would end early at its own quotes; repr never does
    quoted = f"'''\n{view.text}'''" if _fits_in_quotes(view.text) else repr(view.text)
    made = f"ns.System.from_toml({quoted})"
    return f"{made}.with_parameters({values})" if values else made


def _fits_in_quotes(text: str) -> bool:
    return "'''" not in text and "\\" not in text and not text.endswith("'")


def _value_code(value: str) -> str:
    try:
        return repr(float(value))
    except ValueError:
        return repr(value)


def _arguments_code(call: VerbCall) -> str:
    words = [_code(value) for value in call.arguments]
    words += [f"{name}={_code(value)}" for name, value in call.options.items()]
    return ", ".join(words)


def _code(value: Any) -> str:
    if isinstance(value, Result):
        return value.name
    if isinstance(value, EvenValues):
        return f"np.linspace({value.first!r}, {value.last!r}, {value.count})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key!r}: {_code(item)}" for key, item in value.items()) + "}"
    return repr(value)


def command_text(view: View) -> str:
    """Commands of the shell, one for each pane; a typed system is read from a file."""
    lines = [] if not view.text else [f"# {_FILE}: copy it with TOML"]
    for _, made, _ in _parts(view):
        call = made[-1]
        line = _command(view, call)
        if line not in lines:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _command(view: View, call: VerbCall) -> str:
    name = _COMMANDS[call.name]
    words = ["nonsmooth", name, _FILE if view.text else view.model]
    words += [f"{key}={value}" for key, value in view.values]
    options = dict(call.options)
    if call.name == "run":
        words += _run_words(view, options)
        options = {"samples_per_period": options.get("samples_per_period")}
    if call.name == "points" and "section" in options:
        words[1] = "section"
    for value in call.arguments:
        words += _over_words(call, value)
    if call.name in ("diagram", "basins") and view.section:
        words += ["--section", view.section]
    if call.name == "orbit":  # the shell runs the motion before it itself
        words += _initial_words(view)
        options["transient"] = int(view.leave_out + view.length)
    if call.name == "branch":
        words += [*_initial_words(view), "--order", str(view.turn)]
        words += ["--over", f"{view.over}={call.arguments[2][0]!r}:{call.arguments[2][1]!r}"]
        options = {"transient": int(view.leave_out + view.length), "steps": options["steps"]}
    if call.name == "points":
        words += _initial_words(view)
    for key, value in options.items():
        if value is None or (key == "section" and view.section and call.name == "diagram"):
            continue
        flag = "--" + _OPTIONS.get((name, key), key).replace("_", "-")
        words += [flag, _assignments(value) if isinstance(value, dict) else f"{value}"]
    return shlex.join(words)


def _run_words(view: View, options: dict[str, Any]) -> list[str]:
    """The shell has no second run, so what is left out is run as well and is not drawn."""
    length, words = view.leave_out + view.length, _initial_words(view)
    if "periods" not in options:
        return [*words, "--t-end", f"{length:g}"]
    return [*words, "--periods", f"{length:g}"]


def _initial_words(view: View) -> list[str]:
    return ["--initial", _assignments(dict(view.initial))] if view.initial else []


def _assignments(values: dict[str, Any]) -> str:
    return ",".join(f"{name}={value!r}" for name, value in values.items())


def _over_words(call: VerbCall, value: Any) -> list[str]:
    if isinstance(value, EvenValues):
        return ["--over", f"{call.arguments[1]}={_range(value)}"]
    if isinstance(value, dict) and all(isinstance(item, EvenValues) for item in value.values()):
        return [word for key, item in value.items() for word in ("--over", f"{key}={_range(item)}")]
    return []


def _range(grid: EvenValues) -> str:
    return f"{grid.first!r}:{grid.last!r}:{grid.count}"


def toml_text(view: View) -> str:
    """The system with its present parameters."""
    return view.system.to_toml()
