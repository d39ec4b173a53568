"""Images of many starts under a map, out of the log of their events."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.family import SectionStarts
from nonsmooth.engine.lanes import (
    ANY,
    GOES_ON,
    Anchor,
    Records,
    Tangent,
    allocate_columns,
    lane_anchors,
    lane_records,
    lane_tangents,
    run_lanes,
)
from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import Certificate, EventKind, Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.maps import Map
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.runner import NO_DERIVATIVES, Derivatives
from nonsmooth.runs.section_search import AT_ONCE, Crossings, NamedEvents
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.words import rebounds_of, word_of_modes

__all__ = ["Images", "Imaging", "imaging_of", "settle"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROOM = 64  # rows of the log of a lane in one call of the kernel
_ROUNDING = 1e-9  # of states that are put on a relation
_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_AT_START = 2  # rows after which a lane stops that has only begun

Texts = npt.NDArray[np.str_]

_FIRST = 1  # windows of the first part of a search; each further one is twice as long


class BegunLanes(NamedTuple):
    """Lanes that have begun and not moved yet."""

    anchors: Anchor  # with the number of lanes in front
    status: Integers  # (L,)
    passed: npt.NDArray[np.bool_]  # (L,): an exit was passed at the start
    jumped: npt.NDArray[np.bool_]  # (L,): and changed the states
    columns: Floats  # (L, n, N): of derivatives by the start, no rows where none are carried

    def anchor(self, i: int) -> Anchor:
        """Copy of the anchor of one lane."""
        return self.anchors.part(i).copied()


def settle(
    engine: LaneRunner,
    starts: SectionStarts,
    tolerance: float,
    derivatives: Derivatives = NO_DERIVATIVES,
) -> BegunLanes:
    """Begin at all starts, each in the first of its modes that fits."""
    count, n = starts.states.shape
    anchors = lane_anchors(engine.sizes, starts.number, starts.phase, starts.states)
    status = np.full(count, int(Status.INADMISSIBLE))
    passed, jumped = np.zeros(count, bool), np.zeros(count, bool)
    many = allocate_columns(engine.sizes, 0 if derivatives.chosen is None else n, 1)
    columns = np.zeros((count, *many.columns.shape))
    for choice in starts.modes.T:
        left = np.flatnonzero(status == Status.INADMISSIBLE)
        if not left.size:
            break
        some = anchors.part(left)
        some.state[:] = starts.states[left]
        records = lane_records(engine.sizes, *_NO_TIMES, _AT_START, left.size)
        tangent = lane_tangents(many, left.size)
        found = _call(
            engine, some, records, choice[left].copy(), Instant(0, 0.0), tolerance, tangent,
            derivatives,
        )  # fmt: skip
        anchors.put(left, some)
        columns[left] = tangent.columns
        status[left] = np.where(found == Status.BUFFER_FULL, int(Status.COMPLETED), found)
        began = records.counters["events"] > 0
        # a lane that began and is inadmissible afterwards is so in any case
        passed[left] = began & (records.events["passes"][:, 0] > 0)
        given = starts.states[left]
        apart = np.abs(some.state - given) > _ROUNDING * (1.0 + np.abs(given))
        jumped[left] = passed[left] & np.any(apart, axis=1)  # nan, left open, is no jump
    return BegunLanes(anchors, status, passed, jumped, columns)


class LaneLog:
    """Lanes that run on together; the log of all since the beginning."""

    def __init__(self, engine: LaneRunner, settled: BegunLanes, tolerance: float) -> None:
        self.engine, self.tolerance = engine, tolerance
        self.anchors = settled.anchors.copied()
        self.status = settled.status.copy()
        self.ends = np.full((self.status.size, engine.sizes.states), np.nan)
        empty = lane_records(engine.sizes, *_NO_TIMES, 0, self.status.size)
        self._since, self._counters = empty.since, empty.counters
        self._lanes: list[Integers] = [np.zeros(0, np.int64)]
        self._rows: list[Rows] = [empty.events.ravel()]
        self._states: list[Floats] = [empty.event_states.reshape(0, 2, engine.sizes.states)]

    def run(self, chosen: Integers, end: Instant) -> Integers:
        """Run some lanes on, to an instant or until their logs are full, and give those that are.

        ``ends`` and ``status`` are those at the instant.
        """
        some = self.anchors.part(chosen)
        records = lane_records(self.engine.sizes, *_NO_TIMES, _ROOM, chosen.size)
        records.since[:], records.counters[:] = self._since[chosen], self._counters[chosen]
        for name in ("samples", "events", "segments"):
            records.counters[name] = 0
        modes = np.full(chosen.size, GOES_ON)
        tangent = lane_tangents(allocate_columns(self.engine.sizes, 0, 1), chosen.size)
        found = _call(self.engine, some, records, modes, end, self.tolerance, tangent)
        self.anchors.put(chosen, some)
        self._since[chosen], self.ends[chosen] = records.since, records.end_state
        self._counters[chosen] = records.counters
        written = np.arange(_ROOM) < records.counters["events"][:, None]
        self._lanes.append(chosen[np.nonzero(written)[0]])
        self._rows.append(records.events[written])
        self._states.append(records.event_states[written])
        full = found == Status.BUFFER_FULL
        self.status[chosen] = np.where(full, int(Status.COMPLETED), found)
        return chosen[full]

    def rows(self) -> tuple[Integers, Rows, Floats]:
        """Lanes, rows of the log and states around events, lane by lane in order of time."""
        lanes, rows = np.concatenate(self._lanes), np.concatenate(self._rows)
        states, order = np.concatenate(self._states), np.argsort(lanes, kind="stable")
        self._lanes, self._rows, self._states = [lanes[order]], [rows[order]], [states[order]]
        return self._lanes[0], self._rows[0], self._states[0]


def _call(
    engine: LaneRunner,
    anchors: Anchor,
    records: Records,
    modes: Integers,
    end: Instant,
    tolerance: float,
    tangent: Tangent,
    derivatives: Derivatives = NO_DERIVATIVES,
) -> Integers:
    """Run all lanes; their statuses."""
    count = modes.size
    statuses, passed, first = np.empty(count, np.int64), np.zeros(2, np.int64), 0
    while first < count:
        first = run_lanes(
            engine.tables.as_lanes, derivatives.rates, derivatives.scratch, anchors,
            engine.segment, tangent, records, modes, first, count, *end, passed, statuses,
            tolerance,
        )  # fmt: skip
    return statuses


class Images(NamedTuple):
    """What became of starts; nan, -1 and "" where there is no image."""

    states: Floats  # (L, n)
    number: Integers  # (L,) window of the image
    phase: Floats  # (L,)
    modes: Integers  # (L,) of the image, in the system
    status: Integers  # (L,)
    words: Texts  # (L,) modes on the way
    exits: Texts  # (L,) exits passed on the way
    n_events: Integers  # (L,)
    certified: npt.NDArray[np.bool_]  # (L,)
    n_rows: Integers  # (L,) of the event log up to the image
    jumped: npt.NDArray[np.bool_]  # (L,): the start was reset
    begun: Floats  # (L, n): the start with all states that the mode gives

    @property
    def there(self) -> npt.NDArray[np.bool_]:
        """Which starts have an image."""
        return self.status == Status.COMPLETED


class LastRows(NamedTuple):
    """Where the images lie in the log: the last row that counts, and the instant."""

    last: Integers  # (L,) place of the row of the image in the whole log, or behind the last one
    number: Integers
    phase: Floats
    states: Floats
    modes: Integers


class Imaging(ABC):
    """Applies a map to many starts; what both kinds of maps have in common."""

    engine: LaneRunner
    origin: Integers  # number in the system of each mode of the engine
    begin: Instant  # of starts that bring no phase
    at_rows = False  # whether images are rows of the event log
    side = 0  # of an event at which an image lies: just before, or 1 just after

    def __init__(self, chosen: Map, tolerance: float, longest: int):
        self.chosen, self.tolerance, self.longest = chosen, tolerance, longest

    @property
    def window(self) -> float:
        """Length of a window."""
        return self.engine.window

    def modes_of_engine(self, modes: Integers) -> Integers:
        """Modes to try, as the engine numbers them; a mode may have become several there."""
        if not modes.size or len(self.origin) == len(self.chosen.system.mode_names):
            return modes
        several = {int(m): np.flatnonzero(self.origin == m) for m in np.unique(modes)}
        several[ANY] = np.array([ANY])
        rows = [np.concatenate([several[int(m)] for m in row]) for row in modes]
        width = max(row.size for row in rows)
        return np.array([np.pad(row, (0, width - row.size), mode="edge") for row in rows])

    def images(self, starts: SectionStarts) -> Images:
        """Images of starts."""
        starts = self.prepared(starts)
        begun = settle(self.engine, starts, self.tolerance)
        log = LaneLog(self.engine, begun, self.tolerance)
        way = self.follow(starts, log)
        return self._summary(starts, begun, log, way)

    def prepared(self, starts: SectionStarts) -> SectionStarts:
        """Starts with modes as the engine numbers them."""
        return starts._replace(modes=self.modes_of_engine(starts.modes))

    @abstractmethod
    def follow(self, starts: SectionStarts, log: LaneLog) -> LastRows:
        """Run to the images."""

    def is_own(self, rows: Rows) -> npt.NDArray[np.bool_]:
        """Which rows are there for the section alone."""
        return np.zeros(len(rows), bool)

    def _summary(
        self, starts: SectionStarts, begun: BegunLanes, log: LaneLog, way: LastRows
    ) -> Images:
        lanes, rows, _ = log.rows()
        first = np.searchsorted(lanes, np.arange(log.status.size))
        since = (rows["number"] - starts.number[lanes]) * self.window
        since += rows["phase"] - starts.phase[lanes]
        here = np.arange(lanes.size)
        counts = ~self.is_own(rows) & (rows["kind"] != EventKind.GRAZE)
        counts &= here <= way.last[lanes]
        early = counts & (since <= AT_ONCE * self.window)  # of the start itself
        counts &= ~early
        entered = self.origin[rows["to_mode"]]
        if self.at_rows:
            entered[here == way.last[lanes]] = -1  # the image lies there
        mode = self.origin[begun.anchors.place["mode"]]
        mode[lanes[early]] = entered[early]  # the last one, as rows are in order
        words, exits = self._texts(lanes[counts], entered[counts], rows[counts], mode)
        there = log.status == Status.COMPLETED
        doubtful = (rows["certificate"] != Certificate.CERTIFIED) & (here <= way.last[lanes])
        return Images(
            np.where(there[:, None], way.states, np.nan),
            np.where(there, way.number, -1),
            np.where(there, way.phase, np.nan),
            np.where(there, way.modes, -1),
            log.status,
            np.where(there, words, ""),
            np.where(there, exits, ""),
            np.where(there, np.bincount(lanes[counts], minlength=there.size), -1),
            there & (np.bincount(lanes[doubtful], minlength=there.size) == 0),
            way.last + 1 - first,
            begun.jumped,
            np.where(np.isnan(starts.states), begun.anchors.state, starts.states),
        )

    def _texts(
        self, lanes: Integers, entered: Integers, rows: Rows, mode: Integers
    ) -> tuple[Texts, Texts]:
        """Words of modes, and names of exits in order; lanes that do the same share a text."""
        passages = columns(rows, "from_mode", "path", "passes")
        kinds, which = np.unique(passages, axis=0, return_inverse=True)
        labels = labels_of(self.engine.system)
        own = {"...", *(n for names in self.chosen.system.compiled.exit_names for n in names)}
        names = [
            ">".join(name for name in labels.path(*map(int, kind)).split(">") if name in own)
            for kind in kinds
        ]
        codes = np.column_stack([which.ravel(), entered, rebounds_of(rows)]).astype(np.int64)
        cuts = np.searchsorted(lanes, np.arange(mode.size + 1))
        known: dict[tuple[int, bytes], tuple[str, str]] = {}
        words, exits = [], []
        system = self.chosen.system
        for i, begin in enumerate(mode):
            part = codes[cuts[i] : cuts[i + 1]]
            key = (int(begin), part.tobytes())
            if key not in known:
                passed = part[part[:, 1] >= 0]
                visited = np.append(int(begin), passed[:, 1])
                word = word_of_modes(system, visited, passed[:, 2])
                known[key] = word, " ".join(names[k] for k in part[:, 0])
            words.append(known[key][0])
            exits.append(known[key][1])
        return np.array(words, dtype=str), np.array(exits, dtype=str)


class StrobeImaging(Imaging):
    """Images under a stroboscopic map."""

    def __init__(self, chosen: StroboscopicMap, tolerance: float, longest: int) -> None:
        super().__init__(chosen, tolerance, longest)
        self.engine = LaneRunner(chosen.system, tolerance)
        self.origin = np.arange(len(chosen.system.mode_names))
        runner = chosen.runner(tolerance)
        self.begin, self.end = runner.begin, runner.instant_of(1)

    def follow(self, starts: SectionStarts, log: LaneLog) -> LastRows:
        """Run to the images."""
        end, count = self.end, log.status.size
        left = np.flatnonzero(log.status == Status.COMPLETED)
        while left.size:
            left = log.run(left, end)
        lanes, _, _ = log.rows()
        last = np.searchsorted(lanes, np.arange(count), side="right") - 1
        return LastRows(
            last, np.full(count, end.number), np.full(count, end.phase), log.ends,
            log.anchors.place["mode"],
        )  # fmt: skip


class SectionImaging(Imaging):
    """Images under a Poincaré map."""

    at_rows = True

    def __init__(self, chosen: PoincareMap, tolerance: float, longest: int) -> None:
        super().__init__(chosen, tolerance, longest)
        split = chosen.split
        self.engine = LaneRunner(chosen.system if split is None else split.system, tolerance)
        self.origin = np.arange(len(chosen.system.mode_names)) if split is None else split.origin
        self.section, self.side = chosen.section, 0 if chosen.side == "before" else 1
        self.begin = Instant(0, 0.0)
        self.pick: Crossings | NamedEvents
        if split is None:
            self.pick = NamedEvents(chosen.system, chosen.section)
            self.gate = None
        else:
            self.pick = Crossings(split, self.engine.tables, chosen.way)
            self.gate = np.asarray(split.gate)

    def prepared(self, starts: SectionStarts) -> SectionStarts:
        """Starts that lie just before events a little earlier on their motions."""
        if self.gate is None and self.side == 0 and np.all(starts.modes == ANY):
            starts = starts._replace(modes=self._modes_before(starts.modes))
        starts = super().prepared(starts)
        known = starts.modes[:, 0]
        if self.gate is not None or self.side == 1 or not np.all(known >= 0):
            return starts
        step = 0.1 * AT_ONCE * self.window
        rates = StateRates(self.chosen.system, self.engine.tables)
        moved = starts.states - step * rates.of_many(
            starts.number, starts.phase, known, starts.states
        )
        phase, before = starts.phase - step, starts.phase < step
        phase = np.where(before, phase + self.window, phase)
        return SectionStarts(moved, starts.number - before, phase, starts.modes)

    def _modes_before(self, modes: Integers) -> Integers:
        """The mode that the event of the section ends, where it is one, and then any."""
        exits = self.chosen.system.compiled.exit_names
        ended = [m for m, names in enumerate(exits) if self.section in names]
        first = np.full((len(modes), 1), ended[0] if len(ended) == 1 else ANY, np.int64)
        return np.hstack([first, modes])

    def follow(self, starts: SectionStarts, log: LaneLog) -> LastRows:
        """Run until each lane has come to its image."""
        wanted = self.chosen.every
        left = np.flatnonzero(log.status == Status.COMPLETED)
        end = Instant(int(starts.number.max(initial=0)), 0.0)
        length, waited = _FIRST, 0
        found: LastRows | None = None
        while left.size:
            end, waited = Instant(end.number + length, 0.0), waited + length
            part = left
            while part.size:
                part = log.run(part, end)
                found, arrived = self._look(starts, log, wanted)
                part = part[~arrived[part]]
            done = arrived | (log.status != Status.COMPLETED)
            left = left[~done[left]]
            if waited >= self.longest and left.size:
                log.status[left] = Status.TIME_LIMIT
                break
            length = min(2 * length, self.longest - waited) or 1
        if found is None:
            found, arrived = self._look(starts, log, wanted)
        log.status[arrived] = Status.COMPLETED  # whatever became of it behind the image
        return found

    def is_own(self, rows: Rows) -> npt.NDArray[np.bool_]:
        """Which rows are there for the section alone."""
        if self.gate is None:
            return np.zeros(len(rows), bool)
        own: npt.NDArray[np.bool_] = (rows["passes"] == 1) & (rows["exit"] >= 0)
        return own & (rows["exit"] == self.gate[rows["from_mode"]])

    def _look(
        self, starts: SectionStarts, log: LaneLog, wanted: int
    ) -> tuple[LastRows, npt.NDArray[np.bool_]]:
        """The images that the log holds, and which lanes have one."""
        lanes, rows, states = log.rows()
        count, n = starts.states.shape
        points, _ = self.pick(rows, states)
        lane = lanes[points.row]
        since = (points.number - starts.number[lane]) * self.window
        since += points.phase - starts.phase[lane]
        late = np.flatnonzero(since > AT_ONCE * self.window)
        lane = lane[late]
        # points are in order of lanes and time
        rank = np.arange(late.size) - np.searchsorted(lane, lane)
        chosen = np.flatnonzero(rank == wanted - 1)
        here, place = lane[chosen], late[chosen]
        arrived = np.zeros(count, bool)
        arrived[here] = True
        last = np.searchsorted(lanes, np.arange(count), side="right") - 1
        way = LastRows(
            last, np.full(count, -1), np.full(count, np.nan), np.full((count, n), np.nan),
            np.full(count, -1),
        )  # fmt: skip
        way.last[here], way.number[here] = points.row[place], points.number[place]
        way.phase[here], way.states[here] = points.phase[place], points.states[self.side][place]
        way.modes[here] = points.modes[self.side][place]
        return way, arrived


def imaging_of(chosen: Map, tolerance: float, longest: int) -> StrobeImaging | SectionImaging:
    """What applies a map to many starts."""
    if isinstance(chosen, PoincareMap):
        return SectionImaging(chosen, tolerance, longest)
    assert isinstance(chosen, StroboscopicMap)
    return StrobeImaging(chosen, tolerance, longest)
