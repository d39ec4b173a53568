"""Bounds on the work of a run: seconds and events after which it ends, with all that it has done.

The clock only decides when a run stops. The engine returns after a bounded amount of counted work,
and no digit depends on where.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from nonsmooth.engine.lanes import NO_LIMIT
from nonsmooth.runs.options import positive_number, whole_number

__all__ = ["UNLIMITED", "Limits", "limits_from"]


@dataclass(frozen=True)
class Limits:
    """Where a run has to stop: by the monotonic clock, and by the number of its events."""

    deadline: float = float("inf")
    most_events: int = NO_LIMIT

    @property
    def time_is_up(self) -> bool:
        """Whether the run has taken as long as it may."""
        return time.monotonic() >= self.deadline


UNLIMITED = Limits()


def limits_from(max_seconds: Any, max_events: Any) -> Limits:
    """Limits from the options of a run, counted from now; None is no limit."""
    deadline, most_events = UNLIMITED.deadline, UNLIMITED.most_events
    if max_seconds is not None:
        deadline = time.monotonic() + positive_number("max_seconds", max_seconds)
    if max_events is not None:
        most_events = whole_number("max_events", max_events)
    return Limits(deadline, most_events)
