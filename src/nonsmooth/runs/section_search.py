"""Points of a section in the event log of a run, and the search for them along a motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import Certificate, EventKind, Status
from nonsmooth.engine.tables import Tables, exits_of_path, members
from nonsmooth.progress import Progress
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.runner import NoMode, Outcome, run_plan
from nonsmooth.runs.start import Start
from nonsmooth.runs.stillness import Stillness, looks_along
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.section import Section
from nonsmooth.system.system import System

__all__ = [
    "AT_ONCE",
    "FIRST_PART",
    "PATIENCE",
    "BehindStart",
    "Crossings",
    "NamedEvents",
    "Pick",
    "SearchLimits",
    "SectionPoints",
    "SectionSearch",
    "behind_start",
    "event_names",
    "joined_points",
    "length_of_next",
    "search",
    "some_points",
    "to_begin",
]

Integers = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_SMALL = 1e-9  # part of its terms, within which an expression is zero at an event
_PASSAGE = "from_mode", "to_mode", "path", "passes"  # what tells events apart
AT_ONCE = 1e-12  # part of a window; a point so soon after a start is the start up to rounding
_SHIFT = 1e-4  # relative change of a state that tells the size of the terms it stands in
PATIENCE = 10_000  # windows without a point after which the search is given up
FIRST_PART = 8  # windows of the first part
_MOST_EVENTS = 200_000  # that a part should have
_SPARE = 1.1  # points come unevenly
_STUCK = (Status.UNDECIDED, Status.STEP_LIMIT, Status.EVENT_LIMIT)
_STILL = 2.0**-40  # change of a state, beside one or its size, that is rounding of a motion at rest
_NO_SAMPLES = np.zeros(0, np.int64), np.zeros(0)


class Crossings:
    """Instants at which the motion goes through a section; a jump over it is none."""

    def __init__(self, section: Section, tables: Tables, direction: int) -> None:
        self.section = section
        self.tables = tables
        self.direction = direction
        self.knots = bool(section.system.signals)

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        section = self.section
        before, after = rows["from_mode"], rows["to_mode"]
        way = section.side[after]
        grazes = rows["kind"] == EventKind.GRAZE
        open_ = grazes & (rows["exit"] >= 0) & (rows["exit"] == section.gate[before])
        crosses = (section.side[before] * way < 0) & ~grazes
        crosses &= rows["kind"] != EventKind.START
        if self.direction:
            crosses &= way == self.direction
        # a jump may lead over the section, as may an input whose rate jumps at a knot
        doubtful = crosses & (rows["passes"] > 1)
        doubtful |= crosses & self.knots & (rows["guard_rate"] == 0.0)
        if doubtful.any():
            crosses[doubtful] = self._go_through(rows[doubtful], states[doubtful])
        here = np.flatnonzero(crosses)
        points = _points(rows, states, here, section.origin, way[here])
        # nothing but the side has changed, and behind it the state lies on the section exactly
        plain = rows["passes"][here] == 1
        points.states[0, plain] = points.states[1, plain]
        return points, open_

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section."""
        return bool(row["exit"] >= 0 and row["exit"] == self.section.gate[row["from_mode"]])

    def _go_through(self, rows: Rows, states: Floats) -> Flags:
        """Whether the expression is continuous at events with several exits, or at knots."""
        found = np.zeros(len(rows), bool)
        at_knot = self.knots & (rows["guard_rate"] == 0.0)
        kinds = np.column_stack([columns(rows, *_PASSAGE), at_knot])
        distinct, which = np.unique(kinds, axis=0, return_inverse=True)
        for k in range(len(distinct)):  # events that pass the same exits
            here = np.flatnonzero(which.ravel() == k)
            found[here] = self._all_go_through(rows[here], states[here], bool(distinct[k, -1]))
        return found

    def _all_go_through(self, rows: Rows, states: Floats, at_knot: bool) -> Flags:
        """The same for events that pass the same exits."""
        row = rows[0]
        before, after = int(row["from_mode"]), int(row["to_mode"])
        if at_knot:
            return self._vanish(rows, after, states[:, 1])
        read = self._states_read(before) | self._states_read(after)
        if read & self._states_reset(row):
            return self._vanish(rows, before, states[:, 0]) & self._vanish(
                rows, after, states[:, 1]
            )
        first, one = self._values(rows, before, states[:, 1])
        second, other = self._values(rows, after, states[:, 1])
        same: Flags = np.abs(first - second) <= _SMALL * (one + other)
        return same

    def _states_read(self, mode: int) -> set[str]:
        """States on which the expression depends in a mode."""
        system = self.section.system
        forms = system.structure.running[mode]
        equation = system.structure.outputs[self.section.value]
        return forms.graph.states_in(forms.resolver.lenient().tree(equation))

    def _states_reset(self, row: Any) -> set[str]:
        """States that jump at an event."""
        wiring, mode = self.tables.wiring, int(row["from_mode"])
        states = self.section.system.states
        reset: set[str] = set()
        for way in exits_of_path(int(row["path"]), int(row["passes"])):
            jumping = members(wiring.exits["resetting"][mode, way], len(states))
            reset.update(state for state, jumps in zip(states, jumping, strict=True) if jumps)
            mode = int(wiring.exits["target"][mode, way])
        return reset

    def _vanish(self, rows: Rows, mode: int, states: Floats) -> Flags:
        value, size = self._values(rows, mode, states)
        none: Flags = np.abs(value) <= _SMALL * size
        return none

    def _values(self, rows: Rows, mode: int, states: Floats) -> tuple[Floats, Floats]:
        """Values of the expression at events, and the size of its terms there."""
        count, n = states.shape
        shifts = np.vstack([np.ones(n), 1.0 + _SHIFT * np.eye(n)])
        shifted = (states[:, None] * shifts).reshape(-1, n)
        number = np.repeat(rows["number"], n + 1)
        phase = np.repeat(rows["phase"], n + 1)
        system = self.section.system
        clock, modes = SampleClock(number, phase, self.tables), np.full(number.size, mode)
        found = output_values(system, clock, shifted.T, modes)[self.section.value]
        whole = np.broadcast_to(found, number.shape).reshape(count, n + 1)
        return whole[:, 0], np.abs(whole[:, 1:] - whole[:, :1]).sum(axis=1) / _SHIFT


class NamedEvents:
    """Instants at which an exit of a name is passed, or a mode of that name entered."""

    def __init__(self, system: System, name: str) -> None:
        self.labels = labels_of(system)
        self.name = name
        running = system.structure.running
        self.modes = np.array([name in (m.label, m.parent, m.name) for m in running])
        self.origin = np.arange(len(running))

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        kinds = columns(rows, "from_mode", "path", "passes", "to_mode")
        distinct, which = np.unique(kinds, axis=0, return_inverse=True)
        meant = np.array([self._is_meant(*map(int, kind)) for kind in distinct], bool)
        meant = meant[which.ravel()] if len(rows) else np.zeros(0, bool)
        meant &= rows["kind"] != EventKind.START
        grazes = rows["kind"] == EventKind.GRAZE
        here = np.flatnonzero(meant & ~grazes)
        none = np.zeros(here.size, np.int64)
        return _points(rows, states, here, self.origin, none), meant & grazes

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section: events always are."""
        return False

    def _is_meant(self, before: int, path: int, passes: int, after: int) -> bool:
        entered = bool(self.modes[after] and not self.modes[before])
        return entered or self.name in self.labels.path(before, path, passes).split(">")


class BehindStart:
    """Points that another pick finds, without the start itself."""

    def __init__(self, pick: Pick, begin: Instant, window: float, within: float = AT_ONCE) -> None:
        self.pick, self.begin, self.window, self.within = pick, begin, window, within

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        points, open_ = self.pick(rows, states)
        return behind_start(points, self.begin, self.window, self.within), open_

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section."""
        return self.pick.is_own(row)


def behind_start(
    points: SectionPoints, begin: Instant, window: float, within: float = AT_ONCE
) -> SectionPoints:
    """Points without those that are the start up to rounding, from which a motion goes on.

    ``within`` is the part of a window up to which they are.
    """
    since = (points.number - begin.number) * window + (points.phase - begin.phase)
    late = since > within * window
    return points if late.all() else some_points(points, np.flatnonzero(late))


def event_names(system: System) -> set[str]:
    """Names of the exits, and of the modes that they enter."""
    names = {way for of_mode in system.compiled.exit_names for way in of_mode}
    running = system.structure.running
    targets = {target for m in running for target in m.targets if target >= 0}
    for target in targets:
        names |= {running[target].label, running[target].parent}
    return names


def _points(
    rows: Rows, states: Floats, here: Integers, origin: Integers, direction: Integers
) -> SectionPoints:
    rows = rows[here]
    return SectionPoints(
        here,
        rows["number"].copy(),
        rows["phase"].copy(),
        origin[columns(rows, "from_mode", "to_mode").T],
        states[here].transpose(1, 0, 2).copy(),
        direction.copy(),
        rows["certificate"] == Certificate.CERTIFIED,
    )


@dataclass(frozen=True)
class SectionPoints:
    """Points and the rows of the event log that they are.

    shapes: modes (2, k) and states (2, k, n), just before and just after the instants; all
    others (k,)
    """

    row: npt.NDArray[np.int64]
    number: npt.NDArray[np.int64]
    phase: npt.NDArray[np.float64]
    modes: npt.NDArray[np.int64]
    states: npt.NDArray[np.float64]
    direction: npt.NDArray[np.int64]
    certified: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class SearchLimits:
    """Where points count from, how many are wanted, and where the search ends at the latest."""

    begin: Instant
    record: int
    end: Instant | None


@dataclass
class SectionSearch:
    """What a search has found; ``gave_up`` when nothing came for long."""

    instant: Instant
    parts: list[SectionPoints] = field(default_factory=list)
    status: Status = Status.COMPLETED
    n_points: int = 0
    n_uncertain: int = 0
    n_estimated: int = 0
    n_grazes: int = 0
    n_rounded: int = 0  # crossings of a motion that stays at one place: rounding alone
    gave_up: bool = False
    at_rest: bool = False  # on the section, within rounding


class Pick(Protocol):
    """Finds points in rows of the event log."""

    def __call__(
        self, rows: Rows, states: npt.NDArray[np.float64]
    ) -> tuple[SectionPoints, npt.NDArray[np.bool_]]:
        """Points, and which rows are contacts with the section that rounding leaves open."""

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section."""


def search(
    tables: Tables, start: Start, limits: SearchLimits, tolerance: float, pick: Pick
) -> SectionSearch:
    """Points of a trajectory; `NoMode` when no mode admits the start."""
    found = SectionSearch(start.instant)
    try:
        outcome = to_begin(tables, start, limits.begin, tolerance)
        found.status, found.instant = outcome.status, outcome.end
        found.n_uncertain = outcome.n_uncertain
        found.n_estimated = outcome.n_estimated
        still = Stillness(outcome.records.end_state.size, watched=not is_driven(tables))
        waited = windows = n_events = 0
        length = FIRST_PART
        with Progress("section", limits.record) as progress:
            while found.status == Status.COMPLETED and found.n_points < limits.record:
                stop = Instant(found.instant.number + length, found.instant.phase)
                if limits.end is not None:
                    stop = min(stop, limits.end)
                if stop <= found.instant:
                    break
                if limits.end is None and waited >= PATIENCE:
                    found.gave_up = True
                    _look_whether_at_rest(found, outcome.records.end_state)
                    break
                outcome = _next_part(tables, outcome, stop, tolerance)
                seen = outcome.records.sample_state[: outcome.n_samples]
                seen = np.concatenate([seen, *outcome.event_states.swapaxes(0, 1)])
                still.see(seen, length, np.abs)
                count = _take(found, outcome, limits.record, pick, still=still.now)
                if still.forever and found.n_rounded:
                    _end_at_last_point(found)
                    break
                windows += length
                n_events += outcome.n_events
                waited = 0 if count else waited + length
                length = length_of_next(found.n_points, n_events, windows, length, limits.record)
                progress.update(found.n_points)
    except KeyboardInterrupt:
        found.status = Status.INTERRUPTED
    return found


def _take(found: SectionSearch, outcome: Outcome, record: int, pick: Pick, *, still: bool) -> int:
    """Add the points of a part, and what is doubtful until the last one; returns their number."""
    rows = outcome.events[1:]
    points, grazes = pick(rows, outcome.event_states[1:])
    if still:
        found.n_rounded += points.number.size
        points = some_points(points, slice(0))
    wanted = record - found.n_points
    found.n_estimated += outcome.n_estimated
    found.status, found.instant = outcome.status, outcome.end
    if points.number.size < wanted:
        found.n_uncertain += outcome.n_uncertain
        if outcome.status in _STUCK and len(rows):
            found.at_rest = (
                pick.is_own(rows[-1]) and rows["certificate"][-1] == Certificate.UNCERTAIN
            )
    else:  # what lies behind the last point is not looked at, however far the part went
        points = some_points(points, slice(wanted))
        last = int(points.row[-1]) + 1
        found.status = Status.COMPLETED
        found.instant = Instant(int(points.number[-1]), float(points.phase[-1]))
        found.n_uncertain += int(np.sum(rows["certificate"][:last] == Certificate.UNCERTAIN))
        grazes = grazes[:last]
    found.parts.append(points)
    found.n_points += points.number.size
    found.n_grazes += int(grazes.sum())
    return points.number.size


def _look_whether_at_rest(found: SectionSearch, end_state: npt.NDArray[np.float64]) -> None:
    """Say that a motion rests that has stayed at a point which rounding leaves open."""
    last = next((part for part in reversed(found.parts) if part.number.size), None)
    if last is None or last.certified[-1]:
        return
    gone = np.abs(end_state - last.states[1, -1])
    if np.all(gone <= _STILL * np.maximum(1.0, np.abs(end_state))):
        _end_at_last_point(found)


def _end_at_last_point(found: SectionSearch) -> None:
    """Say that the motion rests on the section since the last point, if there was one before."""
    found.at_rest = True
    last = next((part for part in reversed(found.parts) if part.number.size), None)
    if last is not None:
        found.instant = Instant(int(last.number[-1]), float(last.phase[-1]))


def to_begin(tables: Tables, start: Start, begin: Instant, tolerance: float) -> Outcome:
    """Run to where points count from, in the first mode that admits the start."""
    plan = Plan(begin, *_NO_SAMPLES)
    for mode in start.modes:
        try:
            return run_plan(
                tables,
                plan,
                tolerance,
                anchor=start.anchor,
                state=start.state,
                begin=start.instant,
                mode=mode,
                keep_events=False,
            )
        except NoMode as fault:
            misfit = fault
    raise misfit


def _next_part(tables: Tables, before: Outcome, stop: Instant, tolerance: float) -> Outcome:
    numbers, phases = looks_along(before.end, stop.number - before.end.number, tables.window)
    inside = (numbers < stop.number) | ((numbers == stop.number) & (phases <= stop.phase))
    plan = Plan(stop, numbers[inside], phases[inside])
    state = before.records.end_state
    return run_plan(tables, plan, tolerance, anchor=before.anchor, state=state, begin=before.end)


def length_of_next(n_points: int, n_events: int, windows: int, length: int, record: int) -> int:
    """Windows of the next part: enough for the rest, as far as the points so far tell."""
    most = min(4 * length, PATIENCE)
    if n_points:
        most = min(most, int(_SPARE * (record - n_points) * windows / n_points) + 1)
    if n_events:
        most = min(most, int(_MOST_EVENTS * windows / n_events))
    return max(most, 1)


def some_points(points: SectionPoints, chosen: slice | npt.NDArray[np.int64]) -> SectionPoints:
    """Some of the points."""
    return SectionPoints(
        points.row[chosen],
        points.number[chosen],
        points.phase[chosen],
        points.modes[:, chosen],
        points.states[:, chosen],
        points.direction[chosen],
        points.certified[chosen],
    )


def joined_points(parts: list[SectionPoints], n: int) -> SectionPoints:
    """Points of all parts, one after the other, of n states; rows stay those of the parts."""
    empty = SectionPoints(
        np.zeros(0, np.int64),
        np.zeros(0, np.int64),
        np.zeros(0),
        np.zeros((2, 0), np.int64),
        np.zeros((2, 0, n)),
        np.zeros(0, np.int64),
        np.zeros(0, bool),
    )
    parts = [empty, *parts]
    return SectionPoints(
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.number for part in parts]),
        np.concatenate([part.phase for part in parts]),
        np.concatenate([part.modes for part in parts], axis=1),
        np.concatenate([part.states for part in parts], axis=1),
        np.concatenate([part.direction for part in parts]),
        np.concatenate([part.certified for part in parts]),
    )
