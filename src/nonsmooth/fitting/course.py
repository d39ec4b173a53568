"""How far a fit has come, on the progress bar of a terminal.

A fit has phases: its starts, the intervals, the bootstrap, and where it has failed, trials of other
units. How many motions each of them takes is not known before, so the bar moves with each motion,
more and more slowly until the phase has ended.
"""

from __future__ import annotations

import math

from nonsmooth.progress import Progress

__all__ = ["Course"]

_USUAL = 100.0  # motions through a record that a phase takes: some take a tenth, and some ten times


class Course:
    """Moves a bar whose total is the number of phases."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar
        self._done, self._motions = 0, 0.0

    def move(self, part: float) -> None:
        """Say that a part of a motion through a record has been computed."""
        self._motions += part
        self._bar.update(self._done - math.expm1(-self._motions / _USUAL))

    def end_phase(self) -> None:
        """Say that a phase has ended."""
        self._done, self._motions = self._done + 1, 0.0
        self._bar.update(self._done)
