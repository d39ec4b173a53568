"""The event log of a run while it grows, or only its end where it is not kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.records import Records, with_fresh_events
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

    def rows(self, records: Records) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
        """Rows that stay; no part of a buffer that is mostly empty and would stay in memory."""
        count = int(records.cursor[at.EVENTS])
        integers, floats = records.event_integers[:count], records.event_floats[:count]
        if 2 * count < len(records.event_integers):
            return integers.copy(), floats.copy()
        return integers, floats

    def _leave_out(self, records: Records) -> None:
        """Empty the buffer but for its end, of which tangencies passed by are no part."""
        count = int(records.cursor[at.EVENTS])
        end = np.flatnonzero(records.event_integers[:count, at.KIND] != EventKind.GRAZE)[-_END:]
        for buffer in (records.event_integers, records.event_floats):
            buffer[: end.size] = buffer[end]
        records.cursor[at.EVENTS] = end.size
        self.n_left_out += count - end.size


def _enlarged(records: Records, share: float) -> Records:
    """Records with room for the events that the run will probably need.

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
