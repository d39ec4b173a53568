"""The event log of a run while it grows, or only its end where it is not kept."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.engine.lanes import Records
from nonsmooth.engine.record import Floats, Rows, zeros
from nonsmooth.engine.status import EventKind
from nonsmooth.errors import OptionError
from nonsmooth.runs.memory import free_memory, size_text

__all__ = ["FIRST_CAPACITY", "EventLog", "LentRoom", "lent_room"]

FIRST_CAPACITY = 1024  # events in the first buffer
_LARGE = 65536
_SPARE = 1.1  # events come unevenly
# Rows that stay where the log is not kept: as many as a phase word of the last period can
# need, after impacts that ended the run at one instant.
_END = 256
# Room that a thread keeps for the log of its next run; beyond that a run asks for its own.
_LENT_ROWS = 16384
_LENT_STATES = 16
_kept = threading.local()


class LentRoom(NamedTuple):
    """Room for an event log that outlives a run: memory that is new costs more than to fill it."""

    events: Rows  # (c,)
    numbers: Floats  # flat: states before and after each event

    def put_into(self, records: Records) -> Records:
        """Records that write their log here."""
        n = records.end_state.size
        if n > _LENT_STATES:
            return records
        states = self.numbers[: 2 * n * self.events.size].reshape(-1, 2, n)
        return records.replace(events=self.events, event_states=states)


@contextmanager
def lent_room() -> Iterator[LentRoom]:
    """Room of this thread, for one run at a time; what is to stay of its log has to be copied."""
    room: LentRoom | None = getattr(_kept, "room", None)
    _kept.room = None  # a run within this one gets its own
    if room is None:
        events = zeros(Records.struct, events=(1, _LENT_ROWS))["events"][0]
        room = LentRoom(events, np.empty(2 * _LENT_STATES * _LENT_ROWS))
    try:
        yield room
    finally:
        _kept.room = room


@dataclass
class EventLog:
    """Makes room in the event buffer; ``keep`` says whether all rows stay.

    With ``lent`` the rows may stay in the buffer, which somebody else copies. ``most`` is how many
    events the run may have at most; None where the clock may end it at any of them.
    """

    keep: bool
    n_left_out: int = 0
    lent: bool = False
    most: float | None = np.inf

    def make_room(self, records: Records, share: float) -> Records:
        """Records to go on with when the buffer is full and a ``share`` of the run is done."""
        if self.keep:
            self._check_room(records, share)
            return _enlarged(records, share)
        self._leave_out(records)
        return records

    def _check_room(self, records: Records, share: float) -> None:
        """Refuse a log for which there is no memory, once events are many enough to tell."""
        count = records.n_events
        if count < _LARGE or self.most is None or share <= 0.0:
            return
        expected = min(count / share, self.most)
        # the result has the rows once more, as variables
        need = 2.0 * expected * (records.events.itemsize + records.event_states[0].nbytes)
        if need > (free := free_memory()):
            raise OptionError(
                f"the log of about {expected:.2g} events takes {size_text(need)}, and"
                f" {size_text(free)} of memory are free: keep no log by events=False, or shorten"
                " the run and go on from run to run"
            )

    def rows(self, records: Records) -> tuple[Rows, Floats]:
        """Rows that stay, and states before and after each event, (rows, 2, n).

        They are no part of a buffer that is mostly empty and would stay in memory.
        """
        count = records.n_events
        rows, states = records.events[:count], records.event_states[:count]
        if 2 * count < len(records.events) and not self.lent:
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
