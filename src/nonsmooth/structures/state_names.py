"""Names of states for coordinates of a structure, whose names may be anything."""

from __future__ import annotations

import re

from nonsmooth.system.text.grammar import is_name

__all__ = ["state_name", "velocity_name"]

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
