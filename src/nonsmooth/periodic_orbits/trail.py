"""Where a branch of orbits has been, so that it is not followed back along itself."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.periodic_orbits.word import Word

__all__ = ["Trail"]

Floats = npt.NDArray[np.float64]

_CONE = 0.3  # angle at the ends of a step between the curve and its chord: it turns by half of it
_AGAINST = 2.0  # angle between two directions from which on one is against the other
_ROUNDING = 1e-10  # scaled distance that is none


class _Step(NamedTuple):
    begin: Floats
    end: Floats
    scale: Floats  # of the unknowns and, last, of the parameter
    length: float  # scaled


class Trail:
    """The steps of a branch, by the words of its orbits."""

    def __init__(self) -> None:
        self._steps: dict[Word, list[_Step]] = {}
        self._last: tuple[Word, Floats] | None = None

    @property
    def words(self) -> tuple[Word, ...]:
        """Words along which steps were taken."""
        return tuple(self._steps)

    def begin(self) -> None:
        """A stretch begins: no step leads to its first point, which may begin at another event."""
        self._last = None

    def add(self, word: Word, point: Point, scale: Floats, width: float) -> None:
        """A point of the branch behind those before; steps join points of one word."""
        there = np.append(point.u, point.p)
        if self._last is not None and self._last[0] == word:
            sizes = np.append(scale, width)
            length = float(np.linalg.norm((there - self._last[1]) / sizes))
            step = _Step(self._last[1], there, sizes, length)
            self._steps.setdefault(word, []).append(step)
        self._last = word, there

    def way(self, word: Word) -> float:
        """Sign of the change of the parameter along the last steps of a word; 0 if there is none.

        A few steps back, where it is more than rounding.
        """
        steps = self._steps.get(word, [])
        for step in reversed(steps):
            change = float(steps[-1].end[-1] - step.begin[-1])
            if abs(change) > _ROUNDING * step.scale[-1]:
                return float(np.sign(change))
        return 0.0

    def passes(self, word: Word, value: float, near: float) -> bool:
        """Whether a step of a word comes as near as this to a value of the parameter."""
        ends = ((step.begin[-1], step.end[-1]) for step in self._steps.get(word, []))
        return any(min(pair) - near <= value <= max(pair) + near for pair in ends)

    def leads_back(self, word: Word, points: list[Point]) -> bool:
        """Whether new points of a word lead along a step that was taken, against its direction."""
        there = [np.append(point.u, point.p) for point in points]
        return any(
            _is_against(step, last - first) and (_is_within(step, first) or _is_within(step, last))
            for first, last in pairwise(there)
            for step in self._steps.get(word, [])
            if _is_beside(step, first) or _is_beside(step, last)
        )


def _is_beside(step: _Step, there: Floats) -> bool:
    """Whether a value of the parameter is about one of those of a step: the rest takes longer."""
    before, after, p = float(step.begin[-1]), float(step.end[-1]), float(there[-1])
    near = (_CONE * step.length + _ROUNDING) * float(step.scale[-1])
    return min(before, after) - near <= p <= max(before, after) + near


def _is_within(step: _Step, there: Floats) -> bool:
    """Whether a point is on the way from one end of a step to the other."""
    chord, away = (step.end - step.begin) / step.scale, (there - step.begin) / step.scale
    length = float(chord @ chord)
    part = float(chord @ away) / length if length > 0.0 else -1.0
    if not 0.0 <= part <= 1.0:
        return False
    apart = float(np.linalg.norm(away - part * chord))
    return apart <= _CONE * min(part, 1.0 - part) * np.sqrt(length) + _ROUNDING


def _is_against(step: _Step, ahead: Floats) -> bool:
    """Whether a direction is the opposite of that of a step."""
    chord, ahead = (step.end - step.begin) / step.scale, ahead / step.scale
    size = float(np.linalg.norm(chord) * np.linalg.norm(ahead))
    return size > 0.0 and float(chord @ ahead) <= np.cos(_AGAINST) * size
