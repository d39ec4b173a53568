"""Whether a motion that is looked for on a section rests, so that rounding alone crosses it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from nonsmooth.runs.clock import Instant
from nonsmooth.runs.outputs import StateRates

__all__ = ["Stillness", "looks_along", "terms_of_rates"]

Integers = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_STILL = 2.0**-40  # change of a state, beside its size, that is rounding of a motion at rest
_SHIFT = 1e-4  # relative change of a state that tells the size of the terms it stands in
_AT_REST = 128  # windows in which nothing changes, behind which nothing ever will
# parts of a search at which states are looked at: no cycle fits the ratios of the ways between
_LOOKS = np.array([0.17, 0.43, 0.71, 1.0])


class Stillness:
    """For how long a motion has stayed at one place, up to rounding.

    Rounding leads a motion at rest on a section from side to side of it, and these crossings are
    none. A motion goes round no cycle while each state stays within `_STILL` of its size, or of
    what the terms of its rate add up to in a window: a velocity at rest is of no size itself. What
    time drives may move later, so it is never ``watched``.
    """

    def __init__(self, n: int, *, watched: bool) -> None:
        self.watched = watched
        self.size = np.zeros(n)  # largest states so far
        self.low = self.high = np.full(n, np.nan)  # of the states since the motion is still
        self.windows = 0  # in which it was still

    def see(self, states: Floats, length: int, terms: Callable[[Floats], Floats]) -> None:
        """Take notice of a part of the motion by some of its states, (K, n).

        ``terms``: what the terms of the rate of each state add up to at a state, (n,) to (n,)
        """
        if not len(states):
            return
        low, high = states.min(axis=0), states.max(axis=0)
        self.size = np.maximum.reduce([self.size, np.abs(low), np.abs(high)])
        if not self.watched:
            return
        joined = np.fmin(self.low, low), np.fmax(self.high, high)
        if self._is_one_place(*joined, terms):
            (self.low, self.high), self.windows = joined, self.windows + length
        else:
            self.low, self.high = low, high
            self.windows = length if self._is_one_place(low, high, terms) else 0

    @property
    def now(self) -> bool:
        """Whether the motion has stayed at one place all along the last part."""
        return self.windows > 0

    @property
    def forever(self) -> bool:
        """Whether the motion has been still for so long that it rests."""
        return self.windows >= _AT_REST

    def _is_one_place(self, low: Floats, high: Floats, terms: Callable[[Floats], Floats]) -> bool:
        spread = high - low
        close = spread <= _STILL * self.size
        if np.all(close) or not np.any(close):
            return bool(close[0])
        return bool(np.all(close | (spread <= _STILL * terms(high))))


def terms_of_rates(
    rates: StateRates, here: Instant, mode: int, state: Floats, window: float
) -> Floats:
    """What the terms of the rate of each state add up to in a window, (n,); no cancellation."""
    n = state.size
    shifted = state * np.vstack([np.ones(n), 1.0 + _SHIFT * np.eye(n)])
    number, phase = np.full(n + 1, here.number), np.full(n + 1, here.phase)
    found = rates.of_many(number, phase, np.full(n + 1, mode), shifted)
    terms: Floats = window * np.abs(found[1:] - found[:1]).sum(axis=0) / _SHIFT
    return terms


def looks_along(begin: Instant, length: int, window: float) -> tuple[Integers, Floats]:
    """Some instants of a part, the last of them its end, at which states are looked at."""
    since = _LOOKS * length
    numbers = begin.number + np.floor(since).astype(np.int64)
    phases = begin.phase + (since - np.floor(since)) * window
    over = phases >= window
    return numbers + over, np.where(over, phases - window, phases)
