"""Pairs of states on both sides of a border of basins, and how they are brought together.

All starts of one level of the bisection run side by side, as those of a grid of basins do. With 32
of them a level leaves a 33rd of the distance, where halving would take five runs one after the
other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    UNSETTLED,
    AttractorSearch,
)
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.errors import OptionError
from nonsmooth.runs.whole_turns import whole_turns

__all__ = ["Advanced", "Pair", "Straddle"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_SHRINKS = 0.9  # of the distance; what leaves more of it has come to rounding, or to a gap
_TOLD = {
    UNSETTLED: "comes to no attractor",
    INADMISSIBLE: "is admitted by no mode",
}


class Pair(NamedTuple):
    """Two states whose motions come to different outcomes."""

    states: Floats  # (2, n)
    labels: Integers  # (2,), of their outcomes
    begins: Integers  # (2,): the mode in which each begins
    between: tuple[int, ...]  # modes to try for starts between them


class Advanced(NamedTuple):
    """Images of a pair."""

    states: Floats  # (2, count, n), nan where a motion has ended
    modes: Integers  # (2, count)
    widths: Floats  # (count,), infinite where there is no pair any more


class Straddle:
    """Brings pairs together, and lets them run."""

    def __init__(self, search: AttractorSearch, points: int, periods: Floats) -> None:
        self.search, self.points = search, points
        self.periods = periods  # of states that are angles, (n,)
        self.starts = 0  # that were settled
        self.levels = 0

    def begin(self, states: Floats, modes: tuple[tuple[int, ...], tuple[int, ...]]) -> Pair:
        """The pair of two starts; `OptionError` where they do not come to two outcomes.

        shapes: states (2, n)
        """
        labels, begins = np.zeros(2, np.int64), np.zeros(2, np.int64)
        for k, name in enumerate(("start_a", "start_b")):
            labels[k : k + 1], begins[k : k + 1] = self._settle(states[k : k + 1], modes[k])
            if int(labels[k]) in _TOLD:
                raise OptionError(
                    f"{name} {_TOLD[int(labels[k])]}; give a start in a basin, such as a point of"
                    " an attractor of ns.attractors, or raise longest="
                )
        if labels[0] == labels[1]:
            raise OptionError(
                f"start_a and start_b: both {self.outcome(int(labels[0]))}; give starts in two"
                " basins, such as points of two attractors of ns.attractors"
            )
        return Pair(states, labels, begins, modes[0] if modes[0] == modes[1] else (ANY,))

    def outcome(self, label: int) -> str:
        """What a motion does, in words."""
        if label == ENDED:
            return "end early"
        one = self.search.known.attractors[label - 1]
        return f"come to one attractor ({one.kind}, period {one.period})"

    def width(self, pair: Pair) -> float:
        """Distance of a pair, beside the spread of the states."""
        return float(self.widths(pair.states[:, None])[0])

    def widths(self, states: Floats) -> Floats:
        """Distances of pairs, infinite where one of them is missing; shapes: (2, K, n) to (K,)."""
        scaled = self.search.known.measure.scaled
        with np.errstate(invalid="ignore", over="ignore"):
            found = np.linalg.norm(scaled(states[1]) - scaled(states[0]), axis=1)
        return np.where(np.isfinite(found), found, np.inf)

    def bisect(
        self, pair: Pair, width: float, complete: Callable[[Floats], Floats] | None = None
    ) -> Pair:
        """The same border, straddled by a pair at most so far apart, or as near as they come.

        ``complete`` puts starts between the pair onto the section of the states that is meant.
        """
        while (here := self.width(pair)) > width:
            closer = self._between(pair, complete)
            self.levels += 1
            if not self.width(closer) < _SHRINKS * here:
                break
            pair = closer
        return pair

    def _between(self, pair: Pair, complete: Callable[[Floats], Floats] | None) -> Pair:
        """The pair of neighbours with different outcomes among starts along the segment.

        Where several are, the first one with the outcomes of both ends, or else the first.
        """
        a, b = pair.states
        parts = np.arange(1, self.points + 1) / (self.points + 1)
        states = a + parts[:, None] * (b - a)
        if complete is not None:
            states = complete(states)
        labels, begins = self._settle(states, pair.between)
        labels = np.concatenate([pair.labels[:1], labels, pair.labels[1:]])
        begins = np.concatenate([pair.begins[:1], begins, pair.begins[1:]])
        states = np.concatenate([pair.states[:1], states, pair.states[1:]])
        known = np.flatnonzero((labels > 0) | (labels == ENDED))
        before, after = known[:-1], known[1:]
        changes = np.flatnonzero(labels[before] != labels[after])
        of_ends = (labels[before] == pair.labels[0]) & (labels[after] == pair.labels[1])
        wanted = changes[of_ends[changes]]
        first = wanted[0] if wanted.size else changes[0]
        chosen = np.array([before[first], after[first]])
        return Pair(states[chosen], labels[chosen], begins[chosen], pair.between)

    def _settle(self, states: Floats, modes: tuple[int, ...]) -> tuple[Integers, Integers]:
        """Labels of starts, each in the first of the modes that admits it, and these modes."""
        labels = np.full(len(states), INADMISSIBLE, np.int64)
        begins = np.full(len(states), ANY, np.int64)
        left = np.arange(len(states))
        for mode in modes:
            self.starts += left.size
            labels[left], begins[left] = self.search.settle(states[left], mode).label, mode
            left = left[labels[left] == INADMISSIBLE]
            if not left.size:
                break
        return labels, begins

    def advance(self, pair: Pair, count: int) -> Advanced:
        """Let a pair run, so many iterates; of its images the first one is within one turn."""
        runner = self.search.runner
        states, modes = runner.iterate(runner.start(pair.states, pair.begins), count)
        states[1] -= whole_turns(states[1] - states[0], self.periods)
        return Advanced(states, modes, self.widths(states))

    @staticmethod
    def image(pair: Pair, run: Advanced, k: int) -> Pair:
        """The pair as it is after ``k + 1`` iterates."""
        modes = run.modes[:, k]
        between = (int(modes[0]), ANY) if modes[0] == modes[1] else (ANY,)
        return Pair(run.states[:, k], pair.labels, SAME - modes, between)
