"""Motions as points, the places where they nearly close, and starts of more of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.basins.region import Box
from nonsmooth.engine.record import columns
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan, since_strobe
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import NoMode, Outcome, run_plan
from nonsmooth.runs.start import complete_state, resolve_start, start_at_end
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

__all__ = [
    "PointsOfMotion",
    "Return",
    "close_returns",
    "drawn_states",
    "first_motion",
    "returns_in_turn",
    "sampled_motions",
    "spread_of",
    "states_around",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_LOOKED_AT = 40  # returns that are put in order for each guess that is wanted
_APART = 0.01  # of the spread: guesses of one word that are closer are taken for one
_OUTER = 0.01  # part of the points on either side that the spread leaves out

_WIDER = 0.5  # of the range of a motion: by how much starts are taken beyond it, on either side


@dataclass(frozen=True)
class PointsOfMotion:
    """A motion as points: strobes of a driven one, states behind events of any other.

    Times count from the first window in which points are kept. Points of one ``kind`` lie on one
    section.
    """

    points: Floats  # (P, n)
    kinds: Integers  # (P,)
    times: Floats  # (P,)
    modes: Integers  # (P,) behind each point
    driven: bool
    phase: float  # time of the points since their windows began, 0 where they are events
    event_rows: Integers  # (E, 3): path, exits passed, mode behind
    event_times: Floats  # (E,)
    event_states: Floats  # (E, n) behind each event
    status: Status

    def between(self, i: int, j: int) -> slice:
        """Events behind point i and before point j, or up to it where points are events.

        An event at a strobe comes behind it: it has not changed its state.
        """
        side: Literal["left", "right"] = "left" if self.driven else "right"
        low = np.searchsorted(self.event_times, self.times[i], side=side)
        high = np.searchsorted(self.event_times, self.times[j], side=side)
        return slice(int(low), int(high))

    def word_key(self, i: int, j: int) -> bytes:
        """What tells the word from point i to point j from others."""
        return bytes([self.modes[i] & 255]) + self.event_rows[self.between(i, j)].tobytes()

    def guess(self, i: int, j: int, shift: Floats) -> Guess | None:
        """Legs from point i to point j, less a shift of the states, (n,).

        None where more exits are passed at one instant than a word can hold.
        """
        part = self.between(i, j)
        rows, inner = self.event_rows[part], self.event_times[part]
        paths = [path_of_bits(int(bits), int(passes)) for bits, passes, _ in rows]
        if any(path is None for path in paths):
            return None
        kept = [path for path in paths if path is not None]
        modes = [int(self.modes[i]), *(int(row[2]) for row in rows)]
        states = np.vstack([self.points[i], self.event_states[part]])
        instants = np.concatenate([[self.times[i]], inner, [self.times[j]]])
        if self.driven:
            kept.append(())
        else:  # the last event is point j itself
            modes, states, instants = modes[:-1], states[:-1], instants[:-1]
        states = states - shift
        return Guess(
            Word(tuple(modes), tuple(kept)), Turn(states, instants - instants[0] + self.phase)
        )


def first_motion(
    wanted: OrbitRequest, tables: Tables, periods: int, driven: bool
) -> PointsOfMotion:
    """Motion from the start that is given, some periods after its transient."""
    system = wanted.system
    window = tables.window
    start = resolve_start(system, tables, wanted.initial, None, wanted.mode, True)
    start = start_at_end(start)
    late = start.instant.phase > wanted.phase * window * (1.0 + 1e-14)
    first = start.instant.number + int(late) + wanted.transient

    def run(mode: int) -> PointsOfMotion:
        return motion_from(wanted, tables, start.state, start.instant, first, periods, driven, mode)

    return in_first_mode(system, tables, start, run)


def motion_from(
    wanted: OrbitRequest, tables: Tables, state: Floats, begin: Instant, first: int, periods: int,
    driven: bool, mode: int = -1,
) -> PointsOfMotion:  # fmt: skip
    """Motion from a state, its points from window ``first`` on; `NoMode` where none admits it."""
    phase = wanted.phase * tables.window
    numbers = first + np.arange(periods + 1, dtype=np.int64)
    plan = Plan(Instant(int(numbers[-1]), phase), numbers, np.full(periods + 1, phase))
    outcome = run_plan(tables, plan, wanted.tolerance, state=state, begin=begin, mode=mode)
    return _points(outcome.unless_interrupted(), first, phase, driven)


def _points(outcome: Outcome, first: int, phase: float, driven: bool) -> PointsOfMotion:
    rows, window = outcome.events, outcome.window
    keep = ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    since = since_strobe(rows["number"], rows["phase"], Instant(first, phase), window)
    keep &= (since >= 0.0) if driven else (since > 0.0)
    rows, states, times = rows[keep], outcome.event_states[keep, 1], since[keep]
    reached = outcome.n_samples
    kept = columns(rows, "path", "passes", "to_mode")
    if driven:
        return PointsOfMotion(
            outcome.records.sample_state[:reached], np.zeros(reached, np.int64),
            np.arange(reached, dtype=float) * window, outcome.records.sample_mode[:reached], True,
            phase, kept, times, states, outcome.status,
        )  # fmt: skip
    tell = columns(rows, "from_mode", "path", "to_mode")
    _, kinds = np.unique(tell, axis=0, return_inverse=True)
    return PointsOfMotion(
        states, kinds.reshape(-1), times, kept[:, 2], False, 0.0, kept, times, states,
        outcome.status,
    )  # fmt: skip


class Return(NamedTuple):
    """A motion that comes nearly back to its point ``i`` at its point ``j``."""

    motion: int
    i: int
    j: int
    gap: float  # beside the spread of the points


def spread_of(
    motions: Sequence[PointsOfMotion], drifting: npt.NDArray[np.bool_], periods: Floats
) -> Floats:
    """What counts as large for each state; infinite for drifts, one turn at most for angles."""
    parts = [each for motion in motions for each in (motion.points, motion.event_states)]
    points = np.concatenate(parts)
    if not len(points):
        return np.where(drifting, np.inf, 1.0)
    low, high = np.quantile(points, [_OUTER, 1.0 - _OUTER], axis=0)
    spread = np.where(drifting, 0.0, high - low)
    spread = np.where(periods > 0.0, np.minimum(spread, periods), spread)
    # a state that hardly moves, beside one that does
    size = np.abs(np.where(drifting, 0.0, points)).max(initial=1e-12)
    least = np.maximum(1e-6 * spread.max(), 1e-9 * size)
    return np.where(drifting, np.inf, np.maximum(spread, least))


def close_returns(
    motions: Sequence[PointsOfMotion], n: int, spread: Floats, periods: Floats, most: int
) -> list[Return]:
    """Returns after n points of one kind, the closest first; at most so many.

    Points whole turns of angles apart are one; ``periods`` (n,) are those of angles.
    """
    numbers, first, last, gaps = [], [], [], []
    for number, motion in enumerate(motions):
        for kind in np.unique(motion.kinds):
            places = np.flatnonzero(motion.kinds == kind)
            if places.size <= n:
                continue
            i, j = places[:-n], places[n:]
            change = motion.points[j] - motion.points[i]
            gap = (np.abs(change - whole_turns(change, periods)) / spread).max(axis=1)
            numbers.append(np.full(i.size, number))
            first.append(i)
            last.append(j)
            gaps.append(gap)
    if not gaps:
        return []
    gap = np.concatenate(gaps)
    gap = np.where(np.isfinite(gap), gap, np.inf)
    order = np.argsort(gap, kind="stable")[: _LOOKED_AT * most]
    columns = (np.concatenate(numbers)[order], np.concatenate(first)[order],
               np.concatenate(last)[order], gap[order])  # fmt: skip
    return [Return(int(a), int(b), int(c), float(d)) for a, b, c, d in zip(*columns, strict=True)]


def returns_in_turn(
    motions: Sequence[PointsOfMotion], returns: Sequence[Return], spread: Floats
) -> Iterator[Return]:
    """Each word's closest return, then the next closest ones, and so on.

    Of returns with one word that begin at nearly the same point, the closest one is taken.
    """
    groups: dict[bytes, list[Return]] = {}
    for each in returns:
        key = motions[each.motion].word_key(each.i, each.j)
        groups.setdefault(key, []).append(each)
    tried: dict[bytes, list[Floats]] = {key: [] for key in groups}
    queues = {key: iter(group) for key, group in groups.items()}
    while queues:
        for key in list(queues):
            for each in queues[key]:
                point = motions[each.motion].points[each.i] / spread
                known = tried[key]
                if known and np.abs(np.array(known) - point).max(axis=1).min() < _APART:
                    continue
                known.append(point)
                yield each
                break
            else:
                del queues[key]


def drawn_states(box: Box, count: int, seed: int) -> Floats:
    """States from a scrambled Sobol sequence in a box; nan where the equations complete them."""
    return box.states(_sobol(len(box.low), count, seed))


def states_around(
    system: System, motion: PointsOfMotion, drifting: npt.NDArray[np.bool_], count: int, seed: int
) -> tuple[Floats, dict[str, tuple[float, float]]]:
    """States drawn around a motion, and the ranges from which they are drawn.

    In every other one, states that some mode slaves are nan: left to the equations of a mode.
    """
    points = np.concatenate([motion.points, motion.event_states])
    points = points - whole_turns(points, periods_of_states(system))
    origin = np.array([system.rest_state[name] for name in system.states])
    if not len(points):
        points = origin[None]
    low, high = points.min(axis=0), points.max(axis=0)
    width = np.where(high > low, high - low, 0.0)
    moves = ~drifting & (width > 1e-9 * width.max(initial=1e-12))
    low, high = low - _WIDER * width, high + _WIDER * width
    states = np.where(drifting, origin, points[-1]) + np.zeros((count, len(origin)))
    unit = _sobol(max(int(moves.sum()), 1), count, seed)
    states[:, moves] = (low + unit[:, np.cumsum(moves) - 1] * (high - low))[:, moves]
    slaved = {name for mode in system.modes.values() for name in mode.slaved}
    states[1::2, [name in slaved for name in system.states]] = np.nan
    ranges = zip(system.states, moves, low.tolist(), high.tolist(), strict=True)
    return states, {name: (least, most) for name, moving, least, most in ranges if moving}


def _sobol(dimensions: int, count: int, seed: int) -> Floats:
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    drawn: Floats = sequence.random(2 ** int(np.ceil(np.log2(max(count, 1)))))[:count]
    return drawn


def sampled_motions(
    wanted: OrbitRequest, tables: Tables, states: Floats, periods: int, driven: bool
) -> Iterator[PointsOfMotion | None]:
    """A motion from each state; None where no mode admits it."""
    begin = Instant(0, wanted.phase * tables.window)
    for state in states:
        try:
            if np.any(np.isnan(state)):
                state = complete_state(wanted.system, tables, state, begin)
            yield motion_from(wanted, tables, state, begin, 0, periods, driven)
        except NoMode:
            yield None
