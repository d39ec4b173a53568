"""The engine loop: flow, first crossing, transition, again and again.

Segments run from an event to the next one, to the end of the forcing period or to the next
knot of a signal, never to a sample or to the end asked for: both only read the closed form.
So neither the sampling
nor the end of a run can change the trajectory.
"""

from __future__ import annotations

import math

from nonsmooth.engine import layout as at
from nonsmooth.engine.arrays import copy_matrix, copy_vector
from nonsmooth.engine.event_log import log_event, log_transition, normal_phase
from nonsmooth.engine.first_crossing import CERTIFIED, GRAZE, NONE, STUCK, first_crossing
from nonsmooth.engine.flow import advance, advance_once, start_segment, state_at
from nonsmooth.engine.guard_values import fill_extent, guard_exceeds, guard_holds
from nonsmooth.engine.jit import inlined, kernel
from nonsmooth.engine.linear_flow import augmented
from nonsmooth.engine.linearisation import linearise_mode
from nonsmooth.engine.placement import slaved_agree
from nonsmooth.engine.rebounds import NEVER
from nonsmooth.engine.records import (
    COUNT,
    CREEPING,
    EVENT_FLOATS,
    EVENTS,
    EXIT,
    LAST_EXIT,
    REBOUNDS,
    SAMPLES,
    SEGMENTS,
    STALLED,
    TO,
    UNCERTAIN,
    WAIT,
    WINDOW_EVENTS,
)
from nonsmooth.engine.signals import fill_signals
from nonsmooth.engine.solved_relations import settle
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.surfaces import count_bits, in_cell, leaves_both_ways
from nonsmooth.engine.tangent import carry, complete_columns, start_columns
from nonsmooth.engine.transitions import PATH_BITS, has_fallen, pass_exits
from nonsmooth.engine.zeros import STILL_ZERO

__all__ = ["ANY", "GOES_ON", "SAME", "run_lane"]

# modes in which a run begins: the first that fits; none, it goes on; SAME - m is m in any case
ANY, GOES_ON, SAME = -1, -2, -3
_COMPLETED = int(Status.COMPLETED)
_DIVERGED = int(Status.DIVERGED)
_NONUNIQUE = int(Status.NONUNIQUE)
_EVENT_LIMIT = int(Status.EVENT_LIMIT)
_STEP_LIMIT = int(Status.STEP_LIMIT)
_INADMISSIBLE = int(Status.INADMISSIBLE)
_PAUSED = int(Status.PAUSED)
_SINGULAR = int(Status.SINGULAR)
_BUFFER_FULL = int(Status.BUFFER_FULL)
_CHATTER = int(EventKind.CHATTER)
_RELEASE = int(EventKind.RELEASE)
_SLIDE_ENTRY = int(EventKind.SLIDE_ENTRY)
_SLIDE_EXIT = int(EventKind.SLIDE_EXIT)
_START = int(EventKind.START)
_STICK = int(EventKind.STICK)
_SWITCH = int(EventKind.SWITCH)
_IMPACT = int(EventKind.IMPACT)
_GRAZE = int(EventKind.GRAZE)
_CORNER = int(EventKind.CORNER)
_MOST_EVENTS = 10_000  # in one window; more means that impacts accumulate
_MOST_STALLED = 100  # between which time does not advance: likewise
_MOST_SEGMENTS = 100_000  # in one call, so that a run of short steps can be interrupted
_LITTLE_TIME = 1e-8  # part of a window; flights of impacts that rounding leaves open
_NO_TIME, _FEW = 1e-10, 5  # part of a window; events before that in the same window
# Part of a window, or of what is left of the run: a shorter step of a series means that it does not
# converge. The window of a system without a period is as long as its slowest rates at rest.
_SHORTEST = 1e-14
# Part of a window, or of what is left of the run: steps of a series so short, and as many of them
# in a row, mean that the run would go on for hours. Chirps do so, sin(y) where y grows and grows.
_CREEP, _MOST_CREEPING = 2e-7, 100_000
_FOLD = 1e-6  # part of the terms of a guard below which both sides of a surface are at a fold
_MOST_SIZE = 1e30  # of a state that does not drift


@inlined
def run_lane(
    tables, rates, scratch, anchor, segment, tangent, records, mode, end_number, end_phase,
    tolerance,
):  # fmt: skip
    """Run from a start or an anchor to a time given as window number and phase.

    shapes: see `Anchor`, `Segment`, `Tangent`, `Records`; all of them are changed in place.
    mode = GOES_ON goes on from the anchor. Others make a start there, with columns of derivatives
    that begin there too: mode = ANY takes the first mode that fits, a number that one if it does.
    mode = SAME - m enters mode m after parameters have changed, whether it fits or not, and
    derivatives go on.
    status: COMPLETED, STOPPED, DIVERGED, UNDECIDED, INADMISSIBLE when no mode fits, NONUNIQUE when
    cells on both sides of a surface do, EVENT_LIMIT, STEP_LIMIT, SINGULAR, SLIDING, BUFFER_FULL
    (call again with GOES_ON after emptying the event buffer) or PAUSED (call again)
    """
    window = tables.clock[0]
    place, cursor = anchor.place, records.cursor
    carrying = tangent.columns.shape[0] > 0
    _augment(tables, anchor.state, place[0], anchor.phase[0], segment.z)
    if tables.signals.shape[0] > 0:
        _fill_signals(tables, segment, place[0], anchor.phase[0])
    begins = mode != GOES_ON
    if begins:
        place[1] = _mode_of_start(tables, rates, segment, mode, tolerance)
        if place[1] < 0:
            return _INADMISSIBLE
        if mode >= ANY:
            start_columns(tables.sizes[0], tangent)
    if carrying:
        complete_columns(tables, rates, tangent, place[0], anchor.phase[0], segment.z)
    while True:
        m, phase = place[1], anchor.phase[0]
        s, e, found = 0.0, -1, CERTIFIED
        if not begins:
            room = records.event_floats.shape[0]
            if room > 0 and cursor[EVENTS] >= room - 1:
                return _BUFFER_FULL
            if cursor[SEGMENTS] > _MOST_SEGMENTS:
                cursor[SEGMENTS] = 0
                return _PAUSED
            cursor[SEGMENTS] += 1
            whole = at.WINDOWS * window - phase
            copy_vector(anchor.order, segment.order, anchor.order.size)
            longest = min(whole, segment.to_knot[0])
            length = start_segment(tables, rates, segment, m, longest)
            end = (end_number - place[0]) * window + (end_phase - phase)
            long_enough = length == longest or length > _SHORTEST * (min(window, end) + phase)
            if tables.kinds[m] == at.TAYLOR and not long_enough:
                return _NONUNIQUE if _at_two_fold(tables, rates, segment, m) else _SINGULAR
            s, e, found = _search(tables, segment, anchor, records, m, length, end)
            _write_samples(
                tables, rates, scratch, segment, anchor, tangent, records, m, min(s, end)
            )
            if end <= s:
                advance_once(tables, segment, m, end)
                state_at(tables, segment, m, records.end_state)
                records.since[0], records.since[1] = end_number, end_phase
                if _bounded(tables.drifting, records.end_state):
                    return _COMPLETED
                anchor.phase[0] = phase + end
                return _DIVERGED
            if found == STUCK:
                # a flight too short to be told from none is the end of accumulating impacts
                accumulate = s <= _NO_TIME * window and cursor[WINDOW_EVENTS] > _FEW
                if accumulate:
                    return _EVENT_LIMIT
                return _SINGULAR if tables.kinds[m] == at.TAYLOR else _STEP_LIMIT
            if carrying:
                carry(tables, rates, scratch, segment, tangent, m, s)
                copy_matrix(tangent.now, tangent.columns)
            state_at(tables, segment, m, anchor.state)
            copy_vector(anchor.state, records.end_state, anchor.state.size)
            if not _bounded(tables.drifting, anchor.state):
                anchor.phase[0] = phase + s
                return _DIVERGED
            if e < 0:
                if tables.kinds[m] == at.TAYLOR and _creeps(cursor, length, longest, window, end):
                    anchor.phase[0] = phase + s
                    return _STEP_LIMIT
                _move_anchor(tables, anchor, segment.order, cursor, length, whole)
                _augment(tables, anchor.state, place[0], anchor.phase[0], segment.z)
                if carrying:
                    complete_columns(tables, rates, tangent, place[0], anchor.phase[0], segment.z)
                # behind a knot even a guard may jump, by the rate of a signal
                if tables.signals.shape[0] == 0 or not _pass_knot(
                    tables, rates, segment, anchor, m
                ):
                    continue
                s, found = 0.0, CERTIFIED
        status = _pass_event(
            tables, rates, segment, tangent, anchor, records, s, e, found, mode, begins, tolerance
        )
        if status != _COMPLETED:
            return status
        # a start may lie, and a slide may end, where both sides of a surface lead away from it
        slid = tables.wiring[m, 0, at.KIND] == at.SLIDES and not begins
        if (begins and mode == ANY) or slid:
            g = leaves_both_ways(tables, rates, segment, place[1], tolerance)
            choice = tables.wiring[place[1], 1 + g, at.CHOICE] if g >= 0 else at.STAY
            if choice == at.NO_CHOICE:
                return _NONUNIQUE
            if choice == at.CROSS:
                place[1] = tables.wiring[place[1], 1 + g, at.TARGET]
                for k in range(anchor.order.size):
                    anchor.order[k] = 0
                if cursor[EVENTS] > 0:
                    records.event_integers[cursor[EVENTS] - 1, TO] = place[1]
        begins = False


@kernel
def _creeps(cursor, length, longest, window, end):
    """Count a step; whether too many in a row were so short that nothing but they limits them."""
    short = length < longest and length < _CREEP * min(window, end)
    cursor[CREEPING] = cursor[CREEPING] + 1 if short else 0
    return cursor[CREEPING] > _MOST_CREEPING


@kernel
def _at_two_fold(tables, rates, segment, m):
    """Whether motion slides to where both sides of its surface begin to lead away from it."""
    if tables.wiring[m, 0, at.KIND] != at.SLIDES:
        return False
    linearise_mode(tables, rates, segment, m)
    fill_extent(tables.sizes[0], tables.affine, tables.wiring, m, segment.z, segment.extent)
    for g in range(2):  # those through which it leaves the surface
        if guard_exceeds(tables.affine, m, g, segment.z, segment.extent, _FOLD):
            return False
    return True


@kernel
def _mode_of_start(tables, rates, segment, mode, tolerance):
    """The first mode that admits segment.z among those that ``mode`` asks for, or -1."""
    if mode <= SAME:
        return SAME - mode
    low, high = (0, tables.affine.shape[0]) if mode == ANY else (mode, mode + 1)
    z, given = segment.z, segment.spare
    _take_rest(tables, z, segment.left_out)
    copy_vector(z, given, z.size)
    for m in range(low, high):
        if tables.wiring[m, 0, at.IMPLICIT] == 0 or settle(tables, rates, segment, m):
            linearise_mode(tables, rates, segment, m)
            if _fits(tables, segment, m, given, tolerance):
                return m
        copy_vector(given, z, z.size)
    if segment.left_out[0] != 0:
        for m in range(low, high):
            k = _mode_behind(tables, rates, segment, m, low, high, tolerance)
            if k >= 0:
                return k
            copy_vector(given, z, z.size)
    return -1


@kernel
def _mode_behind(tables, rates, segment, m, low, high, tolerance):
    """The first mode that admits the place that mode m wants for what a start leaves out, or -1.

    A rotor that is pressed against its ring and moves away is free at once, with the ring there.
    """
    n, z, place = tables.sizes[0], segment.z, segment.mark
    if tables.wiring[m, 0, at.IMPLICIT] == 0 or not settle(tables, rates, segment, m):
        return -1
    linearise_mode(tables, rates, segment, m)
    fill_extent(n, tables.affine, tables.wiring, m, z, segment.extent)
    if not in_cell(tables, m, z, segment.extent, tolerance):
        return -1
    copy_vector(z, place, z.size)
    for k in range(low, high):
        if tables.wiring[k, 0, at.IMPLICIT] == 0:
            linearise_mode(tables, rates, segment, k)
            if _fits(tables, segment, k, place, tolerance):
                return k
    return -1


@kernel
def _take_rest(tables, z, left_out):
    """Put states that a start leaves out, as nan, to rest; those that are slaved follow later."""
    left_out[0] = 0
    for i in range(tables.sizes[0]):
        if math.isnan(z[i]):
            left_out[0] |= 1 << i
            slot = tables.rest_slots[i]
            z[i] = tables.values[slot] if slot >= 0 else 0.0


@kernel
def _fits(tables, segment, m, given, tolerance):
    """Whether guards hold and the slaved states that were given agree with their relations."""
    n, affine, wiring, z = tables.sizes[0], tables.affine, tables.wiring, segment.z
    fill_extent(n, affine, wiring, m, z, segment.extent)
    for g in range(wiring[m, 0, at.N_EXITS]):
        if not guard_holds(affine, m, g, z, segment.extent, tolerance):
            return False
    left_out = segment.left_out[0]
    return slaved_agree(n, affine, wiring, m, z, segment.extent, given, left_out, tolerance)


@inlined
def _augment(tables, state, number, phase, z):
    n, powers = tables.sizes[0], tables.sizes[1]
    copy_vector(state, z, n)
    augmented(n, powers, tables.clock[0], tables.harmonics, number, phase, z)


@kernel
def _pass_knot(tables, rates, segment, anchor, m):
    """Fill the signals at a new anchor; whether a guard has jumped below zero there."""
    _fill_signals(tables, segment, anchor.place[0], anchor.phase[0])
    return has_fallen(tables, rates, segment, m)


@kernel
def _fill_signals(tables, segment, number, phase):
    """Values of the signals at an instant, and the time to the next knot."""
    window, first = tables.clock[0], at.first_of_signals(tables.sizes)
    segment.to_knot[0] = fill_signals(
        tables.signals, tables.knots, first, window, number, phase, segment.z
    )


@kernel
def _move_anchor(tables, anchor, order, cursor, length, whole):
    """Move the anchor to the end of a segment without an event."""
    place, window = anchor.place, tables.clock[0]
    smooth = tables.signals.shape[0] == 0  # behind a knot a guard that has been zero may leave it
    if length < whole:
        number, anchor.phase[0] = normal_phase(place[0], anchor.phase[0] + length, window)
    else:
        number, anchor.phase[0] = place[0] + at.WINDOWS, 0.0
    if number > place[0]:
        cursor[WINDOW_EVENTS] = 0
    place[0] = number
    for g in range(anchor.order.size):
        anchor.order[g] = STILL_ZERO if smooth and order[g] >= STILL_ZERO else 0


@inlined
def _search(tables, segment, anchor, records, m, length, end):
    """First crossing of the segment; tangencies that rounding leaves open are logged.

    Only those between the last end and this one: the segment may begin before, and is
    searched again when the run goes on.
    """
    s = 0.0
    for g in range(segment.scan.shape[0]):
        segment.scan[g, at.PASSED] = 0.0
    while True:
        s, e, found = first_crossing(tables, segment, m, s, length)
        if found != GRAZE:
            return s, e, found
        if s >= end:
            return s, -1, NONE
        since = (records.since[0] - anchor.place[0]) * tables.clock[0] + (
            records.since[1] - anchor.phase[0]
        )
        if s >= since:
            records.cursor[UNCERTAIN] += 1
            _log_crossing(tables, segment, anchor, records, s, e, _GRAZE, False)


@inlined
def _write_samples(tables, rates, scratch, segment, anchor, tangent, records, m, until):
    """Samples of this segment up to and including ``until``.

    The slots at the end of the segment are put back bit by bit: the last step to an event
    is rounded differently from a direct evaluation.
    """
    number, phase, window = anchor.place[0], anchor.phase[0], tables.clock[0]
    k = records.cursor[SAMPLES]
    kept, point = False, 0.0
    while k < records.sample_phase.size:
        s = (records.sample_number[k] - number) * window + (records.sample_phase[k] - phase)
        if s > until:
            break
        if not kept:
            copy_matrix(segment.now, segment.kept)
            point = segment.point[0]
            kept = True
        if s == 0.0:  # the state as it was given, not as it comes back from modal coordinates
            copy_vector(anchor.state, records.sample_state[k], anchor.state.size)
        else:
            advance(tables, segment, m, s)
            state_at(tables, segment, m, records.sample_state[k])
        if tangent.columns.shape[0] > 0:
            _write_columns(tables, rates, scratch, segment, tangent, m, s, k)
        records.sample_mode[k] = m
        k += 1
    records.cursor[SAMPLES] = k
    if kept:
        copy_matrix(segment.kept, segment.now)
        segment.point[0] = point


@kernel
def _write_columns(tables, rates, scratch, segment, tangent, m, s, k):
    """Columns of derivatives at a sample."""
    columns = tangent.columns
    if s > 0.0:
        carry(tables, rates, scratch, segment, tangent, m, s)
        columns = tangent.now
    for c in range(columns.shape[0]):
        for i in range(tables.sizes[0]):
            tangent.samples[k, c, i] = columns[c, i]


@inlined
def _log_crossing(tables, segment, anchor, records, s, e, kind, certified):
    """Log an event at s of the segment with the state before it; returns its row."""
    n, m = tables.sizes[0], anchor.place[1]
    number, phase = normal_phase(anchor.place[0], anchor.phase[0] + s, tables.clock[0])
    rate = segment.scan[e, 1] if e >= 0 else 0.0
    row = log_event(records, number, phase, kind, m, e, certified, rate)
    if row >= 0:
        before = records.event_floats[row, EVENT_FLOATS : EVENT_FLOATS + n]
        if e >= 0:
            state_at(tables, segment, m, before)
        else:
            copy_vector(anchor.state, before, n)
        for i in range(n):
            records.event_floats[row, EVENT_FLOATS + n + i] = before[i]
    return row


@inlined
def _pass_event(
    tables, rates, segment, tangent, anchor, records, s, e, found, mode, begins, tolerance
):
    """Log an event, pass its exits and set the anchor behind it.

    e = -1 at a start, and at a knot where guards have jumped: what is negative fires
    """
    n, m = tables.sizes[0], anchor.place[1]
    cursor = records.cursor
    row = -1
    if not begins:
        row = _log_crossing(tables, segment, anchor, records, s, e, _SWITCH, found == CERTIFIED)
    if found != CERTIFIED:
        cursor[UNCERTAIN] += 1
    number, phase = normal_phase(anchor.place[0], anchor.phase[0] + s, tables.clock[0])
    if not begins:
        stalled = number == anchor.place[0] and phase == anchor.phase[0]
        # flights that rounding alone makes are no motion either
        stalled = stalled or (found != CERTIFIED and s <= _LITTLE_TIME * tables.clock[0])
        cursor[STALLED] = cursor[STALLED] + 1 if stalled else 0
        cursor[WINDOW_EVENTS] = 1 if number > anchor.place[0] else cursor[WINDOW_EVENTS] + 1
        _augment(tables, anchor.state, number, phase, segment.z)
        if tables.signals.shape[0] > 0:
            _fill_signals(tables, segment, number, phase)
        if tangent.columns.shape[0] > 0:
            complete_columns(tables, rates, tangent, number, phase, segment.z)
    status, m, path, passes, jumped, corner, stay = pass_exits(
        tables, rates, segment, tangent, m, e, s, tolerance
    )
    before = anchor.place[1]
    kind = _kind_of(tables.wiring, before, m, jumped, corner, stay)
    if begins:
        kind = _START if mode >= ANY else _SWITCH
        row = _log_start(anchor, records, kind, passes, n)
    log_transition(records, row, kind, m, path, passes, segment.z)
    rebounds = _count_rebounds(cursor, kind, before, e)
    if row >= 0 and kind == _CHATTER:
        records.event_floats[row, WAIT] = stay
        records.event_integers[row, COUNT] = rebounds
    if kind != _START and e < 0 and row >= 0:
        records.event_integers[row, EXIT] = path % (1 << PATH_BITS) - 1
    anchor.place[0], anchor.place[1] = number, m
    anchor.phase[0] = phase
    _set_anchor(anchor, segment, records, n)
    if begins:
        return status
    accumulated = cursor[WINDOW_EVENTS] > _MOST_EVENTS or cursor[STALLED] > _MOST_STALLED
    if status == _COMPLETED and not _finite(anchor.state):
        return _SINGULAR  # the reset divides by zero
    if status == _COMPLETED and accumulated:
        return _EVENT_LIMIT
    return status


@kernel
def _kind_of(wiring, before, after, jumped, corner, stay):
    """What an event is, by the kinds of the cells before and after it."""
    on_before, on_after = wiring[before, 0, at.KIND], wiring[after, 0, at.KIND]
    if stay != NEVER and on_after == at.RESTING:
        return _CHATTER if stay > 0.0 else _STICK
    if on_before == at.RESTING and on_after != at.RESTING and not jumped:
        return _RELEASE
    if not jumped and (on_before == at.SLIDES or on_after == at.SLIDES):
        # along one surface more, or one less
        more = _surfaces_held(wiring, after) - _surfaces_held(wiring, before)
        if more > 0:
            return _SLIDE_ENTRY
        if more < 0 and on_after != at.RESTING:
            return _SLIDE_EXIT
    return _CORNER if corner else (_IMPACT if jumped else _SWITCH)


@kernel
def _surfaces_held(wiring, m):
    """Number of surfaces along which a cell slides, or none."""
    if wiring[m, 0, at.KIND] != at.SLIDES:
        return 0
    return max(1, count_bits(wiring[m, 0, at.SLAVED]))


@kernel
def _count_rebounds(cursor, kind, m, e):
    """Impacts in a row of one exit, this one included."""
    if kind != _IMPACT and kind != _CHATTER:
        cursor[LAST_EXIT] = -1
        return 0
    this = (m << PATH_BITS) + e + 1
    cursor[REBOUNDS] = cursor[REBOUNDS] + 1 if cursor[LAST_EXIT] == this else 1
    cursor[LAST_EXIT] = this
    return cursor[REBOUNDS]


@kernel
def _log_start(anchor, records, kind, passes, n):
    """Log a start with the state as given; going on in the same mode is no event."""
    if kind != _START and passes == 0:
        return -1
    row = log_event(records, anchor.place[0], anchor.phase[0], kind, anchor.place[1], -1, True, 0.0)
    if row >= 0:
        for i in range(n):
            records.event_floats[row, EVENT_FLOATS + i] = anchor.state[i]
    return row


@inlined
def _set_anchor(anchor, segment, records, n):
    copy_vector(segment.z, anchor.state, n)
    copy_vector(segment.z, records.end_state, n)
    copy_vector(segment.order, anchor.order, anchor.order.size)


@kernel
def _finite(state):
    for i in range(state.size):
        if not math.isfinite(state[i]):
            return False
    return True


@kernel
def _bounded(drifting, state):
    if not _finite(state):
        return False
    for i in range(state.size):
        if abs(state[i]) > _MOST_SIZE and not (drifting >> i) & 1:
            return False
    return True
