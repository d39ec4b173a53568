"""Verdicts over two parameters with a number for each label, by which borders are refined."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.border_refinement import UNKNOWN
from nonsmooth.analysis.regimes.labels import REPEATING, Verdict
from nonsmooth.analysis.regimes.window import cyclic_word

__all__ = ["LabelGrid"]

Places = npt.NDArray[np.int64]


class LabelGrid:
    """Verdicts; places are (number of the second parameter, number of the first).

    Neighbours with equal ``keys`` have the same label. Keys are numbers of this grid alone.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.verdicts: npt.NDArray[np.object_] = np.full(shape, None, object)
        self.keys = np.full(shape, UNKNOWN, np.int64)
        self._known: dict[tuple[Any, ...], int] = {}

    def number(self, places: Places) -> None:
        """Give places the numbers of their labels; in order, so that these depend on it alone."""
        for row, column in places:
            verdict = self.verdicts[row, column]
            if verdict is not None:
                label = _label(verdict)
                self.keys[row, column] = self._known.setdefault(label, len(self._known) + 1)

    def fill(self, places: Places) -> None:
        """Give places the label that has been found all around them, and no evidence."""
        examples: dict[tuple[Any, ...], Verdict] = {}
        for verdict in self.verdicts.ravel():
            if verdict is not None:
                examples.setdefault(_label(verdict), verdict)
        shared = {
            self._known[label]: Verdict(
                like.label,
                "",
                0,
                np.nan,
                np.full_like(like.drift, np.nan),
                like.period,
                like.word,
                progresses=like.progresses,
            )
            for label, like in examples.items()
        }
        for row, column in places:
            self.verdicts[row, column] = shared[int(self.keys[row, column])]


def _label(verdict: Verdict) -> tuple[Any, ...]:
    """What neighbours have in common."""
    if verdict.label not in REPEATING:
        return (verdict.label,)
    count = round(verdict.impacts * verdict.period)
    word = cyclic_word(verdict.word)
    return verdict.label, verdict.period, word, count, verdict.progresses
