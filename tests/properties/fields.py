"""Motion within flights by scipy's integrator and the texts, piecewise as they stand.

On a surface the field is Filippov's combination of what the texts give on both sides of it; at
rest it is that of the texts with a reaction along the jump of the reset. Both come from
differences, so they are good to about 1e-7.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from properties.judging import TINY, Flight, vanishes
from properties.own_texts import Texts
from properties.words import Drawn

MOST_CALLS = 6000
EXACT, BY_DIFFERENCES = 1e-8, 1e-5
ASIDE = 1e-7  # distance from a surface at which its sides are looked at
GROWTH = 1e-7  # of a second start, which shows how errors grow

Field = Callable[[float, np.ndarray], np.ndarray]


class TooManyCalls(Exception):
    """The integrator takes too long for this flight."""


def deviation(drawn: Drawn, texts: Texts, flight: Flight, size: float) -> list[str]:
    """Complaints about the end of a flight, judged from its first sample; None: not judged."""
    if any("=" in text for text in texts.modes[flight.mode].get("slaved", {}).values()):
        return []
    surfaces = _surfaces(drawn, texts, flight, size)
    if len(surfaces) > 1 or len(flight.resting) > 1 or (surfaces and flight.resting):
        return []
    field, limit = (lambda t, z: texts.field(flight.mode, z, t)), EXACT
    if surfaces:
        field, limit = filippov(texts, flight.mode, surfaces[0]), BY_DIFFERENCES
        found = pushed_off(drawn, texts, flight, surfaces[0])
        if found:
            return found
    elif flight.resting:
        way = next(
            w for w in texts.modes[flight.mode]["exits"] if w.get("sticks") in flight.resting
        )
        field, limit = resting(texts, flight.mode, way), BY_DIFFERENCES
    try:
        end = _end(field, flight, 0.0)
        off = np.abs(flight.z[-1] - end).max()
        if off <= limit * size:
            return []
        other = _end(field, flight, GROWTH * size)
    except TooManyCalls:
        return []
    growth = max(1.0, np.abs(other - end).max() / (GROWTH * size))
    if not off <= limit * size * growth:
        return [
            f"off by {off:.3g} from the integrated motion ({flight.label}, growth {growth:.3g})"
        ]
    return []


def _end(field: Field, flight: Flight, shift: float) -> np.ndarray:
    calls = 0

    def counted(t: float, z: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        if calls > MOST_CALLS:
            raise TooManyCalls
        with np.errstate(all="ignore"):  # a trial step may lead far off
            return field(t, z)

    span = (flight.t[0], flight.t[-1])
    run = solve_ivp(counted, span, flight.z[0] + shift, method="DOP853", rtol=1e-11, atol=1e-12)
    return run.y[:, -1] if run.success else np.full(len(flight.z[0]), np.nan)


def _surfaces(drawn: Drawn, texts: Texts, flight: Flight, size: float) -> list[str]:
    """Switching functions that vanish all through a flight on surfaces."""
    signs = re.search(r"\[([-+0.]+)\]", flight.label)
    if signs and "0" not in signs.group(1):
        return []  # a function may be small all through a flight beside its surface
    found: list[str] = []
    for switch in drawn.switches:
        if switch.mode in (None, flight.mode):
            value = texts.value(switch.text, flight.z, flight.t)
            if switch.text not in found and vanishes(texts, flight, switch.text, value, size):
                found.append(switch.text)
    return found


def sides(texts: Texts, mode: str, surface: str, z: np.ndarray, t: float):
    """Fields on both sides of a surface, and the rates of the distance from it with them."""
    normal = texts.gradient(surface, z, t)
    size = max(float(np.linalg.norm(normal)), TINY)
    step = ASIDE * normal / size
    fields = [texts.field(mode, z + side * step, t) for side in (1, -1)]
    rates = [float(texts.along(surface, z, t, f)) / size for f in fields]
    return fields, rates


def filippov(texts: Texts, mode: str, surface: str) -> Field:
    """The combination of both sides that stays on the surface."""

    def field(t: float, z: np.ndarray) -> np.ndarray:
        (up, down), (to_up, to_down) = sides(texts, mode, surface, z, t)
        if abs(to_down - to_up) < 1e-12:
            return up
        u = (to_up + to_down) / (to_down - to_up)
        return (1 + u) / 2 * up + (1 - u) / 2 * down

    return field


def pushed_off(drawn: Drawn, texts: Texts, flight: Flight, surface: str) -> list[str]:
    """Whether |u| stays within 1, or within what the surface holds."""
    hold = 1.0
    for words in drawn.words.get("surfaces", {}).values():
        if words["function"] == surface:
            hold = float(words.get("hold", 1.0))
    for k in (0, len(flight.t) // 2, -1):
        _, (to_up, to_down) = sides(texts, flight.mode, surface, flight.z[k], flight.t[k])
        width = to_down - to_up
        if width <= 1e-6:
            continue
        u = (to_up + to_down) / width
        if abs(u) > hold + BY_DIFFERENCES * (1 + 1 / width):
            return [f"u = {u:.6g} of {surface} at t = {flight.t[k]:.6g} ({flight.label})"]
    return []


def resting(texts: Texts, mode: str, way) -> Field:
    """Motion with the guard of an exit at rest: a reaction along its jump keeps the rate."""

    def rate(z: np.ndarray, t: float) -> float:
        return float(texts.along(way["guard"], z, t, texts.field(mode, z, t)))

    def field(t: float, z: np.ndarray) -> np.ndarray:
        free = texts.field(mode, z, t)
        push = np.zeros(len(z))
        state = next(iter(way["reset"]))
        i = texts.states.index(state)
        moved = z.copy()
        moved[i] += 1e-4
        for name, text in way["reset"].items():
            j = texts.states.index(name)
            push[j] = float(moved[j] - texts.value(text, moved, t))
        h = 1e-4
        change = (rate(z + h * free, t + h) - rate(z - h * free, t - h)) / (2 * h)
        per_push = (rate(z + push, t) - rate(z - push, t)) / 2
        return free - change / per_push * push

    return field
