"""Whether an orbit is a motion: every guard stays positive until its leg ends, by certified search.

A construction of a given word goes through walls if the equations want it to. Here each of its
events is passed by the engine itself, which begins in the middle of the leg before, so that what
is zero behind the event is known by construction; and from there the engine looks for the first
event to come. Legs are looked at side by side, each from the state of the construction, so nothing
adds up along an unstable orbit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.lanes import (
    GOES_ON,
    Anchor,
    Records,
    allocate_segment,
    allocate_tangent,
    lane_anchors,
    lane_records,
    lane_tangents,
    run_lanes,
)
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.periodic_orbits.departure import Departure
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.onto import chatters
from nonsmooth.periodic_orbits.rebounds import with_rebounds_of_engine
from nonsmooth.periodic_orbits.word import Word, path_of_bits

__all__ = ["Admissibility", "check_admissible"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROWS = 2  # of the event log of a lane: one event, one to spare; full after it, so it stops there
_Touches = list[tuple[int, float]]  # exits whose guards a lane has only touched, and when
_AT_SECTION = 1e-12  # part of the turn by which an event may lie behind the section
_LATE = 1e-9  # part of the turn by which the engine may find an event elsewhere
_MOST_LATE = 1e-3  # the same where rounding could move the event by any time: a guard is touched
_SAME = 1e-9  # of the size of each state: one that rounding may have changed
_ROUNDING = 1e-11  # of the terms of a guard, likewise, over its rate


class Admissibility(NamedTuple):
    """What the engine says of an orbit."""

    admissible: bool
    reason: str = ""
    leg: int = -1  # in which the orbit is no motion
    path: tuple[int, ...] = ()  # exits that the engine passes instead, empty where it passes none
    instant: float = np.nan  # and when


class _Lanes(NamedTuple):
    anchors: Anchor
    records: Records
    status: Integers
    touches: list[_Touches]


class _Expected(NamedTuple):
    """Events that end the legs of an orbit: their instants, and how far off the engine may be."""

    equations: OrbitEquations
    instants: Floats
    allowed: Floats
    turn: Turn
    rates: Floats  # of the states where each leg begins
    tolerance: float

    def leads_there(self, lanes: _Lanes, j: int, k: int) -> bool:
        """Whether lane j has come to the begin of the leg behind leg k, by whatever exits.

        Of several guards that are zero at one instant rounding decides which one is the first.
        """
        states, following = self.turn.states, (k + 1) % len(self.turn.states)
        if lanes.anchors.place["mode"][j] != self.equations.word.modes[following]:
            return False
        apart = np.abs(lanes.anchors.state[j] - states[following])
        allowed = _SAME * np.abs(states).max(axis=0)
        allowed += np.abs(self.rates[following]) * self.allowed[k]
        return bool(np.all((apart <= allowed) | self.equations.drifting))


def check_admissible(equations: OrbitEquations, turn: Turn, tolerance: float) -> Admissibility:
    """Follow an orbit that solves its equations, event by event.

    The results that the equations hold are overwritten.
    """
    word, legs = equations.word, equations.legs
    length = float(turn.instants[-1] - turn.instants[0])
    least = np.zeros(len(word))
    if word.n_events and not word.closes_at_event:  # an event may lie at the section
        least[[0, -1]] = -_AT_SECTION * length
    short = np.flatnonzero((turn.durations < least) | ((turn.durations <= 0.0) & (least == 0.0)))
    if short.size:
        k = int(short[0])
        return Admissibility(False, f"leg {k} ({_name(equations, k)}) lasts no time", k)
    if word.n_events == 0:
        return _check_without_events(equations, turn, tolerance)
    instants = turn.instants[:-1] + 0.5 * turn.durations
    try:
        middles = _middles(equations, turn, instants)
    except LegError as fault:
        return Admissibility(False, str(fault))
    allowed, rates = _allowed(equations, turn, middles)
    count = word.n_events
    if not word.closes_at_event and turn.durations[-1] > turn.durations[0]:
        # the stay before the first event began in the turn before
        instants[0], middles[0] = instants[-1] - length, middles[-1]
    end = float(turn.instants[-1]) + length
    lanes = _start(legs, middles[:count], instants[:count], 1 + _ROWS)
    _run(legs, lanes, word.mode_array[:count].copy(), end, tolerance)
    hidden = _hidden(lanes, turn)
    passed = np.flatnonzero(~hidden)
    expected = _Expected(
        equations, turn.instants[1 : 1 + count].copy(), allowed, turn, rates, tolerance
    )
    lanes = _some(lanes, passed)
    found, goes_on = _compare(expected, lanes, passed, 1)
    expected.instants[0] += length
    passed, lanes = passed[goes_on], _some(lanes, np.flatnonzero(goes_on))
    while found.admissible and passed.size:
        # on from behind each event, from the state of the construction there
        lanes = _behind(legs, lanes, turn, passed)
        _run(legs, lanes, np.full(passed.size, GOES_ON), end + length, tolerance)
        later = (passed + 1) % count
        found, goes_on = _compare(expected, lanes, later, 0)
        # and on through legs that none has begun in
        onward = np.flatnonzero(hidden[later] & goes_on)
        passed, lanes = later[onward], _some(lanes, onward)
    return found


def _check_without_events(equations: OrbitEquations, turn: Turn, tolerance: float) -> Admissibility:
    """Follow an orbit within one mode, in which nothing may happen."""
    lanes = _start(equations.legs, turn.states[:1], turn.instants[:1], 1 + _ROWS)
    end = float(turn.instants[-1])
    _run(equations.legs, lanes, equations.word.mode_array.copy(), end, tolerance)
    row = _first_event(lanes, 0)
    begins = lanes.records.events["passes"][0, 0] > 0
    if lanes.status[0] == Status.COMPLETED and row < 0 and not begins:
        return Admissibility(True)
    expected = _Expected(
        equations, turn.instants[1:], np.zeros(1), turn, np.zeros((0, 0)), tolerance
    )
    return _instead(expected, lanes, 0, 0, row)


def _allowed(equations: OrbitEquations, turn: Turn, middles: Floats) -> tuple[Floats, Floats]:
    """How far the engine may be from the instant of each event: rounding over the guard's rate.

    And the rates of the states where legs begin.

    Rounding is that of states as large as they are along the orbit: where a position is a guard, it
    is zero itself at the event.
    """
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    length = float(turn.instants[-1] - turn.instants[0])
    n = equations.legs.n
    largest = np.abs(np.concatenate([turn.states, middles, found.ends])).max(axis=0)
    terms = np.abs(found.guard_row[:, :n]) @ largest
    with np.errstate(divide="ignore", invalid="ignore"):
        slow = _ROUNDING * (terms + np.abs(found.guard)) / np.abs(found.guard_rate)
    allowed = _LATE * length + np.minimum(np.nan_to_num(slow, nan=0.0), _MOST_LATE * length)
    return allowed, found.start_rates.copy()


def _middles(equations: OrbitEquations, turn: Turn, instants: Floats) -> Floats:
    """States in the middle of each leg."""
    word = equations.word
    open_word = Word(word.modes, ((),) * len(word))
    found = equations.legs.follow_each(open_word, turn.states, turn.instants[:-1], instants)
    return found.ends.copy()


def _start(legs: Legs, states: Floats, instants: Floats, rows: int) -> _Lanes:
    """Lanes that begin at some states, with rows in their logs; one is that of the start."""
    count, sizes = len(states), legs.tables.sizes
    window = legs.window
    number = np.floor(instants / window).astype(np.int64)
    anchors = lane_anchors(sizes, number, instants - number * window, states)
    records = lane_records(sizes, np.zeros(0, np.int64), np.zeros(0), rows, count)
    return _Lanes(anchors, records, np.zeros(count, np.int64), [[] for _ in range(count)])


def _hidden(lanes: _Lanes, turn: Turn) -> npt.NDArray[np.bool_]:
    """Legs in whose middle the engine has begun elsewhere, at once: a guard is zero there.

    The last flights before rest are lower than what counts as zero of a guard at a start, which
    knows nothing of the impact before. The longest leg is not one of them.
    """
    hidden = np.asarray(lanes.records.events["passes"][:, 0] > 0)
    hidden[np.argmax(turn.durations[: hidden.size])] = False
    return hidden


def _some(lanes: _Lanes, chosen: Integers) -> _Lanes:
    """Some of the lanes, with what is asked of them after a run: anchors, events and statuses."""
    anchors, records = lanes.anchors, lanes.records
    return _Lanes(
        replace(
            anchors, place=anchors.place[chosen], order=anchors.order[chosen],
            state=anchors.state[chosen],
        ),
        replace(records, events=records.events[chosen], counters=records.counters[chosen]),
        lanes.status[chosen],
        [lanes.touches[j] for j in chosen.tolist()],
    )  # fmt: skip


def _behind(legs: Legs, lanes: _Lanes, turn: Turn, passed: Integers) -> _Lanes:
    """Lanes behind the events that end these legs, at the states of the construction.

    Modes and known zeros are those that the engine has found.
    """
    following = (passed + 1) % len(turn.states)
    new = _start(legs, turn.states[following], turn.instants[passed + 1], _ROWS)
    new.anchors.place["mode"] = lanes.anchors.place["mode"]
    new.anchors.order[:] = lanes.anchors.order
    return new


def _run(legs: Legs, lanes: _Lanes, how: Integers, end: float, tolerance: float) -> None:
    """Run each lane to its first event, or to an instant where there is none.

    The log of a lane is full after its first event, so that the engine stops there. A guard that is
    only touched is no event: the lane leaves it behind and goes on.
    """
    logged = lanes.records.counters["events"].copy() + (how != GOES_ON)
    _run_on(legs, lanes, how, end, tolerance, 0, len(lanes.status))
    for j in range(len(lanes.status)):
        while lanes.status[j] == Status.BUFFER_FULL and _first_event(lanes, j) < 0:
            _note_touches(legs, lanes, j)
            lanes.records.counters["events"][j] = logged[j]
            _run_on(legs, lanes, how, end, tolerance, j, j + 1)
        _note_touches(legs, lanes, j)


def _run_on(
    legs: Legs, lanes: _Lanes, how: Integers, end: float, tolerance: float, first: int, last: int
) -> None:
    """Run some lanes until their logs are full, or to an instant."""
    sizes, window = legs.tables.sizes, legs.window
    number = int(np.floor(end / window))
    tangent = lane_tangents(allocate_tangent(sizes, -1, 0), len(lanes.status))
    passed, segment = np.zeros(2, np.int64), allocate_segment(sizes)
    while first < last:
        first = run_lanes(
            legs.tables.as_lanes, no_rates(), no_scratch(), lanes.anchors,
            segment, tangent, lanes.records, how, first, last, number,
            end - number * window, passed, lanes.status, tolerance,
        )  # fmt: skip


def _note_touches(legs: Legs, lanes: _Lanes, j: int) -> None:
    """Keep the tangencies in the log of a lane."""
    count = int(lanes.records.counters["events"][j])
    for row in lanes.records.events[j, :count]:
        if row["kind"] == EventKind.GRAZE:
            instant = float(row["number"] * legs.window + row["phase"])
            lanes.touches[j].append((int(row["exit"]), instant))


def _compare(
    expected: _Expected, lanes: _Lanes, ends: Integers, row: int
) -> tuple[Admissibility, npt.NDArray[np.bool_]]:
    """Whether each lane has passed the event that ends its leg; it is in that row of its log.

    And the lanes that have passed just this event, and may go on from there.
    """
    equations, records = expected.equations, lanes.records
    rows = records.events[:, row]
    times = rows["number"] * equations.legs.window + rows["phase"]
    passed = (
        (records.counters["events"] == row + 1)
        & (rows["kind"] != EventKind.GRAZE)
        & (rows["path"] == equations.word.path_bits[ends])
        & (np.abs(times - expected.instants[ends]) <= expected.allowed[ends])
    )
    for j in np.flatnonzero(~passed).tolist():
        found, passed[j] = _compare_one(expected, lanes, j, int(ends[j]))
        if not found.admissible:
            return found, passed
    return Admissibility(True), passed


def _first_event(lanes: _Lanes, j: int) -> int:
    """Row of the first event of a lane that is no tangency, -1 where there is none."""
    count = int(lanes.records.counters["events"][j])
    kinds = lanes.records.events["kind"][j, :count]
    rows = np.flatnonzero((kinds != EventKind.GRAZE) & (kinds != EventKind.START))
    return int(rows[0]) if rows.size else -1


def _compare_one(expected: _Expected, lanes: _Lanes, j: int, k: int) -> tuple[Admissibility, bool]:
    """Whether the first event of lane j is the one that ends leg k, at the expected instant.

    And whether it has come behind all of it.
    """
    equations, row = expected.equations, _first_event(lanes, j)
    if row >= 0:
        event, wanted = lanes.records.events[j, row], equations.word.paths[k]
        path = path_of_bits(int(event["path"]), int(event["passes"]))
        late = abs(_instant(equations, lanes, j, row) - float(expected.instants[k]))
        if late <= expected.allowed[k]:
            if path == wanted or (len(path or ()) > 1 and expected.leads_there(lanes, j, k)):
                return Admissibility(True), True
            if len(path or ()) < len(wanted) and _one_by_one(expected, lanes, j, k):
                return Admissibility(True), False
    if _rests_as_well(expected, k):
        return Admissibility(True), False
    return _instead(expected, lanes, j, k, row), False


def _rests_as_well(expected: _Expected, k: int) -> bool:
    """Whether leg k is a rebound before rest, of which the engine follows as many.

    From the middle of one it may take another number, where that is about to change.
    """
    word, wiring = expected.equations.word, expected.equations.legs.tables.wiring
    if not any(k in legs for legs in chatters(word.modes, word.paths, wiring)):
        return False
    guess = with_rebounds_of_engine(expected.equations, expected.turn, expected.tolerance)
    return guess is not None and guess.word == word


def _one_by_one(expected: _Expected, lanes: _Lanes, j: int, k: int) -> bool:
    """Whether lane j comes behind leg k by a few events in what is allowed of its instant.

    Guards that are met at one instant, as those of equal machines, part by rounding.
    """
    legs, following = expected.equations.legs, lanes
    end = float(expected.instants[k]) + float(expected.allowed[k])
    for _ in expected.equations.word.paths[k][1:]:
        here = following.anchors
        following = _start(legs, here.state[j : j + 1], np.array([end]), _ROWS)
        following.anchors.place[0], following.anchors.order[0] = here.place[j], here.order[j]
        j = 0
        _run(legs, following, np.array([GOES_ON]), end, expected.tolerance)
        if expected.leads_there(following, j, k):
            return True
        if following.records.counters["events"][0] == 0:
            break
    return False


def _instead(expected: _Expected, lanes: _Lanes, j: int, k: int, row: int) -> Admissibility:
    """What the engine finds instead of the event that ends leg k."""
    departure = Departure(
        expected.equations, expected.turn, k, float(expected.instants[k]),
        float(expected.allowed[k]), lanes.touches[j],
    )  # fmt: skip
    if row < 0:
        place = lanes.anchors.place
        instant = float(place["number"][j] * expected.equations.legs.window + place["phase"][j])
        reason = departure.without_event(Status(int(lanes.status[j])), instant)
        return Admissibility(False, reason, departure.leg_at(instant))
    event, instant = lanes.records.events[j, row], _instant(expected.equations, lanes, j, row)
    reason = departure.by_event(
        int(event["from_mode"]), int(event["path"]), int(event["passes"]), instant
    )
    path = path_of_bits(int(event["path"]), int(event["passes"])) or ()
    return Admissibility(False, reason, departure.leg_at(instant), path, departure.time(instant))


def _instant(equations: OrbitEquations, lanes: _Lanes, j: int, row: int) -> float:
    number = lanes.records.events["number"][j, row]
    return float(number * equations.legs.window + lanes.records.events["phase"][j, row])


def _name(equations: OrbitEquations, k: int) -> str:
    return equations.legs.system.mode_names[equations.word.modes[k]]
