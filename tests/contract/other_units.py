"""The same motion in other states and another time, by texts that are rewritten."""

import re
import tomllib

import nonsmooth as ns


def in_other_units(system, factor=1.0, pace=1.0, guard=1.0):
    """Each state s becomes factor times a new one, and time ``pace`` times a new one.

    With factor -1 it is the mirrored system. ``guard`` multiplies all guards and surfaces.
    """
    words = tomllib.loads(system.to_toml())
    assert words.pop("format") == 1
    names = re.compile(rf"\b({'|'.join([*words['states'], 't'])})\b")

    def scaled(match):
        name = match.group(1)
        return f"({pace!r}*t)" if name == "t" else f"({factor!r}*{name})"

    def text(given):
        return names.sub(scaled, str(given))

    def rates(flow):
        return {s: f"({text(given)})*{pace!r}/{factor!r}" for s, given in flow.items()}

    def values(given):
        return {s: f"({text(value)})/{factor!r}" for s, value in given.items()}

    def exit_(guard_, reset=None, **more):
        return ns.Exit(f"{guard!r}*({text(guard_)})", reset=values(reset or {}), **more)

    def mode(flow, exits=(), **more):
        return ns.Mode(rates(flow), exits=[exit_(e.pop("guard"), **e) for e in exits], **more)

    def surface(function, **more):
        return ns.Surface(f"{guard!r}*({text(function)})", **more)

    if "period" in words:
        words["period"] = f"({words['period']})/{pace!r}"
    if "equations" in words:
        words["equations"] = rates(words["equations"])
    if "modes" in words:
        words["modes"] = {name: mode(**given) for name, given in words["modes"].items()}
    if "surfaces" in words:
        words["surfaces"] = {name: surface(**given) for name, given in words["surfaces"].items()}
    for part in ("definitions", "outputs"):
        if part in words:
            words[part] = {name: text(given) for name, given in words[part].items()}
    return ns.System(**words)
