"""Names of states for coordinates of a structure, whose names may be anything, and their sums."""

from __future__ import annotations

import re
from collections.abc import Iterable

from nonsmooth.system.text.grammar import is_name

__all__ = ["state_name", "velocity_name", "weighted_sum"]

_NODE = re.compile(r"(?:node\s*)?(\d+)\s*(r?[xyz])")


def state_name(coordinate: str) -> str:
    """Name of the displacement as texts have it: ``3x`` and ``node 3 x`` are ``x3``."""
    found = _NODE.fullmatch(coordinate)
    if found:
        return f"{found[2]}{found[1]}"
    name = re.sub(r"\W+", "_", coordinate.strip(), flags=re.ASCII)
    return name if is_name(name) else f"q_{name}"


def velocity_name(coordinate: str) -> str:
    """Name of its velocity."""
    return f"v{state_name(coordinate)}"


def weighted_sum(terms: Iterable[tuple[float, str]]) -> str:
    """Text of a sum; terms with a factor zero are left out."""
    text = ""
    for factor, name in terms:
        if factor == 0.0:
            continue
        size = name if abs(factor) == 1.0 else f"{abs(float(factor))!r}*{name}"
        if text:
            text += f" - {size}" if factor < 0.0 else f" + {size}"
        else:
            text = f"-{size}" if factor < 0.0 else size
    return text
