"""Sliders: how far each parameter may go, by what the system requires of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.errors import ModelError
from nonsmooth.system.system import System

__all__ = ["Slider", "label_and_unit", "sliders"]

_STEPS = 200  # of a slider
_HALVINGS = 14  # until an end of what is allowed is known far better than by a step


@dataclass(frozen=True)
class Slider:
    """One parameter: its range, and what stands beside it."""

    name: str
    value: float
    low: float
    high: float
    step: float
    label: str
    unit: str


def sliders(system: System, base: System | None = None) -> list[Slider]:
    """A slider for each parameter, from nothing to twice its value, as far as allowed.

    The value is that in ``base``, so that a slider keeps its range while it is moved. Parameters
    that follow a slow text have none, because a value has no effect on them.
    """
    found = []
    for name, value in system.parameter_values.items():
        if name in system.slow:
            continue
        middle = (base or system).parameter_values[name]
        low, high = (0.0, 2.0 * middle) if middle > 0.0 else (2.0 * middle, 0.0)
        if middle == 0.0:
            low, high = -1.0, 1.0
        low, high = min(low, value), max(high, value)
        low, high = (_allowed(system, name, value, end) for end in (low, high))
        if not low < high:
            continue
        step = _round_step((high - low) / _STEPS)
        # on the grid of steps, and not beyond what is allowed
        low, high = _on_grid(low, step, math.ceil), _on_grid(high, step, math.floor)
        low = low if _is_allowed(system, name, low) else _on_grid(low + step, step, round)
        high = high if _is_allowed(system, name, high) else _on_grid(high - step, step, round)
        label, unit = label_and_unit(system.describe.get(name, ""))
        found.append(Slider(name, value, min(low, value), max(high, value), step, label, unit))
    return found


def _allowed(system: System, name: str, value: float, end: float) -> float:
    """The value farthest towards an end that the system takes, by halving."""
    if _is_allowed(system, name, end):
        return end
    good, bad = value, end
    for _ in range(_HALVINGS):
        middle = 0.5 * (good + bad)
        if _is_allowed(system, name, middle):
            good = middle
        else:
            bad = middle
    return good


def _is_allowed(system: System, name: str, value: float) -> bool:
    try:
        system.with_parameters(**{name: value})
    except ModelError:
        return False
    return True


def _round_step(step: float) -> float:
    """A step of 1, 2 or 5 times a power of ten, not above the one given."""
    power = 10.0 ** math.floor(math.log10(step))
    return max(factor for factor in (1.0, 2.0, 5.0) if factor * power <= step * (1 + 1e-9)) * power


def _on_grid(value: float, step: float, rounded: object) -> float:
    """The nearest multiple of a step in one direction, without digits of rounding."""
    assert callable(rounded)
    near = round(value / step)
    count = near if abs(value / step - near) < 1e-6 else rounded(value / step)
    return float(f"{count * step:.12g}")


def label_and_unit(text: str) -> tuple[str, str]:
    """Label of a description such as ``"gap [mm]"``, and its unit."""
    label, bracket, unit = text.rpartition("[")
    if not bracket or not text.endswith("]"):
        return text, ""
    return label.strip(), unit[:-1].strip()
