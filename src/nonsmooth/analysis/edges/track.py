"""Follows the border of two basins, and tells what the motion on it comes to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor, inside_circle
from nonsmooth.analysis.basins.attractor_search import cycle_from
from nonsmooth.analysis.basins.folded_runner import within_turns
from nonsmooth.analysis.edges.straddle import Pair, Straddle
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.analysis.statistics.periodicity import primitive_period
from nonsmooth.engine.lanes import ANY

__all__ = ["Edge", "Spans", "Track", "follow_edge"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_BLOCK = 16  # iterates between two looks at how far a pair has come apart
_LOOK = 512  # iterates among which a period is looked for
_REPEATS = 10.0  # times the width at which pairs are brought together: points that repeat
_NEAR = 1000.0  # times that width: how far the orbit may lie from the track that leads to it
_FEWEST = 64  # iterates of a track that tells chaos
_TURNING = 10  # iterates in which directions turn to the fastest
_STANDARD_ERRORS = 3.0
_NEUTRAL = 3.0  # logarithm of the growth over the track that may come from a torus as well
_EXPONENTS = 2


@dataclass(frozen=True)
class Spans:
    """How far pairs are brought together and let apart, and how long they are followed."""

    narrow: float
    wide: float
    iterates: int


@dataclass
class Track:
    """One side of the pairs, iterate by iterate; the border is at most the width away from it."""

    states: list[Floats] = field(default_factory=list)  # (n,)
    modes: list[int] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)

    def add(self, state: Floats, mode: int, width: float) -> None:
        """Another iterate."""
        self.states.append(state)
        self.modes.append(mode)
        self.widths.append(width)

    @property
    def points(self) -> Floats:
        """States as an array, (K, n)."""
        return np.array(self.states)


@dataclass(frozen=True)
class Edge:
    """What the motion on a border comes to."""

    kind: str  # periodic, chaotic, quasi-periodic, aperiodic or unresolved
    track: Track
    first: Pair  # where the segment crosses the border
    last: Pair
    cycle: Attractor | None  # the saddle
    period: int  # with which the track repeats, 0 where it does not
    exponents: Floats  # (2,) per iterate, of what is no cycle
    errors: Floats  # (2,)
    ended: bool  # whether pairs came to an end in less than one iterate
    complete: bool


class Follower:
    """Follows one border."""

    def __init__(self, straddle: Straddle, spans: Spans, drifting: npt.NDArray[np.bool_]) -> None:
        self.straddle, self.spans, self.drifting = straddle, spans, drifting
        self.track = Track()
        self.period, self.ended = 0, False
        self._tested = 0

    def follow(self, pair: Pair, tell: Callable[[int], None]) -> tuple[Pair, Attractor | None]:
        """Run a pair on from border to border, until an orbit is found or the longest time over."""
        straddle, spans, track = self.straddle, self.spans, self.track
        begins = int(pair.begins[0])
        mode = begins if begins >= 0 else ANY
        while len(track.states) < spans.iterates:
            width = straddle.width(pair)
            if width > spans.wide:
                pair = straddle.bisect(pair, spans.narrow)
                width = straddle.width(pair)
            track.add(within_turns(straddle.search.runner, pair.states[0]), mode, width)
            found = self._orbit()
            if found is not None:
                return pair, found
            run = straddle.advance(pair, min(_BLOCK, spans.iterates - len(track.states) + 1))
            far = np.flatnonzero(run.widths > spans.wide)
            last = int(far[0]) if far.size else run.widths.size - 1
            if not np.isfinite(run.widths[last]):
                last -= 1
            if last < 0:
                self.ended = True
                break
            for k in range(last):
                track.add(run.states[0, k], int(run.modes[0, k]), float(run.widths[k]))
            pair, mode = straddle.image(pair, run, last), int(run.modes[0, last])
            tell(len(track.states))
        return pair, None

    def _orbit(self) -> Attractor | None:
        """The saddle to which the track has come, looked for each time it is longer by half."""
        count = len(self.track.states)
        if count < self._tested + max(4, self._tested // 2):
            return None
        self._tested = count
        return self.saddle()

    def saddle(self) -> Attractor | None:
        """The saddle that the end of the track repeats, with one multiplier outside the circle."""
        measure, spans = self.straddle.search.known.measure, self.spans
        points = self.track.points
        last = points[len(points) // 2 :][-_LOOK:]  # the rest may belong to the way there
        self.period = primitive_period(last, self.drifting, measure.scale, _REPEATS * spans.wide)
        if not self.period:
            return None
        found = cycle_from(
            self.straddle.search.runner, measure, points[-1], self.track.modes[-1], self.period,
            self.drifting,
        )  # fmt: skip
        if found is None or found.multipliers is None or inside_circle(found.multipliers):
            return None
        away = measure.scaled(found.points) - measure.scaled(points[-1:])
        near = np.linalg.norm(away, axis=1).min() <= _NEAR * spans.wide
        return found if near and np.count_nonzero(np.abs(found.multipliers) > 1.0) == 1 else None

    def exponents(self) -> tuple[Floats, Floats]:
        """The largest exponents per iterate along the track, with their standard errors."""
        free = np.ix_(~self.drifting, ~self.drifting)
        count = int(np.sum(~self.drifting))
        kept = min(_EXPONENTS, count)
        found, errors = np.full((2, _EXPONENTS), np.nan)
        frame = np.linalg.qr(np.random.default_rng(0).standard_normal((count, kept)))[0]
        growth = []
        for state, mode in zip(self.track.states, self.track.modes, strict=True):
            step = self.straddle.search.runner.images(state, mode, 1)
            if step is None:
                return found, errors
            frame, sizes = np.linalg.qr(step[2][free] @ frame)
            growth.append(np.abs(np.diag(sizes)))
        with np.errstate(divide="ignore"):
            rates = np.log(np.array(growth)[_TURNING:])
        if len(rates) < _FEWEST - _TURNING or not np.isfinite(rates).all():
            return found, errors
        found[:kept], errors[:kept] = rates.mean(axis=0), block_averages(rates).standard_error
        return found, errors


def follow_edge(
    straddle: Straddle,
    pair: Pair,
    spans: Spans,
    drifting: npt.NDArray[np.bool_],
    complete: Callable[[Floats], Floats] | None,
    tell: Callable[[int], None],
) -> Edge:
    """Find the border between the ends of a segment, and follow the motion on it."""
    follower = Follower(straddle, spans, drifting)
    first, last, cycle, whole = pair, pair, None, True
    exponents, errors = np.full((2, _EXPONENTS), np.nan)
    kind = "aperiodic"
    try:
        first = last = straddle.bisect(pair, spans.narrow, complete)
        last, cycle = follower.follow(first, tell)
        if cycle is None and len(follower.track.states) >= 2:
            cycle = follower.saddle()
        if cycle is not None:
            kind = "periodic"
        elif follower.period:
            kind = "unresolved"
        else:
            exponents, errors = follower.exponents()
            kind = _kind(exponents, errors, len(follower.track.states))
    except KeyboardInterrupt:
        whole = False
    return Edge(
        kind, follower.track, first, last, cycle, follower.period, exponents, errors,
        follower.ended, whole,
    )  # fmt: skip


def _kind(exponents: Floats, errors: Floats, count: int) -> str:
    """What a track is that does not repeat.

    Pairs leave every border, so the largest exponent tells nothing. Along a torus the second one is
    zero; where it is not, motions that do not repeat are chaotic.
    """
    second, error = float(exponents[1]), float(errors[1])
    if not np.isfinite(second):
        return "chaotic" if np.isfinite(exponents[0]) else "aperiodic"
    if abs(second) * count <= _NEUTRAL:
        return "quasi-periodic"
    return "chaotic" if abs(second) > _STANDARD_ERRORS * error else "aperiodic"
