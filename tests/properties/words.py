"""The words of a system as plain data, made into a `System` and into TOML text."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

import nonsmooth as ns

Words = dict[str, Any]


@dataclass(frozen=True)
class Switch:
    """A function whose sign decides in the texts of a mode (None: of all of them).

    ``when`` is positive where it decides at all.
    """

    text: str
    mode: str | None = None
    when: str | None = None


@dataclass
class Drawn:
    """A system in words, a start and the length of a run; ``features`` say what is in it."""

    seed: int
    words: Words
    start: dict[str, float]
    length: dict[str, float]
    switches: list[Switch] = field(default_factory=list)
    features: set[str] = field(default_factory=set)

    def system(self) -> ns.System:
        return make_system(self.words)

    def toml(self) -> str:
        return toml_text(self.words)


def modes_of(words: Words) -> dict[str, Words]:
    """Modes as the package names them: equations alone are the mode ``flow``."""
    return words.get("modes") or {"flow": {"flow": words["equations"]}}


def make_system(words: Words) -> ns.System:
    made = dict(words)
    if "modes" in words:
        made["modes"] = {name: _mode(mode) for name, mode in words["modes"].items()}
    if "surfaces" in words:
        made["surfaces"] = {name: ns.Surface(**each) for name, each in words["surfaces"].items()}
    return ns.System(**made)


def _mode(words: Words) -> ns.Mode:
    exits = [ns.Exit(**each) for each in words.get("exits", [])]
    return ns.Mode(**{**words, "exits": exits})


def toml_text(words: Words) -> str:
    """TOML as one would write it by hand; every number as a decimal number."""
    lines = [f"states = {json.dumps(words['states'])}"]
    lines += [f"{key} = {_value(words[key])}" for key in ("period", "name") if key in words]
    for key in ("parameters", "definitions", "outputs", "equations"):
        lines += _table(key, words.get(key, {}))
    for name, each in words.get("surfaces", {}).items():
        lines += _table(f"surfaces.{name}", each)
    for name, mode in words.get("modes", {}).items():
        for key in ("flow", "slaved", "definitions"):
            lines += _table(f"modes.{name}.{key}", mode.get(key, {}))
        for each in mode.get("exits", []):
            lines += ["", f"[[modes.{name}.exits]]"]
            lines += [f"{k} = {_value(v)}" for k, v in each.items() if k != "reset"]
            resets = each.get("reset", {})
            lines += [f"reset.{state} = {_value(text)}" for state, text in resets.items()]
    return "\n".join(lines) + "\n"


def _table(name: str, entries: Words) -> list[str]:
    if not entries:
        return []
    return ["", f"[{name}]", *(f"{key} = {_value(value)}" for key, value in entries.items())]


def _value(value: Any) -> str:
    return json.dumps(value) if isinstance(value, str) else repr(float(value))
