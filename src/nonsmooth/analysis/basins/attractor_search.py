"""Finds attractors: lanes run until they come to a known one, or recur and so find a new one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_kind import cycle_from, kind_of_set
from nonsmooth.analysis.basins.confirmation import confirm_visits
from nonsmooth.analysis.basins.recurrences import Known, Measure, new_visits, share_of_new
from nonsmooth.analysis.statistics.periodicity import primitive_period
from nonsmooth.engine.attractors import visit
from nonsmooth.engine.lanes import ANY, SAME
from nonsmooth.engine.status import Status

__all__ = ["ENDED", "INADMISSIBLE", "UNSETTLED", "AttractorSearch", "Settled", "measure_of"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

# labels of lanes that come to no attractor
UNSETTLED, ENDED, INADMISSIBLE = 0, -1, -2
_FIRST, _LARGEST = 64, 512  # images in a block
_AHEAD = 32  # lanes that run before the others
_RETURNS, _NEW = 100, 0.05  # a lane recurs where at most this part of its last images is new
_LOOK = 2048  # images among which a period is looked for
_SAME_SET = 0.5  # part of the points of a set in the cells of another: sets that differ have none
_INNER, _STILL = 5.0, 0.99  # percentile; spread of points that stay, beside that before
_SAME_CYCLE = 1e-5  # beside the scale
_LOW, _HIGH = 1.0, 99.0  # percentiles between which states spread; single lanes may be far off
_GROWS = 2.0  # factor by which lanes on their way to infinity grow at least
_LEAST_SPREAD = 1e-3  # of a state, beside its spread at the start
_ROUNDING = 1e-8  # of a state, beside its size: differences below are those of rounding
_EXACTLY = 1e-13  # beside the scale, to which motions on an unstable cycle repeat


@dataclass(frozen=True)
class Settled:
    """What lanes came to."""

    label: Integers  # (L,): attractor from 1 on, or one of the above
    needed: Integers  # (L,): images until that was known


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
        tell: Callable[[int], None] = lambda _: None,
    ) -> None:
        self.runner, self.known, self.drifting = runner, known, drifting
        self.match, self.longest, self.record = match, longest, record
        self._tell = tell  # how many lanes have come to their end

    def settle(
        self, states: Floats, modes: Integers | int = ANY, stop: threading.Event | None = None
    ) -> Settled:
        """Run lanes until each has come to an attractor, or for the longest time.

        A few go ahead: to find an attractor takes much longer than to come to one that is known.

        shapes: states (L, n)
        """
        chosen = np.broadcast_to(modes, len(states))
        parts = [slice(0, _AHEAD)] + [slice(_AHEAD, None)] * (len(states) > _AHEAD)
        found = [self._settle(states[part], chosen[part], stop, part.start) for part in parts]
        return Settled(*(np.concatenate(part) for part in zip(*map(astuple, found), strict=True)))

    def _settle(
        self, states: Floats, modes: Integers, stop: threading.Event | None, before: int
    ) -> Settled:
        """The same for lanes that run together; ``before``: how many have come to their end."""
        count = len(states)
        label, needed = np.zeros(count, np.int64), np.zeros(count, np.int64)
        lanes = self.runner.start(states, modes)
        left, visits, done = np.arange(count), new_visits(count), 0
        history = np.zeros((count, 0), np.int64)
        while left.size and done < self.longest:
            block = min(max(_FIRST, done), _LARGEST, self.longest - done)
            images, image_modes = self.runner.iterate(lanes, block, stop)
            visit(images, done + 1, self.known.landmarks(), visits)
            confirm_visits(self.runner, lanes, images[:, -1], self.known.cycles(), visits)
            keys = np.stack([self.known.measure.keys(one) for one in images])
            history = np.concatenate([history, keys], axis=1)
            going_on = lanes.status == Status.COMPLETED
            for i in range(left.size):
                if visits.label[i] == 0 and going_on[i] and self._recurs(history[i]):
                    number, is_new = self._analyse(images[i, -1], int(image_modes[i, -1]), stop)
                    visits.label[i], visits.needed[i] = number, done + block
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
            kept = np.flatnonzero(visits.label == 0)
            left, lanes, history = left[kept], lanes.select(kept), history[kept]
            visits = visits.part(kept)
            self._tell(before + count - left.size)
        needed[left] = done
        return Settled(label, needed)

    def _recurs(self, history: Integers) -> bool:
        return history.size > _RETURNS and share_of_new(history, _RETURNS) <= _NEW

    def _analyse(self, state: Floats, mode: int, stop: threading.Event | None) -> tuple[int, bool]:
        """Number of the attractor on which a point lies, and whether it is a new one.

        Zero where it is none: the motion ended, or stays on a cycle that is not stable.
        """
        lane = self.runner.start(state[None], np.array([SAME - mode]))
        visits, done = new_visits(1), 0
        points, modes = [], []
        marks = self.known.landmarks()
        tested = 0  # images among which a period was looked for
        while done < self.record:
            images, image_modes = self.runner.iterate(lane, min(_LARGEST, self.record - done), stop)
            if lane.status[0] != Status.COMPLETED:
                return UNSETTLED, False
            visit(images, 1, marks, visits)
            confirm_visits(self.runner, lane, images[:, -1], self.known.cycles(), visits)
            if visits.label[0] > 0:
                return int(visits.label[0]), False
            points.append(images[0])
            modes.append(image_modes[0])
            done += images.shape[1]
            if done >= 2 * tested or done >= self.record:
                tested = done
                found, exactly = self._cycle(np.concatenate(points), modes[-1])
                if found is not None and found.stable:
                    return self._with_cycle(found)
                # a start may lie on an unstable cycle, or come to it along a symmetry
                if found is not None and (exactly or done >= self.record):
                    return UNSETTLED, False
        return self._with_set(np.concatenate(points), np.concatenate(modes))

    def _cycle(self, points: Floats, modes: Integers) -> tuple[Attractor | None, bool]:
        """Cycle that the last points repeat, refined, and whether they do so to rounding."""
        last = points[len(points) // 2 :][-_LOOK:]  # the rest may belong to the way there
        scale = self.known.measure.scale
        period = primitive_period(last, self.drifting, scale, self.match)
        if period == 0:
            return None, False
        found = cycle_from(
            self.runner, self.known.measure, last[-1], int(modes[-1]), period, self.drifting
        )
        return found, primitive_period(last, self.drifting, scale, _EXACTLY) > 0

    def _with_cycle(self, found: Attractor) -> tuple[int, bool]:
        same = self.known.same_cycle(found, _SAME_CYCLE)
        return (same, False) if same else (self.known.add(found), True)

    def _with_set(self, points: Floats, modes: Integers) -> tuple[int, bool]:
        """A set that does not repeat, joined to the one in whose cells it lies."""
        half = len(points) // 2
        owners = self.known.owners(points[half:])
        shares = np.bincount(owners, minlength=1) / len(owners)
        shares[0] = 0.0
        if shares.max() >= _SAME_SET:
            number = int(shares.argmax())
            self.known.add_cells(self.known.measure.keys(points[half:]), number)
            return number, False
        found = kind_of_set(self.runner, points, modes, self.drifting)
        if found.kind != "chaotic" and self._shrinks(points):
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
