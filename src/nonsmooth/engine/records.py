"""Buffers that a run writes into and the anchor from which it can go on.

An anchor is the start of a segment: window number, phase, mode, states and the known
orders of zero. A run that ends in the middle of a segment keeps its anchor, so that
going on repeats the very same operations and the result does not depend on where a run
was cut.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.engine.layout import Floats, Integers

__all__ = ["Anchor", "Records", "allocate_anchor", "allocate_records", "with_fresh_events"]

# columns of Records.event_integers
NUMBER, KIND, FROM, TO, EXIT, PATH, PASSES, IS_CERTIFIED, COUNT = range(9)
EVENT_INTEGERS = 9
# columns of Records.event_floats; states before and states after follow. Rebounds that accumulate
# are passed at the last one that is followed, and are over some time later
PHASE, GUARD_RATE, WAIT = 0, 1, 2
EVENT_FLOATS = 3
# entries of Records.cursor
SAMPLES, EVENTS, WINDOW_EVENTS, UNCERTAIN, STALLED, SEGMENTS, REBOUNDS, LAST_EXIT = range(8)
CREEPING = 8
CURSOR = 9


class Anchor(NamedTuple):
    """Where a run goes on: the start of the current segment."""

    place: Integers  # (2,): window number, mode
    phase: Floats  # (1,)
    state: Floats  # (n,)
    order: Integers  # (e,)


class Records(NamedTuple):
    """Everything that a run writes."""

    sample_number: Integers  # (s,) window of each sample, in order of time
    sample_phase: Floats  # (s,)
    sample_state: Floats  # (s, n)
    sample_mode: Integers  # (s,)
    event_integers: Integers  # (c, EVENT_INTEGERS); c = 0 where events are not logged
    event_floats: Floats  # (c, EVENT_FLOATS + 2 n)
    cursor: Integers  # (CURSOR,): samples written, events logged, events in this window, uncertain
    # ones, events in a row between which time did not advance, segments of this call, impacts in a
    # row of one exit, and which exit that is, steps in a row that lead nowhere
    end_state: Floats  # (n,)
    since: Floats  # (2,): window number and phase up to which tangencies are logged


def allocate_anchor(sizes: Integers) -> Anchor:
    """Anchor at time zero."""
    n, n_exits = int(sizes[0]), int(sizes[5])
    return Anchor(np.zeros(2, np.int64), np.zeros(1), np.zeros(n), np.zeros(n_exits, np.int64))


def allocate_records(
    sizes: Integers, sample_number: Integers, sample_phase: Floats, capacity: int
) -> Records:
    """Buffers for given sample times and a number of events."""
    n = int(sizes[0])
    count = sample_number.size
    return Records(
        sample_number=sample_number,
        sample_phase=sample_phase,
        sample_state=np.full((count, n), np.nan),
        sample_mode=np.full(count, -1, np.int64),
        event_integers=np.empty((capacity, EVENT_INTEGERS), np.int64),
        event_floats=np.empty((capacity, EVENT_FLOATS + 2 * n)),
        cursor=np.zeros(CURSOR, np.int64),
        end_state=np.full(n, np.nan),
        since=np.full(2, -np.inf),
    )


def with_fresh_events(records: Records, capacity: int) -> Records:
    """The same records with an empty event buffer; the old one stays with who holds it."""
    records.cursor[EVENTS] = 0
    width = records.event_floats.shape[1]
    return records._replace(
        event_integers=np.empty((capacity, EVENT_INTEGERS), np.int64),
        event_floats=np.empty((capacity, width)),
    )
