"""Phase words of cycles: the modes of one turn."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nonsmooth.analysis.basins.attractor import Attractor

__all__ = ["with_words"]


def with_words(chosen: Any, attractors: list[Attractor], tolerance: float) -> list[Attractor]:
    """Attractors of a map, cycles with their words."""
    runner = chosen.runner(tolerance)

    def word(one: Attractor) -> str:
        if not one.is_cycle:
            return ""
        return str(runner.word(one.points[0], int(one.modes[0]), one.period))

    return [replace(one, word=word(one)) for one in attractors]
