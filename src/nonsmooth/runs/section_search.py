"""Runs a trajectory until enough points are found: in parts, of which nothing else is kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows
from nonsmooth.engine.status import Certificate, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.progress import Progress
from nonsmooth.runs.runner import NoMode, Outcome, run_plan
from nonsmooth.runs.start import Start

__all__ = [
    "FIRST_PART",
    "NO_SAMPLES",
    "PATIENCE",
    "Pick",
    "SearchLimits",
    "SectionPoints",
    "SectionSearch",
    "joined_points",
    "length_of_next",
    "search",
    "some_points",
    "to_begin",
]

PATIENCE = 10_000  # windows without a point after which the search is given up
FIRST_PART = 8  # windows of the first part
_MOST_EVENTS = 200_000  # that a part should have
_SPARE = 1.1  # points come unevenly
_STUCK = (Status.UNDECIDED, Status.STEP_LIMIT, Status.EVENT_LIMIT)
NO_SAMPLES = np.zeros(0, np.int64), np.zeros(0)


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
                    break
                outcome = _next_part(tables, outcome, stop, tolerance)
                count = _take(found, outcome, limits.record, pick)
                windows += length
                n_events += outcome.n_events
                waited = 0 if count else waited + length
                length = length_of_next(found.n_points, n_events, windows, length, limits.record)
                progress.update(found.n_points)
    except KeyboardInterrupt:
        found.status = Status.INTERRUPTED
    return found


def _take(found: SectionSearch, outcome: Outcome, record: int, pick: Pick) -> int:
    """Add the points of a part, and what is doubtful until the last one; returns their number."""
    rows = outcome.events[1:]
    points, grazes = pick(rows, outcome.event_states[1:])
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


def to_begin(tables: Tables, start: Start, begin: Instant, tolerance: float) -> Outcome:
    """Run to where points count from, in the first mode that admits the start."""
    plan = Plan(begin, *NO_SAMPLES)
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
    plan = Plan(stop, *NO_SAMPLES)
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
