"""The event log of a run while it grows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.records import Records, with_fresh_events

__all__ = ["FIRST_CAPACITY", "event_rows", "make_room"]

FIRST_CAPACITY = 1024  # events in the first buffer
_LARGE = 65536
_SPARE = 1.1  # events come unevenly


def make_room(records: Records, share: float) -> Records:
    """Records with room for the events that a run will probably need; ``share`` of it is done.

    Memory that is asked for and never written costs nothing, while every further buffer
    is one more copy of the log.
    """
    count = int(records.cursor[at.EVENTS])
    expected = _SPARE * count / share if share > 0.0 else np.inf
    larger = with_fresh_events(records, int(np.clip(expected, 2 * count, max(4 * count, _LARGE))))
    larger.event_integers[:count] = records.event_integers[:count]
    larger.event_floats[:count] = records.event_floats[:count]
    larger.cursor[at.EVENTS] = count
    return larger


def event_rows(records: Records) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Rows of the log; no part of a buffer that is mostly empty, which would stay in memory."""
    count = int(records.cursor[at.EVENTS])
    integers, floats = records.event_integers[:count], records.event_floats[:count]
    if 2 * count < len(records.event_integers):
        return integers.copy(), floats.copy()
    return integers, floats
