"""Points on a section from many starts: arrays in, arrays out, lane by lane."""

from __future__ import annotations

import threading
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import ANY, GOES_ON, SAME
from nonsmooth.engine.record import Rows, dtype_of
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.lane_runner import LaneRunner, Lanes
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.return_tangent import images_of_point
from nonsmooth.runs.section_map import SectionMap
from nonsmooth.runs.section_points import SectionStart, just_before
from nonsmooth.runs.section_search import (
    FIRST_PART,
    PATIENCE,
    BehindStart,
    Crossings,
    NamedEvents,
    Pick,
    SectionPoints,
    behind_start,
    joined_points,
    length_of_next,
    some_points,
)
from nonsmooth.runs.start import Start
from nonsmooth.runs.stillness import Stillness, looks_along, terms_of_rates
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.words import rebounds_of, word_of_modes

__all__ = ["NEVER_CROSSES", "SectionLanes", "SectionRunner"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_NEAR = 1e-4  # part of a window within which a point may be off its section
NEVER_CROSSES = Status.TIME_LIMIT  # of a lane that found no point for long, or rests elsewhere


@dataclass
class _Way:
    """How far the search of one lane has come, and what it found that was not asked for yet."""

    begin: Instant
    here: Instant
    points: SectionPoints
    rows: Rows  # of the event log since the last point that was asked for
    values: Floats
    still: Stillness
    first_modes: list[int]  # still to be tried at the start, in modes of the engine's system
    length: int = FIRST_PART  # of the next part, in windows
    waited: int = 0  # windows without a point
    n_points: int = 0
    n_events: int = 0
    windows: int = 0

    def copy(self) -> _Way:
        """The same way, to go on without this one."""
        return replace(self, first_modes=[*self.first_modes], still=copy(self.still))


@dataclass
class SectionLanes:
    """Lanes on their way, each at its own time."""

    lanes: Lanes
    ways: list[_Way]
    status: Integers = field(default_factory=lambda: np.zeros(0, np.int64))

    def select(self, chosen: Integers) -> SectionLanes:
        """Copy of some of the lanes, to go on without the others."""
        chosen = np.arange(len(self.ways))[chosen]
        ways = [self.ways[i].copy() for i in chosen]
        return SectionLanes(self.lanes.select(chosen), ways, self.status[chosen])


class SectionRunner:
    """Applies a Poincaré map; one runner belongs to one thread."""

    def __init__(self, chosen: SectionMap, tolerance: float) -> None:
        self.chosen = chosen
        split = chosen.split
        self.engine = LaneRunner(chosen.system if split is None else split.system, tolerance)
        self._prepare()

    def set_up(self, chosen: SectionMap) -> None:
        """Take the same map with other values of parameters; `ModelError` for senseless ones."""
        self.chosen = chosen
        self.engine.set_up(chosen.system.parameter_values)
        self._prepare()

    def _prepare(self) -> None:
        chosen = self.chosen
        split = chosen.split
        self.reads_time = is_driven(self.engine.tables)
        self._rates: StateRates | None = None  # made when a motion may rest
        if split is None:
            self.origin = np.arange(len(chosen.system.mode_names))
            self.pick: Pick = NamedEvents(chosen.system, chosen.section)
        else:
            self.origin = split.origin
            self.pick = Crossings(split, self.engine.tables, chosen.way)

    def start(
        self,
        states: Floats,
        modes: Integers | int = ANY,
        begin: Instant | None = None,
        *,
        behind: bool = False,
    ) -> SectionLanes:
        """Lanes that begin at some states, on the section or not, at time zero.

        A state whose mode is given may lie at the event of the section, as points do; with
        ``behind`` it lies behind one.

        Modes are those of the system: one of them, any, or SAME - m as for the engine.

        shapes: states (L, n), modes (L,)
        """
        count, n = states.shape
        begin = Instant(0, 0.0) if begin is None else begin
        if self._at_events and not behind:
            states, modes, begin = self._before_events(states, modes, begin)
        wanted = [self._candidates(int(m)) for m in np.broadcast_to(modes, count)]
        first = np.array([candidates.pop(0) for candidates in wanted], np.int64)
        ways = [
            _Way(
                begin, begin, joined_points([], n), np.zeros(0, dtype_of("EventRow")),
                np.zeros((0, 2, n)), Stillness(n, watched=not self.reads_time), candidates,
            )
            for candidates in wanted
        ]  # fmt: skip
        lanes = self.engine.start(states, begin, first)
        return SectionLanes(lanes, ways, lanes.status.copy())

    def iterate(
        self, lanes: SectionLanes, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """Apply the map some times; each image with its mode, nan and -1 once a lane has ended.

        returns: states (L, count, n), modes (L, count)
        """
        n = lanes.lanes.end_state.shape[1]
        states = np.full((len(lanes.ways), count, n), np.nan)
        modes = np.full((len(lanes.ways), count), -1, np.int64)
        side = 0 if self.chosen.side == "before" else 1
        for i in np.flatnonzero(lanes.status == Status.COMPLETED):
            points, _, _ = self.take(lanes, int(i), count, stop)
            found = points.number.size
            states[i, :found], modes[i, :found] = points.states[side], points.modes[side]
        return states, modes

    def last(
        self, lanes: SectionLanes, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """Apply the map some times and give the last images alone, with their modes.

        returns: states (L, n), modes (L,)
        """
        states, modes = self.iterate(lanes, count, stop)
        return states[:, -1], modes[:, -1]

    def admits(self, states: Floats) -> npt.NDArray[np.bool_]:
        """Which states are starts that a mode takes, whether or not they lead to the section.

        shapes: states (L, n)
        """
        found = self.start(states)
        for i, way in enumerate(found.ways):
            self._search_on(found.lanes, i, way, 1)
        return np.asarray(found.lanes.status != Status.INADMISSIBLE)

    def images(
        self, state: Floats, mode: int, count: int
    ) -> tuple[Floats, Integers, Floats] | None:
        """Images of one point with their modes, and the derivative of the last one by the point.

        The point lies on the section, not only up to rounding but up to an error of Newton's
        method. None where its mode does not fit or the motion ends before.

        returns: states (count, n), modes (count,), derivative (n, n)
        """
        tables, window = self.engine.tables, self.engine.window
        states, modes, begin = state[None], np.array([mode]), Instant(0, 0.0)
        if self._at_events:
            states, modes, begin = self._before_events(states, modes, begin)
        start = Start(states[0], begin, (*self._candidates(int(modes[0])), ANY))
        pick = BehindStart(self.pick, begin, window, _NEAR)
        motion = SectionStart(tables, start, pick, start, tables)
        return images_of_point(self.chosen, motion, count, self.engine.tolerance)

    def word(self, state: Floats, mode: int, count: int) -> str:
        """Modes that are visited along some applications of the map, from a point in a mode."""
        lanes = self.start(state[None], np.array([SAME - mode]))
        points, rows, _ = self.take(lanes, 0, count)
        passed = rows[: int(points.row[-1])] if points.row.size else rows
        passed = passed[self.is_event(passed)]
        if self._at_events and len(passed):  # the event at which the point lies comes first
            mode, passed = int(passed["to_mode"][0]), passed[1:]
        modes = np.array([mode, *self.origin[passed["to_mode"]]])
        return word_of_modes(self.chosen.system, modes, rebounds_of(passed))

    def is_event(self, rows: Rows) -> npt.NDArray[np.bool_]:
        """Which rows of the log are events of the system, not only crossings of the section."""
        own = np.array([row["passes"] == 1 and self.pick.is_own(row) for row in rows], bool)
        found: npt.NDArray[np.bool_] = ~own & (rows["kind"] != EventKind.GRAZE)
        return found

    def take(
        self, lanes: SectionLanes, i: int, count: int, stop: threading.Event | None = None
    ) -> tuple[SectionPoints, Rows, Floats]:
        """Next images of lane i, fewer where it ends, and the event log up to the last of them."""
        way, wanted = lanes.ways[i], count * self.chosen.every
        while way.points.number.size < wanted and lanes.lanes.status[i] == Status.COMPLETED:
            if way.waited >= PATIENCE:
                lanes.lanes.status[i] = NEVER_CROSSES
                break
            if stop is not None and stop.is_set():
                raise Stopped
            self._search_on(lanes.lanes, i, way, wanted)
        points = way.points
        if points.number.size < wanted:
            lanes.status[i] = lanes.lanes.status[i]
            wanted = points.number.size
        cut = int(points.row[wanted - 1]) + 1 if wanted else 0
        taken = some_points(points, slice(self.chosen.every - 1, wanted, self.chosen.every))
        rows, values = way.rows[:cut], way.values[:cut]
        left = some_points(points, slice(wanted, None))
        way.points = replace(left, row=left.row - cut)
        way.rows, way.values = way.rows[cut:], way.values[cut:]
        return taken, rows, values

    @property
    def _at_events(self) -> bool:
        """Whether points lie just before events, up to rounding perhaps beyond the guard."""
        return not self.chosen.is_crossing and self.chosen.side == "before"

    def _before_events(
        self, states: Floats, modes: Integers | int, begin: Instant
    ) -> tuple[Floats, Integers, Instant]:
        """Starts whose modes are known a little earlier on their motions, and their instant."""
        modes = np.broadcast_to(np.asarray(modes, np.int64), len(states)).copy()
        modes[modes <= SAME] = SAME - modes[modes <= SAME]
        if not np.all(modes >= 0):
            return states, modes, begin
        moved = [
            just_before(self.chosen.system, self.engine.tables, Start(state, begin, (int(mode),)))
            for state, mode in zip(states, modes, strict=True)
        ]
        return np.array([one.state for one in moved]), modes, moved[0].instant

    def _terms(self, here: Instant, mode: int, state: Floats) -> Floats:
        """What the terms of the rate of each state add up to in a window."""
        if self._rates is None:
            self._rates = StateRates(self.chosen.system, self.engine.tables, self.origin)
        return terms_of_rates(self._rates, here, mode, state, self.engine.window)

    def _candidates(self, mode: int) -> list[int]:
        """Modes of the engine's system to try at a start, in order."""
        if mode == ANY:
            return [ANY]
        if mode <= SAME:
            return [SAME - int(np.flatnonzero(self.origin == SAME - mode)[0])]
        return [int(m) for m in np.flatnonzero(self.origin == mode)]

    def _search_on(self, lanes: Lanes, i: int, way: _Way, wanted: int) -> None:
        """Run one lane for another part."""
        mode = int(lanes.mode[i])
        window = self.engine.window
        numbers, phases = looks_along(way.here, way.length, window)
        seen, modes, rows, values = self.engine.record(lanes, i, numbers, phases)
        if lanes.status[i] == Status.INADMISSIBLE and not len(rows) and way.first_modes:
            lanes.status[i], lanes.mode[i] = Status.COMPLETED, way.first_modes.pop(0)
            return
        if mode != GOES_ON and len(rows) and _at_start(rows[0], way.here):
            rows, values = rows[1:], values[1:]  # what happens at the start is no crossing
        points, _ = self.pick(rows, values)
        points = behind_start(points, way.begin, window)
        if modes.size:
            last = int(modes[-1])
            looks = np.concatenate([seen, *values.swapaxes(0, 1)])
            way.still.see(looks, way.length, lambda state: self._terms(way.here, last, state))
        if way.still.now:
            points = some_points(points, slice(0))
        points = replace(points, row=points.row + len(way.rows))
        way.points = joined_points([way.points, points], lanes.end_state.shape[1])
        way.rows, way.values = (
            np.concatenate([way.rows, rows]),
            np.concatenate([way.values, values]),
        )
        way.here = Instant(int(numbers[-1]), float(phases[-1]))
        found = points.number.size
        way.waited = 0 if found else way.waited + way.length
        if way.still.forever:
            way.waited = PATIENCE
        way.n_points += found
        way.n_events += len(rows)
        way.windows += way.length
        rest = way.n_points + max(0, wanted - way.points.number.size)
        way.length = length_of_next(way.n_points, way.n_events, way.windows, way.length, rest)


def _at_start(row: Any, begin: Instant) -> bool:
    """Whether a row of the log tells of the start itself."""
    same = (int(row["number"]), float(row["phase"])) == begin
    return bool(row["kind"] == EventKind.START or same)
