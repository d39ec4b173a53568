"""What happens to an orbit where a test of its word vanishes, in words."""

from __future__ import annotations

from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.system import System

__all__ = ["in_words"]

_TOUCHES = {
    "graze": "touches {}",
    "rate": "comes with zero speed to {}",
    "corner": "reaches {} just as it ends",
    "border": "comes to lie on {}",
    "over": "is thrown as far as {} by the impact that ends it",
}


def in_words(system: System, word: Word, name: str) -> str:
    """What the test of a name tells of a leg; names are those of `branch_tests`."""
    kind, *numbers = name.split(":")
    k = len(word) - 1 if numbers == ["last"] else int(numbers[0]) if numbers else 0
    mode = word.modes[k]
    leg = f"leg {k} ({system.mode_names[mode]})"
    if kind in _TOUCHES:
        e = word.paths[k][0] if kind == "rate" else int(numbers[1])
        return f"{leg} {_TOUCHES[kind].format(system.structure.running[mode].exit_in_words(e))}"
    return {
        "short": f"{leg} vanishes",
        "leg": f"{leg} vanishes",
        "gain": f"a leg appears behind {leg}",
        "slide": f"both sides of a surface behind {leg} point at it",
        "enter": f"the surface behind {leg} does not hold the motion",
        "rest": f"rebounds up to {leg} no longer end before the release",
        "shrink": "the cycle touches the plane on which it begins",
    }.get(kind, "the motion changes")
