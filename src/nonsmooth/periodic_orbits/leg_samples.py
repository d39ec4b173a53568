"""Samples along the legs of an orbit, as dense as straight lines between them need.

What is between two samples is compared with the straight line there, at two places that no
oscillation can have in common with the samples. Where it is farther off than a line is wide in a
picture, the stretch is cut in parts, each of which is looked at again. So there are many samples
while a leg oscillates or hurries, and few behind that.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.word import Word

__all__ = ["LegSamples", "evenly", "refined"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_OFF = 1e-3  # of the range of a variable, by which a straight line may be off: 50 in an oscillation
_LOOKS = 0.5 * (3.0 - np.sqrt(5.0)), 0.5 * np.sqrt(2.0)  # parts of a stretch, in no ratio
# samples, unless there are more to begin with: a curve of a picture is thinned above
_MOST = 20_000
_PARTS = 8  # of a stretch that is cut: its oscillations may be hidden, so their number is unknown
_ROUNDING = 1e-12  # of the largest value of all: a variable that varies less is at rest
_INSTANT = 1e-13  # of the times: a stretch so short is not cut


class LegSamples(NamedTuple):
    """States in order of time; each leg has samples at both of its ends."""

    leg: Integers  # (N,)
    part: Floats  # (N,): time since the leg began, by its duration
    times: Floats  # (N,)
    states: Floats  # (N, n)

    def between(self, stretch: Integers, part: Floats, turn: Turn) -> tuple[Integers, Floats]:
        """Legs and parts of them, at a part of the way from some samples to the next ones."""
        begin, end = self.part[stretch], self.part[stretch + 1]
        return self.leg[stretch], begin + part * (end - begin)


_Values = Callable[[LegSamples], Floats]  # (N, m): variables that are drawn


def evenly(legs: Legs, word: Word, turn: Turn, counts: Integers) -> LegSamples:
    """Samples at equal distances, with so many intervals in each leg."""
    leg = np.repeat(np.arange(len(word)), counts + 1)
    part = np.concatenate([np.linspace(0.0, 1.0, count + 1) for count in counts])
    return _sampled(legs, word, turn, leg, part, turn.states[leg], turn.instants[leg])


def refined(
    legs: Legs, word: Word, turn: Turn, samples: LegSamples, values_of: _Values
) -> tuple[LegSamples, float]:
    """The same with more samples where straight lines between them are off.

    And how far off they still are, by the range of a variable, where there is no room for more.
    """
    most = max(_MOST, samples.leg.size)
    stretch = np.flatnonzero(np.diff(samples.leg) == 0)
    values = values_of(samples)
    while True:
        off = _off(legs, word, turn, samples, values, stretch, values_of)
        lasts = np.diff(samples.times)[stretch] > _INSTANT * np.abs(samples.times[stretch])
        far = (off > _OFF) & lasts
        if not np.any(far):
            return samples, 0.0
        chosen, off = stretch[far], off[far]
        room = (most - samples.leg.size) // chosen.size
        if room < 1:
            return samples, float(off.max())
        # what a straight line is off falls with the square of its length, once it is short
        parts = np.clip(np.ceil(np.sqrt(off / _OFF)), 2, min(_PARTS, room + 1)).astype(np.int64)
        new = _cut(legs, word, turn, samples, chosen, parts)
        at = np.repeat(chosen + 1, parts - 1)
        values = np.insert(values, at, values_of(new), axis=0)
        samples = LegSamples(
            *(np.insert(old, at, more, axis=0) for old, more in zip(samples, new, strict=True))
        )
        first = chosen + np.cumsum(parts - 1) - (parts - 1)
        stretch = np.repeat(first, parts) + _count_up(parts)


def _off(
    legs: Legs, word: Word, turn: Turn, samples: LegSamples, values: Floats, stretch: Integers,
    values_of: _Values,
) -> Floats:  # fmt: skip
    """How far off the straight lines over some stretches are, by the range of each variable."""
    finite = np.where(np.isfinite(values), values, np.nan)
    with np.errstate(invalid="ignore"):
        largest = np.nanmax(np.abs(finite), initial=0.0)
        sizes = np.fmax.reduce(finite, axis=0) - np.fmin.reduce(finite, axis=0)
    sizes = np.where(sizes > _ROUNDING * largest, sizes, np.inf)
    worst = np.zeros(stretch.size)
    for part in _LOOKS:
        leg, place = samples.between(stretch, part, turn)
        there = _sampled(
            legs, word, turn, leg, place, samples.states[stretch], samples.times[stretch]
        )
        straight = values[stretch] + part * (values[stretch + 1] - values[stretch])
        away = np.abs(values_of(there) - straight) / sizes
        worst = np.fmax(worst, np.fmax.reduce(away, axis=1, initial=0.0))
    return np.where(np.isfinite(worst), worst, 0.0)


def _cut(
    legs: Legs, word: Word, turn: Turn, samples: LegSamples, chosen: Integers, parts: Integers
) -> LegSamples:
    """Samples within some stretches that cut each of them into so many parts."""
    before = np.repeat(chosen, parts - 1)
    part = (_count_up(parts - 1) + 1.0) / np.repeat(parts, parts - 1)
    leg, place = samples.between(before, part, turn)
    return _sampled(legs, word, turn, leg, place, samples.states[before], samples.times[before])


def _sampled(
    legs: Legs, word: Word, turn: Turn, leg: Integers, part: Floats, states: Floats, begins: Floats
) -> LegSamples:
    """Samples at parts of legs, each followed from a state before it in the same leg."""
    times = turn.instants[leg] + part * turn.durations[leg]
    modes = word.mode_array[leg]
    alone = Word(tuple(modes.tolist()), ((),) * modes.size)
    return LegSamples(leg, part, times, legs.follow_each(alone, states, begins, times).ends.copy())


def _count_up(counts: Integers) -> Integers:
    """0, 1, ... so many times each, one after the other."""
    return np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
