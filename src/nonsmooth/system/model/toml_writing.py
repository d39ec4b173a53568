"""A system as TOML text: the form in which it is stored beside every result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from nonsmooth.system.data import SystemData

__all__ = ["FORMAT_VERSION", "key_text", "system_to_toml"]

FORMAT_VERSION = 1


def system_to_toml(system: SystemData) -> str:
    """TOML text with the same words as the Python contract and a version key."""
    lines = [f"format = {FORMAT_VERSION}", f"name = {_value(system.name)}"]
    lines.append(f"states = {_value(list(system.states))}")
    if system.period is not None:
        lines.append(f"period = {_value(system.period)}")
    if isinstance(system.drift, Mapping):
        lines += ["", *_table("drift", system.drift)]
    elif system.drift:
        lines.append(f"drift = {_value(list(system.drift))}")
    for key in (
        "symmetry", "parameters", "definitions", "outputs", "require", "initial", "describe",
        "slow",
    ):  # fmt: skip
        entries = getattr(system, key)
        if entries:
            lines += ["", *_table(key, entries)]
    for name, signal in system.signals.items():
        words = {"times": signal.times.tolist(), "values": signal.values.tolist()}
        lines += ["", *_table(f"signals.{name}", words | {"method": signal.method})]
    for name, surface in system.surfaces.items():
        words = {item.name: getattr(surface, item.name) for item in fields(surface)}
        given = {key: value for key, value in words.items() if value is not None}
        lines += ["", *_table(f"surfaces.{name}", given)]
    if system.equations is not None:
        lines += ["", *_table("equations", system.equations)]
        return "\n".join(lines) + "\n"
    for name, mode in system.modes.items():
        lines += ["", *_table(f"modes.{name}.flow", mode.flow)]
        for key in ("slaved", "definitions"):
            if getattr(mode, key):
                lines += ["", *_table(f"modes.{name}.{key}", getattr(mode, key))]
        if mode.cells:
            lines += ["", *_table(f"modes.{name}.cells", mode.cells)]
        for way in mode.exits:
            lines += ["", f"[[modes.{name}.exits]]", f"guard = {_value(way.guard)}"]
            for key in ("to", "name", "sticks"):
                if getattr(way, key) is not None:
                    lines.append(f"{key} = {_value(getattr(way, key))}")
            if way.reset:
                inner = ", ".join(f"{k} = {_value(v)}" for k, v in way.reset.items())
                lines.append(f"reset = {{ {inner} }}")
    return "\n".join(lines) + "\n"


def _table(name: str, entries: Mapping[str, Any]) -> list[str]:
    return [f"[{name}]", *(f"{key_text(key)} = {_value(value)}" for key, value in entries.items())]


def key_text(key: str) -> str:
    """TOML spelling of a key: bare where it may be."""
    return key if key.isidentifier() and key.isascii() else _value(key)


def _value(value: Any) -> str:
    """TOML spelling; basic strings of TOML and of JSON agree for printable text."""
    if isinstance(value, list):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(float(value))  # one spelling, so that 1 and 1.0 make equal systems
