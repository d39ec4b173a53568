"""Two windows of strobes in a row: what motions do within them, and from one to the other.

A motion that does not repeat is chaotic, comes back to where it was, or goes elsewhere. A neighbour
that approaches it tells nothing of that: next to one that creeps towards a point, or runs away,
others close in too. So two windows of its states are compared.

The 0-1 test takes strobes with the period taken off that they nearly have. Weak chaos often
visits a few narrow bands in turn. That is a strong periodic part with little chaos on it, and the
test would need a very long series to see it. The mean of every band taken off, what is left is
chaotic or not as before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from nonsmooth.analysis.passed_events import PassedEvents
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.periodicity import nearest_returns, scales, settled_periods
from nonsmooth.analysis.statistics.rest import floor_of, halves
from nonsmooth.analysis.zero_one_test import correlations_of
from nonsmooth.engine.extremes import state_maxima, state_minima, state_ranges
from nonsmooth.runs.sweep_runner import Recorded, SweepStarts, Times

__all__ = [
    "APART",
    "SHRINKING",
    "Growing",
    "StrobeTest",
    "Windows",
    "cyclic_word",
    "elsewhere",
    "no_closed_orbit",
    "rest_floor",
    "run_away",
    "shrinks",
    "shrunk",
    "strobe_test",
    "travels",
    "window_times",
]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_EPSILON = float(np.finfo(float).eps)
# parts of the last strobe interval at which motions are looked at once more: the states there tell
# how large they are, and whether they rest
_BETWEEN = np.array([0.25, 0.5, 0.75])
_OTHERS = np.arange(-1 - _BETWEEN.size, -1)  # places of those looks
APART = 0.05  # of its spread by which a state may differ between two windows of one closed curve
_MOST = 0.9  # of the later states lie that close to earlier ones; a cycle has fast parts too
SHRINKING = "the motion of every state shrinks from window to window"
_APART_FROM_NOISE = 3.0  # times what halves of a record differ by, and records differ
_HALF = 0.5  # of the spread of every state at most is left in the next window of a decay
_RUNAWAY = 10.0  # times the spread of the window before is no bounded motion
_PARTS = 4  # of both windows, in which a state grows by equal steps or larger ones
_EQUAL = 0.01  # of a step, to which those of a state that settles slowly are smaller
_STEADY = 1e-6  # of a step, to which a state moves on by the same amount each period
_LEAST_STEP = 1e-6  # of the size of a state: smaller ones tell nothing
_GROWN = 0.01  # of the spread of a state at least, by which growth leaves what was seen before
_ROUNDING = 1e-9  # of the largest state, whose rounding adds up in others
_FREQUENCIES = 25  # of the 0-1 test
_LONGEST = 50  # period that the 0-1 test takes off
_BEATS = 1.5  # times the distance of strobes a period apart is that of two periods, in a beat


def window_times(group: Group, record: int, first: int | Integers, chosen: Bools) -> Times:
    """Strobes of two windows of the chosen motions after so many ones, with the looks between."""
    numbers, phases = group.strobes(first, 2 * record + 1, chosen)
    more, inside = group.instants(phases[:, -2:-1] + _BETWEEN * group.lengths[:, None], chosen)
    between = numbers[:, -2:-1] + more
    return Times(
        np.concatenate([numbers[:, :-1], between, numbers[:, -1:]], axis=1),
        np.concatenate([phases[:, :-1], inside, phases[:, -1:]], axis=1),
    )


@dataclass(frozen=True)
class Windows:
    """Strobes of two windows of equal length, the last of one being the first of the other.

    M motions, K = 2 record + 1 strobes, n states.
    """

    points: Floats  # (M, K, n), angles within one turn
    travelled: Floats  # (M, K, n): the same with all whole turns
    modes: Integers  # (M, K)
    numbers: Integers  # (M, K): window of the clock, and phase in it
    phases: Floats  # (M, K)
    between: Floats  # (M, 3, n): states between the last two strobes
    modes_between: Integers  # (M, 3)
    low: Floats  # (M, n): least value of each state at strobes, at looks between and at events
    high: Floats  # (M, n): largest one
    events: PassedEvents

    @staticmethod
    def of(group: Group, recorded: Recorded) -> Windows:
        """Windows of motions that were recorded at the times of `window_times`."""
        kept = {
            name: np.delete(getattr(recorded, name), _OTHERS, axis=1)
            for name in ("states", "travelled", "modes", "numbers", "phases")
        }
        return Windows(
            kept["states"], kept["travelled"], kept["modes"], kept["numbers"], kept["phases"],
            recorded.states[:, _OTHERS], recorded.modes[:, _OTHERS], *_extremes(recorded),
            PassedEvents(group.system, recorded._replace(**kept)),
        )  # fmt: skip

    @property
    def record(self) -> int:
        """Strobe intervals of each window."""
        return (self.points.shape[1] - 1) // 2

    @cached_property
    def last(self) -> SweepStarts:
        """The last strobes of the motions, as points from where derivatives are taken."""
        return SweepStarts(
            self.points[:, -1], self.modes[:, -1], self.numbers[:, -1], self.phases[:, -1]
        )

    @cached_property
    def passes(self) -> Bools:
        """Whether events happen within the windows, (M,)."""
        first = np.zeros(len(self.points), np.int64)
        return self.events.counts(self.events.between(first, first + 2 * self.record))[0] > 0

    @property
    def ranges(self) -> Floats:
        """Range of each state over both windows, (M, n)."""
        return self.high - self.low

    def rests(self, i: int, drifting: Bools, sizes: Floats, match: float) -> bool:
        """Whether the states of motion i between strobes are those at strobes, but for drifts."""
        here = self.points[i, -1]
        away = np.abs(self.between[i] - here).max(axis=0)
        close = away <= match * np.maximum(np.abs(here), match * sizes)
        same_mode = np.all(self.modes_between[i] == self.modes[i, -1])
        return bool(np.all(close | drifting) and same_mode)

    def drifts_rest(self, i: int, drifting: Bools, first: Floats, match: float) -> bool:
        """Whether drifts have come to rest: hardly a step is left of the way since the start."""
        here, before = self.points[i, -1], self.points[i, -2]
        way = np.abs(here - first) * match
        step = np.maximum(np.abs(self.between[i] - here).max(axis=0), np.abs(here - before))
        return bool(np.all((step <= way + 16.0 * _EPSILON * np.abs(here))[drifting]))

    def sunk(self, drifting: Bools, sizes: Floats, match: float, *, driven: bool) -> Bools:
        """Which motions have died away, events included: to ``match`` squared of their sizes.

        Events go on for ever where a motion comes to rest on a surface. A force may switch modes
        although no state moves, so all states of a driven motion must have died away to zero.

        sizes: (M, n) since the start
        """
        left = np.maximum(np.abs(self.low), np.abs(self.high)) if driven else self.ranges
        away = np.all((left <= match * match * sizes) | drifting, axis=1)
        return np.asarray(away & np.any((sizes > 0.0) & ~drifting, axis=1))

    def shrink(self, drifting: Bools, sizes: Floats, match: float) -> Bools:
        """Which motions have lost half of the spread of every state in a window, or more, (M,).

        States that rest do not count, unless all do.
        """
        floor = rest_floor(self.points, sizes, match)
        moves = np.any((state_ranges(self.points) > floor) & ~drifting, axis=1)
        return np.asarray(np.all(halves(self.points, floor) | drifting, axis=1) & moves)

    def returns(
        self, motions: Integers, drifting: Bools, sizes: Floats, match: float
    ) -> tuple[Integers, Floats]:
        """Period and residual of both windows of some motions, (m, 2) each.

        ``sizes``, (m, n), are the natural ones of the states: what has died away to ``match`` times
        ``match`` of them is at rest.
        """
        points, record = self.points[motions], self.record
        floor = self._floors(motions, drifting, sizes, match)
        both = np.stack([points[:, : record + 1], points[:, record:]], axis=1)
        scale = np.maximum(scales(both, drifting), floor[:, None])
        flat = both.reshape(-1, *both.shape[2:])
        scales_of_all = scale.reshape(len(flat), -1)
        periods, residuals = nearest_returns(flat, drifting, scales_of_all, match)
        return periods.reshape(-1, 2), residuals.reshape(-1, 2)

    def on_the_way(self, motions: Integers, drifting: Bools, sizes: Floats, match: float) -> Bools:
        """Which of some motions that repeat may yet settle to a shorter period, (m,)."""
        points = self.points[motions]
        floor = self._floors(motions, drifting, sizes, match)
        scale = np.maximum(scales(points, drifting), floor)
        return np.asarray(settled_periods(points, drifting, match, scale, sizes) == 0)

    def _floors(self, motions: Integers, drifting: Bools, sizes: Floats, match: float) -> Floats:
        """Least scale of each state, (m, n): what is smaller is rounding, or at rest."""
        points = self.points[motions]
        rounding = 4.0 * _EPSILON / match * state_maxima(np.abs(points))
        return np.where(drifting, rounding, floor_of(sizes, match))


def _extremes(recorded: Recorded) -> tuple[Floats, Floats]:
    """Least and largest value of each state of each motion over all that was recorded, (M, n)."""
    low, high = state_minima(recorded.states), state_maxima(recorded.states)
    motion = np.repeat(np.arange(len(low)), np.diff(recorded.logs))
    np.minimum.at(low, motion, state_minima(recorded.event_states))
    np.maximum.at(high, motion, state_maxima(recorded.event_states))
    return low, high


def cyclic_word(word: str) -> tuple[str, ...]:
    """Modes of a period that begins anywhere: the first of its rotations in alphabetical order.

    A strobe may lie on an event, or be moved across one by a parameter; the motion is the same.
    """
    modes = tuple(word.split())
    if len(modes) > 1 and modes[0] == modes[-1]:
        modes = modes[:-1]
    return min((modes[k:] + modes[:k] for k in range(len(modes))), default=modes)


def elsewhere(earlier: Floats, later: Floats, floor: Floats) -> npt.NDArray[np.bool_]:
    """Which states take other values in the later window: their range, or the time in its parts.

    The values of each window are sorted and compared one by one, from the smallest to the largest;
    the mean difference counts beside the spread of both windows. A short spike, which samples may
    miss, counts for no more than it lasts.

    shapes: earlier and later (..., K, n); floor (..., n): a spread below it is none
    """
    size = state_ranges(np.concatenate([earlier, later], axis=-2))
    away = np.abs(np.sort(later, axis=-2) - np.sort(earlier, axis=-2)).mean(axis=-2)
    return np.asarray(away > APART * np.maximum(size, floor))


def rest_floor(states: Floats, sizes: Floats, match: float) -> Floats:
    """Spread of each state below which it rests, or is rounding, (..., n).

    shapes: states (..., K, n), sizes (..., n): natural ones
    """
    rounding = 4.0 * _EPSILON / match * state_maxima(np.abs(states))
    return np.maximum(match * floor_of(sizes, match), rounding)


def no_closed_orbit(
    earlier: Floats, later: Floats, names: tuple[str, ...], sizes: Floats, turns: bool, match: float
) -> str:
    """Why two windows show no closed orbit, "" where they do.

    One state alone goes one way for ever unless events turn it back or it is an angle.

    shapes: earlier and later (K, n), drifting states left out; natural sizes (n,) of the states;
    turns: whether events happen, or a state is an angle
    """
    if len(names) < 2 and not turns:
        return (
            "one state that no event turns back has no cycle: it comes to rest slowly, grows or"
            " travels"
        )
    both = np.concatenate([earlier, later])
    floor = rest_floor(both, sizes, match)
    if shrinks(earlier, later, floor):
        return SHRINKING
    changed = elsewhere(earlier, later, floor)
    if np.any(changed):
        which = ", ".join(name for name, is_one in zip(names, changed, strict=True) if is_one)
        return (
            f"the range of {which} still changes from window to window: a motion that comes to"
            " rest slowly, grows or travels, or a window shorter than some cycles"
        )
    spread = np.ptp(both, axis=0)
    if np.all(spread <= floor):
        return "nothing moves any more"
    scale = np.maximum(spread, floor)
    distances, _ = KDTree(earlier / scale).query(later / scale, p=np.inf)
    if np.quantile(distances, _MOST) > APART:
        return "the later states do not lie on the curve of the earlier ones"
    return ""


def shrinks(earlier: Floats, later: Floats, floor: Floats) -> Bools:
    """Whether two windows show motions that die away.

    All states spread less: by half or more, however short the decay was beside the window, or by
    as much as tells one set of values from another, whose values differ by as much too. A torus or
    a cycle of which a window shows a part has some states that spread more, or hardly less.

    shapes: earlier and later (..., K, n); floor (..., n): a spread below it is none; returns (...)
    """
    before, now = state_ranges(earlier), state_ranges(later)
    moves = before > floor
    smaller = elsewhere(earlier, later, floor) & (now < (1.0 - APART) * before)
    less = (now <= _HALF * before) | smaller
    shrinking = np.where(moves, less, now <= floor)
    return np.asarray(np.any(moves, axis=-1) & np.all(shrinking, axis=-1))


def shrunk(before: Floats, now: Floats, floor: Floats) -> Bools | None:
    """Which states moved, of which all move less than long before; None where they do not.

    Their root mean squares about the mean are less by more than those of the halves of either
    record differ, as those of a part of a beat do.

    shapes: before and now (K, n), floor (n,): a spread below it is none
    """
    moves = np.ptp(before, axis=0) > floor
    parts = [part for each in (before, now) for part in np.array_split(each[:, moves], 2)]
    sizes = [part.std(axis=0) for part in parts]
    noise = np.maximum(np.abs(sizes[1] - sizes[0]), np.abs(sizes[3] - sizes[2]))
    less = before[:, moves].std(axis=0) - now[:, moves].std(axis=0)
    return moves if np.any(moves) and np.all(less > _APART_FROM_NOISE * noise) else None


def run_away(earlier: Floats, later: Floats, before: tuple[Floats, Floats], floor: Floats) -> Bools:
    """Whether two windows, (..., K, n) each, show motions that grow tenfold, without bound.

    A burst of a size that was seen before is none.

    before: least and largest values, (..., n) each, of all windows before these
    floor: (..., n), a spread below it is none
    """
    low, high = before
    more = state_ranges(later) > _RUNAWAY * np.maximum(state_ranges(earlier), floor)
    beyond = (state_maxima(later) > high) | (state_minima(later) < low)
    return np.asarray(np.any(more & beyond, axis=-1))


def travels(
    earlier: Floats, later: Floats, names: tuple[str, ...], before: tuple[Floats, Floats]
) -> str:
    """Which states left the range that they had in the window before, "" where none did.

    One that only comes back to where it was in ``before``, as in `run_away`, does not travel.
    """
    low, high = before
    left = later.min(axis=0) > np.maximum(earlier.max(axis=0), high)
    left |= later.max(axis=0) < np.minimum(earlier.min(axis=0), low)
    if not np.any(left):
        return ""
    which = ", ".join(name for name, is_one in zip(names, left, strict=True) if is_one)
    return f"{which} travels: it has left its range of the window before (drift= declares a drift)"


class Growing(NamedTuple):
    """Which states of M motions grow by equal steps or larger ones from part to part; n states.

    What settles grows by smaller and smaller steps, and what is bounded turns back. The parts of a
    beat grow too, by little where each has seen nearly all of it, or for as long as it lasts. So
    growth is without bound, as far as one can see, where it leaves all that was seen before by as
    much again. Where nothing was, it is said to grow, and no more.
    """

    states: Bools  # (M, n)
    steadily: Bools  # (M, n): by the same amount in each period
    is_first: Bools  # (M,): nothing was seen before

    @staticmethod
    def of(strobes: Floats, moving: Bools, sizes: Floats, before: tuple[Floats, Floats]) -> Growing:
        """Growing states of those that are ``moving``; of ``before`` as in `run_away`.

        shapes: strobes (M, K, n), moving (M, n), natural sizes (M, n) of the states
        """
        parts = np.array_split(strobes, _PARTS, axis=1)
        high = np.stack([state_maxima(part) for part in parts], axis=1)
        low = np.stack([state_minima(part) for part in parts], axis=1)
        edges = np.stack([high, -low])  # (2, M, parts, n)
        steps = np.diff(edges, axis=2)
        first = steps[:, :, 0]
        most = np.where(moving, sizes, 0.0).max(axis=1, initial=0.0)
        smallest = np.maximum(_LEAST_STEP * sizes, _ROUNDING * most[:, None])
        higher = (steps > smallest[:, None]) & (steps >= (1.0 - _EQUAL) * first[:, :, None])
        known = np.stack([before[1], -before[0]])
        is_first = ~np.all(np.isfinite(known), axis=(0, 2))
        away = np.where(is_first[:, None], steps.sum(axis=2), edges[:, :, 0] - known)
        enough = np.maximum((1.0 - _EQUAL) * first, _GROWN * state_ranges(strobes))
        growing = np.any(np.all(higher, axis=2) & (away >= enough), axis=0) & moving
        steadily = np.zeros_like(growing)
        which = np.flatnonzero(np.any(growing, axis=1))
        each = np.diff(strobes[which], axis=1)
        same = state_ranges(each) <= _STEADY * state_maxima(np.abs(each))
        steadily[which] = growing[which] & same
        return Growing(growing, steadily, is_first)

    def told(self, i: int, names: Sequence[str]) -> str:
        """Which states of motion i grow, in words, "" where none does."""
        growing = [name for name, does in zip(names, self.states[i], strict=True) if does]
        if not growing:
            return ""
        verb = "grow" if len(growing) > 1 else "grows"
        as_what = "as a long beat may do: a larger longest= tells"
        if not self.is_first[i]:
            as_what = "without bound so far"
        return f"{', '.join(growing)} {verb} from window to window, {as_what}" + "".join(
            f"; {name} moves on by the same amount each period: drift= declares it, if it stands in"
            " no equation"
            for name, does in zip(names, self.steadily[i], strict=True)
            if does
        )


class StrobeTest(NamedTuple):
    """K of a series, nan where not asked for; how near it comes to repeating, in its scatter."""

    k: float
    nearest: float


def strobe_test(values: Floats, *, asked: bool, beats: bool) -> StrobeTest:
    """Test of one series without its strongest period; K is left open where it is not asked for.

    A torus near a resonance drifts through its near period: after two of them it is twice as far
    away as after one. What is left without that period is a beat longer than the series, and K of
    it is one, as of a random walk. With ``beats`` such a period is not taken off. Where the motion
    is chaotic, it may be that of bands in which strobes forget slowly, and is.
    """
    longest = min(_LONGEST, values.size // 4)
    distance = _distances(values, 2 * longest)
    p = 1 + int(np.argmin(distance[:longest]))
    nearest = float(distance[p - 1])
    if not asked:
        return StrobeTest(np.nan, nearest)
    if beats and distance[2 * p - 1] > _BEATS * nearest:
        p = 1
    rest = values - values.mean()
    for k in range(p):
        rest[k::p] -= rest[k::p].mean()
    k_of_rest = float(np.median(correlations_of(rest, _FREQUENCIES, 0)[1]))
    return StrobeTest(k_of_rest, nearest)


def _distances(values: Floats, longest: int) -> Floats:
    """How far values are from those 1, 2, ... before: root mean squares, in their scatter."""
    squares = [float(np.square(values[p:] - values[:-p]).mean()) for p in range(1, longest + 1)]
    scatter = 2.0 * float(values.var())
    return np.sqrt(np.array(squares) / scatter) if scatter > 0.0 else np.zeros(longest)
