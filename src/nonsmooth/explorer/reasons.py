"""What fires at an event, and why, in words: its guard, the modes, the jump, the certificate."""

from __future__ import annotations

from typing import Any

from nonsmooth.system.system import System

__all__ = ["certificate", "event_reasons"]

_KINDS = {
    "start": "start",
    "switch": "switch",
    "impact": "impact",
    "graze": "graze: a tangency that rounding leaves open",
    "corner": "corner: a second guard is zero at the same instant",
    "slide_entry": "motion begins to slide on the surface",
    "slide_exit": "motion leaves the surface",
    "stick": "rest begins",
    "chatter": "rebounds die out, and rest begins",
    "release": "rest ends",
}


def event_reasons(system: System, events: list[dict[str, Any]]) -> list[str]:
    """One text for each row of an event log; rows have the names of the modes on both sides."""
    guards = _guards(system)
    return [_reason(system, guards, event) for event in events]


def _guards(system: System) -> dict[str, tuple[str, dict[str, str]]]:
    """Guard and reset of each name that an event may have."""
    found: dict[str, tuple[str, dict[str, str]]] = {}
    for name, surface in system.surfaces.items():
        found[name] = (str(surface.function), {})
    for mode in system.modes.values():
        for way in mode.exits:
            reset = {state: str(text) for state, text in way.reset.items()}
            found.setdefault(str(way.name or way.to), (str(way.guard), reset))
    return found


def _reason(system: System, guards: dict[str, Any], event: dict[str, Any]) -> str:
    name, kind = event["name"], event["kind"]
    if kind == "start":
        return f"the motion starts in mode {_words(event['to'])}"
    parts = []
    if name in guards:
        guard, _ = guards[name]
        rate = f" at the rate {event['rate']:.3g}" if event["rate"] else ""
        parts.append(f"{guard} falls through 0{rate}")
    elif kind in _KINDS:
        parts.append(_KINDS[kind])
    if event["from"] != event["to"]:
        parts.append(f"{_words(event['from'])} → {_words(event['to'])}")
    jumps = [
        f"{state}: {before:.4g} → {after:.4g}"
        for state, before, after in zip(system.states, event["before"], event["after"], strict=True)
        if kind == "impact" and abs(after - before) > 1e-9 * (abs(after) + abs(before))
    ]
    return "; ".join([*parts, *jumps])


def certificate(event: dict[str, Any]) -> str:
    """What is known of the instant of an event."""
    if not event["certified"]:
        return "flagged: within rounding of a tangency"
    if event["estimated"]:
        return "flagged: the error of a step is estimated"
    return "certified"


def _words(mode: str) -> str:
    return mode.replace("_", " ")
