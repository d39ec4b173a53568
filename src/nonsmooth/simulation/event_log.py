"""The event log of a run while it grows, or only its end where it is not kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.engine.lanes import Records
from nonsmooth.engine.record import Floats, Rows
from nonsmooth.engine.status import EventKind

__all__ = ["FIRST_CAPACITY", "EventLog"]

FIRST_CAPACITY = 1024  # events in the first buffer
_LARGE = 65536
_SPARE = 1.1  # events come unevenly
# Rows that stay where the log is not kept: as many as a phase word of the last period can
# need, after impacts that ended the run at one instant.
_END = 256


@dataclass
class EventLog:
    """Makes room in the event buffer; ``keep`` says whether all rows stay."""

    keep: bool
    n_left_out: int = 0

    def make_room(self, records: Records, share: float) -> Records:
        """Records to go on with when the buffer is full and a ``share`` of the run is done."""
        if self.keep:
            return _enlarged(records, share)
        self._leave_out(records)
        return records

    def rows(self, records: Records) -> tuple[Rows, Floats]:
        """Rows that stay, and states before and after each event, (rows, 2, n).

        They are no part of a buffer that is mostly empty and would stay in memory.
        """
        count = records.n_events
        rows, states = records.events[:count], records.event_states[:count]
        if 2 * count < len(records.events):
            return rows.copy(), states.copy()
        return rows, states

    def _leave_out(self, records: Records) -> None:
        """Empty the buffer but for its end, of which tangencies passed by are no part."""
        count = records.n_events
        end = np.flatnonzero(records.events["kind"][:count] != EventKind.GRAZE)[-_END:]
        for buffer in (records.events, records.event_states):
            buffer[: end.size] = buffer[end]
        records.counters["events"] = end.size
        self.n_left_out += count - end.size


def _enlarged(records: Records, share: float) -> Records:
    """Records with room for the events that the run will probably need.

    Memory that is asked for and never written costs nothing, while every further buffer
    is one more copy of the log.
    """
    count = records.n_events
    expected = _SPARE * count / share if share > 0.0 else np.inf
    room = int(np.clip(expected, 2 * count, max(4 * count, _LARGE)))
    rows, states = records.events, records.event_states
    larger = records.replace(
        events=np.empty(room, rows.dtype), event_states=np.empty((room, *states.shape[1:]))
    )
    larger.events[:count], larger.event_states[:count] = rows[:count], states[:count]
    return larger
