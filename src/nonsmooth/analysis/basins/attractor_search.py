"""Finds attractors: motions run until they come to a known one, or recur and so find a new one.

They do not take the path of `settle`: each runs as long as what it comes to demands, block by block
of images, and thousands of starts at one set of parameter values share their tables.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor, Cycle, canonical, refine
from nonsmooth.analysis.basins.folded_runner import runner_within_turns, turned
from nonsmooth.analysis.basins.kind_of_set import ESCAPING, kind_of_set
from nonsmooth.analysis.basins.recurrences import (
    Known,
    Measure,
    confirm_visits,
    new_visits,
    share_of_new,
)
from nonsmooth.analysis.basins.region import Box, admissible_starts
from nonsmooth.analysis.options import SharedOptions, check_match, check_seed
from nonsmooth.analysis.statistics.periodicity import primitive_period
from nonsmooth.engine.attractors import visit
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.progress import Progress
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.section_runner import NEVER_CROSSES
from nonsmooth.system.system import System

__all__ = [
    "ENDED",
    "FIRST_LOOK",
    "INADMISSIBLE",
    "NOT_COMPUTED",
    "RECURRED",
    "UNSETTLED",
    "AttractorSearch",
    "SearchOptions",
    "SettledStarts",
    "drift_mask",
    "find_attractors",
    "measure_of",
    "read_search",
    "search_among",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_WIDEST, _NARROWEST = 0.02, 1e-6  # radius of a ball of convergence, beside the scale
_SAME_POINT = 1e-9  # beside the scale
_PLACED = 1e-6  # beside the scale, to which the place of a cycle must be known
_DIRECTIONS = 8  # in which it is tried, beside the axes
_NEARER, _BARELY = 0.5, 0.99  # of the radius, to which all starts must have come
_MOST_ITERATES = 200_000  # of all starts of a trial
_TRANSIENT = 1e-3  # growth of starts before they shrink is made good by turns that shrink them so
_POINTS = 3  # of a long cycle that are tried

# labels of lanes that come to no attractor
UNSETTLED, ENDED, INADMISSIBLE = 0, -1, -2
NOT_COMPUTED = -3  # label of a cell that an interruption left out
RECURRED = -1  # in place of the status of an unsettled lane that came back to where it had been
FIRST_LOOK, _LARGEST = 64, 512  # images in the first block, whose spread tells units, and in others
_TOLD = 8  # images of the first block after which it says how far it is
_AHEAD = 32  # lanes that run before the others
_RETURNS, _NEW = 100, 0.05  # a lane recurs where at most this part of its last images is new
_LOOK = 2048  # images among which a period is looked for
_SAME_SET = 0.5  # part of the points of a set in the cells of another: sets that differ have none
_INNER, _STILL = 5.0, 0.99  # percentile; spread of points that stay, beside that before
_LONGER, _RUN_ON = 4, 16  # times the record, for a motion that may be on its way to a cycle
_LEAST_RECORD = 8  # iterates, so that a quarter of them has a spread
_SAME_CYCLE = 1e-5  # beside the scale
_LOW, _HIGH = 1.0, 99.0  # percentiles between which states spread; single lanes may be far off
_GROWS = 2.0  # factor by which lanes on their way to infinity grow at least
_LEAST_SPREAD = 1e-3  # of a state, beside its spread at the start
_ROUNDING = 1e-8  # of a state, beside its size: differences below are those of rounding
_ALMOST = 1e-10  # beside the scale: a clock that nothing holds gains a rounding in each iterate
_EXACTLY = 1e-13  # beside the scale, to which motions on an unstable cycle repeat


@dataclass(frozen=True)
class SearchOptions:
    """How attractors are looked for."""

    samples: int
    seed: int
    cells: int
    longest: int
    record: int
    match: float
    tolerance: float
    exponent_steps: int = 1000  # of the largest exponent of a set

    @property
    def options(self) -> dict[str, Any]:
        """As attributes of a result."""
        return {name: value for name, value in vars(self).items() if name != "exponent_steps"}


def read_search(
    samples: Any, cells: Any, longest: Any, record: Any, match: Any, shared: SharedOptions
) -> SearchOptions:
    """Options of a search, checked."""
    close, kept = check_match(match), whole_number("record", record)
    if kept < _LEAST_RECORD:
        raise OptionError(
            f"record = {kept}: an attractor is told by quarters of the record; give"
            f" {_LEAST_RECORD} iterates at least, better thousands"
        )
    return SearchOptions(
        whole_number("samples", samples), check_seed(shared.seed), whole_number("cells", cells),
        whole_number("longest", longest), kept, close,
        float(shared.tolerance),
    )  # fmt: skip


def cycle_from(
    runner: Any,
    measure: Measure,
    state: Floats,
    mode: int,
    period: int,
    drifting: npt.NDArray[np.bool_],
) -> Attractor | None:
    """Cycle near a point that nearly repeats; None where there is none.

    Slow motions nearly repeat too, and Newton's method tells: the cycle is not where they are.
    """
    cycle = refine(runner, state, mode, period, ~drifting, measure.scale)
    if cycle is not None:
        # points that agree to their residual's size are the same ones, gone around more than once
        scaled = measure.scaled(cycle.points)
        for shorter in range(1, period):
            if period % shorter == 0 and np.allclose(
                scaled, np.roll(scaled, -shorter, axis=0), rtol=0.0, atol=_SAME_POINT
            ):
                return cycle_from(runner, measure, state, mode, shorter, drifting)
    if cycle is None or not cycle.step <= _PLACED:
        return None
    turns = turned(runner, cycle.points[0], int(cycle.modes[0]), period)
    return canonical(
        Attractor(
            points=cycle.points,
            modes=cycle.modes,
            period=period,
            drift=(cycle.drift + turns) / period,
            kind="periodic",
            multipliers=cycle.multipliers,
            residual=cycle.residual,
            radius=_radius(runner, measure, cycle, drifting) if cycle.stable else np.nan,
        )
    )


def _radius(runner: Any, measure: Measure, cycle: Cycle, drifting: npt.NDArray[np.bool_]) -> float:
    """Largest tried radius from which all starts around the cycle come nearer to it.

    By half the radius, or less where that takes too long.
    """
    d, period = measure.columns.size, len(cycle.points)
    generator = np.random.default_rng(0)
    mixed = generator.standard_normal((_DIRECTIONS, d))
    mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
    directions = np.vstack([np.eye(d), -np.eye(d), mixed])
    chosen = np.unique(np.linspace(0, period - 1, min(period, _POINTS)).astype(int))
    rate = np.abs(cycle.multipliers).max(initial=0.0)
    turns = 10 if rate < 0.7 else int(np.log(_TRANSIENT) / np.log(rate)) + 10
    turns = max(1, min(turns, _MOST_ITERATES // (period * len(directions) * chosen.size)))
    nearer = max(_NEARER, min(_BARELY, 2.0 * rate**turns))
    radius = _WIDEST
    while radius > _NARROWEST:
        ends = _ends(runner, measure, cycle, directions * radius, chosen, turns)
        if np.all(ends <= nearer * radius):
            return radius
        radius /= 4.0
    return _NARROWEST


def _ends(
    runner: Any, measure: Measure, cycle: Cycle, steps: Floats, chosen: Integers, turns: int
) -> Floats:
    """Distances from the cycle at which starts beside it end, scaled; inadmissible ones left out.

    From any of its points: off a section, a start may be one point ahead of its neighbours.
    """
    scale = measure.scale[measure.columns]
    starts = np.repeat(cycle.points[chosen], len(steps), axis=0)
    starts[:, measure.columns] += np.tile(steps * scale, (len(chosen), 1))
    lanes = runner.start(starts, ANY)
    ends, _ = runner.last(lanes, len(cycle.points) * turns)
    points = measure.scaled(cycle.points)
    distance = np.linalg.norm(measure.scaled(ends)[:, None] - points[None], axis=2).min(axis=1)
    found: Floats = distance[lanes.status != Status.INADMISSIBLE]
    return np.where(np.isnan(found), np.inf, found)


@dataclass(frozen=True)
class SettledStarts:
    """What lanes came to."""

    label: Integers  # (L,): attractor from 1 on, or one of the above
    needed: Integers  # (L,): images until that was known
    ending: Integers  # (L,): status of those that ended, if known; RECURRED of some; else 0

    @classmethod
    def of(cls, label: Integers) -> SettledStarts:
        """Lanes of which no more is known than their labels."""
        return cls(label, np.zeros(len(label), np.int64), np.zeros(len(label), np.int64))

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Any], prefix: str = "") -> SettledStarts:
        """What a file holds; those of older versions do not tell how motions ended."""
        label, needed = arrays[f"{prefix}label"], arrays[f"{prefix}needed"]
        ending = arrays.get(f"{prefix}ending")
        return cls(label, needed, np.zeros(len(label), np.int64) if ending is None else ending)

    @property
    def endings(self) -> dict[Status, int]:
        """How many motions ended by each status, the most frequent first, as far as it is known."""
        found = self.ending[self.label == ENDED]
        values, counts = np.unique(found[found > 0], return_counts=True)
        order = np.argsort(-counts, kind="stable")
        return {Status(int(values[i])): int(counts[i]) for i in order}

    @property
    def unreturned(self) -> int:
        """How many of those that ended stay away from their section."""
        return self.endings.get(NEVER_CROSSES, 0)


@dataclass(frozen=True)
class FirstLook:
    """Lanes that have begun."""

    starts: Floats  # (L, n)
    lanes: Any  # behind their first images
    images: Floats  # (L, K, n), nan behind the end of a motion
    modes: Integers  # (L, K)

    def returning(self) -> FirstLook:
        """Those that come back to their section."""
        kept = np.flatnonzero(self.lanes.status != NEVER_CROSSES)
        return FirstLook(
            self.starts[kept], self.lanes.select(kept), self.images[kept], self.modes[kept]
        )


def _parts(count: int) -> list[slice]:
    """Lanes that run together: a few go ahead, as the attractors they find stop the others."""
    return [slice(0, _AHEAD)] + [slice(_AHEAD, None)] * (count > _AHEAD)


def _joined(parts: list[SettledStarts]) -> SettledStarts:
    return SettledStarts(*(np.concatenate(each) for each in zip(*map(astuple, parts), strict=True)))


def measure_of(images: Floats, starts: Floats, drifting: npt.NDArray[np.bool_], cells: int) -> Any:
    """Units in which states are compared: their spread once the first transient is over.

    shapes: images (L, K, n), the later half of them is taken; starts (L, n), drifting (n,)
    """
    n, quarter = starts.shape[1], images.shape[1] // 4
    size = np.abs(images).max(axis=2, initial=0.0)
    with np.errstate(invalid="ignore"):  # of lanes that have ended
        bounded = size[:, -quarter:].max(axis=1) <= _GROWS * size[:, -2 * quarter : -quarter].max(
            axis=1
        )
    late = images[bounded, -2 * quarter :].reshape(-1, n)
    # states that are not in the region begin as one, and come to their size on the way
    early = np.concatenate([starts[bounded], images[bounded, :quarter].reshape(-1, n)])
    first = np.ptp(starts, axis=0)
    if not len(late):
        late = early = starts
    low, high = np.percentile(early, [_LOW, _HIGH], axis=0)
    first = np.maximum(first, high - low)
    low, high = np.percentile(late, [_LOW, _HIGH], axis=0)
    size = np.abs(late).max(axis=0)
    scale = np.maximum.reduce([high - low, _LEAST_SPREAD * first, _ROUNDING * size])
    scale = np.where(scale > 0.0, scale, np.where(size > 0.0, size, 1.0))
    return Measure(np.flatnonzero(~drifting), scale, 1.0 / cells)


class AttractorSearch:
    """Settles lanes one block of images after another; new attractors become known."""

    def __init__(
        self,
        runner: Any,
        known: Known,
        drifting: npt.NDArray[np.bool_],
        *,
        match: float,
        longest: int,
        record: int,
        exponent_steps: int = 1000,
        tell: Callable[[int], None] = lambda _: None,
    ) -> None:
        self.runner, self.known, self.drifting = runner, known, drifting
        self.match, self.longest, self.record = match, longest, record
        self.exponent_steps = exponent_steps
        self._tell = tell  # how many lanes have come to their end

    def settle(
        self, states: Floats, modes: Integers | int = ANY, stop: threading.Event | None = None
    ) -> SettledStarts:
        """Run lanes until each has come to an attractor, or for the longest time.

        A few go ahead: to find an attractor takes much longer than to come to one that is known.

        shapes: states (L, n)
        """
        chosen = np.broadcast_to(modes, len(states))
        return _joined(
            [
                self._settle(self.runner.start(states[part], chosen[part]), None, stop, part.start)
                for part in _parts(len(states))
            ]
        )

    def settle_on(self, looks: list[FirstLook]) -> SettledStarts:
        """The same for lanes whose first images are known, in the parts that run together."""
        if self.longest < FIRST_LOOK:
            return self.settle(np.concatenate([look.starts for look in looks]))
        before = np.cumsum([0] + [len(look.starts) for look in looks])
        return _joined(
            [
                self._settle(look.lanes, (look.images, look.modes), None, int(count))
                for look, count in zip(looks, before, strict=False)
            ]
        )

    def _settle(
        self,
        lanes: Any,
        first: tuple[Floats, Integers] | None,
        stop: threading.Event | None,
        before: int,
    ) -> SettledStarts:
        """The same for lanes that run together; ``before``: how many have come to their end.

        Those that have begun are behind their ``first`` images and the modes of these.
        """
        count = len(lanes.status)
        label, needed, ending = (np.zeros(count, np.int64) for _ in range(3))
        left, visits, done = np.arange(count), new_visits(count), 0
        history = np.zeros((count, 0), np.int64)
        while left.size and done < self.longest:
            block = min(max(FIRST_LOOK, done), _LARGEST, self.longest - done)
            images, image_modes = first or self.runner.iterate(lanes, block, stop)
            first = None
            visit(images, done + 1, self.known.landmarks(), visits)
            confirm_visits(self.runner, lanes, images[:, -1], self.known.cycles(), visits)
            keys = np.stack([self.known.measure.keys(one) for one in images])
            history = np.concatenate([history, keys], axis=1)
            going_on = lanes.status == Status.COMPLETED
            for i in range(left.size):
                if visits.label[i] == 0 and going_on[i] and self._recurs(history[i]):
                    number, is_new = self._analyse(images[i, -1], int(image_modes[i, -1]), stop)
                    visits.label[i], visits.needed[i] = number, done + block
                    ending[left[i]] = 0 if number else RECURRED
                    if is_new:
                        later = visits.part(slice(i + 1, None))
                        visit(images[i + 1 :], done + 1, self.known.landmarks(), later)
                        rest = lanes.select(np.arange(i + 1, left.size))
                        cycles = self.known.cycles()
                        confirm_visits(self.runner, rest, images[i + 1 :, -1], cycles, later)
            done += block
            ended = ~going_on & (visits.label == 0)
            refused = lanes.status == Status.INADMISSIBLE
            visits.label[ended] = np.where(
                refused & np.isnan(images[:, 0, 0]), INADMISSIBLE, ENDED
            )[ended]
            label[left], needed[left] = visits.label, visits.needed
            ending[left[ended]] = lanes.status[ended]
            kept = np.flatnonzero(visits.label == 0)
            left, lanes, history = left[kept], lanes.select(kept), history[kept]
            visits = visits.part(kept)
            self._tell(before + count - left.size)
        needed[left] = done
        return SettledStarts(label, needed, ending)

    def _recurs(self, history: Integers) -> bool:
        return history.size > _RETURNS and share_of_new(history, _RETURNS) <= _NEW

    def _analyse(self, state: Floats, mode: int, stop: threading.Event | None) -> tuple[int, bool]:
        """Number of the attractor on which a point lies, and whether it is a new one.

        Zero where it is none: the motion ended, or stays on a cycle that is not stable. A motion
        that may settle slowly runs on, because its cycle then takes the lanes behind it.
        """
        lane = self.runner.start(state[None], np.array([SAME - mode]))
        visits, done = new_visits(1), 0
        points, modes = np.zeros((0, len(state))), np.zeros(0, np.int64)
        marks = self.known.landmarks()
        tested = 0  # images among which a period was looked for
        end = self.record
        while True:
            images, image_modes = self.runner.iterate(lane, min(_LARGEST, end - done), stop)
            if lane.status[0] != Status.COMPLETED:
                return UNSETTLED, False
            visit(images, 1, marks, visits)
            confirm_visits(self.runner, lane, images[:, -1], self.known.cycles(), visits)
            if visits.label[0] > 0:
                return int(visits.label[0]), False
            points = np.concatenate([points, images[0]])[-self.record :]
            modes = np.concatenate([modes, image_modes[0]])[-self.record :]
            done += images.shape[1]
            if done >= 2 * tested or done >= end:
                tested = done
                found, exactly = self._cycle(points, modes)
                if found is not None and found.stable:
                    return self._with_cycle(found)
                # a start may lie on an unstable cycle, or come to it along a symmetry
                if found is not None and (exactly or done >= self.record):
                    return UNSETTLED, False
                # what repeats and is no cycle by itself is one of a family: nothing holds its phase
                looked_at = done >= min(2 * _LOOK, self.record)
                if found is None and looked_at and self._period(points, _ALMOST):
                    return UNSETTLED, False
            if done >= end:
                answer = self._with_set(points, modes, is_last=end >= _RUN_ON * self.record)
                if answer is not None:
                    return answer
                end *= _LONGER

    def _cycle(self, points: Floats, modes: Integers) -> tuple[Attractor | None, bool]:
        """Cycle that the last points repeat, refined, and whether they do so to rounding."""
        period, scale = self._period(points, self.match), self.known.measure.scale
        last = _last(points)
        if period == 0:
            return None, False
        found = cycle_from(
            self.runner, self.known.measure, last[-1], int(modes[-1]), period, self.drifting
        )
        return found, primitive_period(last, self.drifting, scale, _EXACTLY) > 0

    def _period(self, points: Floats, match: float) -> int:
        """Period with which the last points repeat, 0 where they do not."""
        return primitive_period(_last(points), self.drifting, self.known.measure.scale, match)

    def _with_cycle(self, found: Attractor) -> tuple[int, bool]:
        same = self.known.same_cycle(found, _SAME_CYCLE)
        return (same, False) if same else (self.known.add(found), True)

    def _with_set(
        self, points: Floats, modes: Integers, *, is_last: bool
    ) -> tuple[int, bool] | None:
        """A set that does not repeat, joined to the one in whose cells it lies.

        None where a longer motion may tell more: a way to a cycle that takes long is no set.
        """
        half = len(points) // 2
        owners = self.known.owners(points[half:])
        shares = np.bincount(owners, minlength=1) / len(owners)
        shares[0] = 0.0
        number = int(shares.argmax()) if shares.max() >= _SAME_SET else self.known.same_set(points)
        if number:
            self.known.add_cells(self.known.measure.keys(points[half:]), number)
            return number, False
        shrinks = self._shrinks(points)
        if shrinks and not is_last:
            return None
        found = kind_of_set(self.runner, points, modes, self.drifting, self.exponent_steps)
        if found.kind == "chaotic":
            return self.known.add(found), True
        if not is_last:
            return None
        if shrinks or found.kind == ESCAPING:
            return UNSETTLED, False
        return self.known.add(found), True

    def _shrinks(self, points: Floats) -> bool:
        """Whether points still draw together, as on the slow way to a cycle."""
        scaled = self.known.measure.scaled(points)
        third, last = (
            np.ptp(np.percentile(part, [_INNER, 100.0 - _INNER], axis=0), axis=0)
            for part in np.array_split(scaled, 4)[2:]
        )
        return bool(np.all(last < _STILL * third))


def _last(points: Floats) -> Floats:
    """Points among which a period is looked for: those before may belong to the way there."""
    return points[len(points) // 2 :][-_LOOK:]


@dataclass(frozen=True)
class FoundAttractors:
    """Attractors that the sampled starts came to."""

    known: Known
    search: AttractorSearch
    settled: SettledStarts
    drawn: int  # starts, those that no mode admits among them
    complete: bool


def find_attractors(
    chosen: Any, box: Box, how: SearchOptions, *, silent: bool = False
) -> FoundAttractors:
    """Settle the starts of a box; ``silent`` without a progress bar, as a part of longer work."""
    runner = runner_within_turns(chosen, how.tolerance)
    starts, drawn = admissible_starts(runner, box, how.samples, how.seed)
    drifting = drift_mask(chosen.system)
    looks = _first_look(runner, starts, silent=silent)
    images = np.concatenate([look.images for look in looks])
    returns = np.concatenate([look.lanes.status for look in looks]) != NEVER_CROSSES
    known = Known(measure_of(images, starts, drifting, how.cells))
    complete, settled = True, SettledStarts.of(np.zeros(0, np.int64))
    label, needed = np.full(len(starts), ENDED), np.isfinite(images[:, :, 0]).sum(axis=1)
    ending = np.full(len(starts), int(NEVER_CROSSES))
    with Progress("attractors", int(np.sum(returns))) as progress:
        search = search_among(
            chosen, known, how, (lambda _: None) if silent else progress.update, runner
        )
        try:
            found = search.settle_on([look.returning() for look in looks])
            label[returns], needed[returns] = found.label, found.needed
            ending[returns] = found.ending
            settled = SettledStarts(label, needed, ending)
        except KeyboardInterrupt:
            complete = False
    return FoundAttractors(known, search, settled, drawn, complete)


def _first_look(runner: Any, starts: Floats, *, silent: bool) -> list[FirstLook]:
    """First images of each start, in the parts that are settled together."""
    looks = []
    with Progress("first look at starts", len(starts)) as progress:
        for part in _parts(len(starts)):
            some = starts[part]
            lanes, blocks = runner.start(some), []
            for done in range(_TOLD, FIRST_LOOK + 1, _TOLD):
                blocks.append(runner.iterate(lanes, _TOLD))
                if not silent:
                    progress.update(part.start + len(some) * done // FIRST_LOOK)
            images, modes = (np.concatenate(each, axis=1) for each in zip(*blocks, strict=True))
            looks.append(FirstLook(some, lanes, images, modes))
    return looks


def search_among(
    chosen: Any,
    known: Known,
    how: SearchOptions,
    tell: Callable[[int], None] = lambda _: None,
    runner: Any = None,
) -> AttractorSearch:
    """A search that knows some attractors already; ``tell`` is told how many lanes are done."""
    return AttractorSearch(
        runner_within_turns(chosen, how.tolerance) if runner is None else runner, known,
        drift_mask(chosen.system), match=how.match, longest=how.longest, record=how.record,
        exponent_steps=how.exponent_steps, tell=tell,
    )  # fmt: skip


def drift_mask(system: System) -> npt.NDArray[np.bool_]:
    """Which states drift, (n,)."""
    return np.array([name in system.drift_states for name in system.states])
