"""ModeVisits to some modes: how many, how long, what part of the time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["ModeVisits", "visits_of"]

Floats = npt.NDArray[np.float64]


class ModeVisits(NamedTuple):
    """ModeVisits in order; the first may have begun before the record, the last end after it."""

    begin: Floats
    end: Floats
    begins_inside: npt.NDArray[np.bool_]
    ends_inside: npt.NDArray[np.bool_]

    @property
    def durations(self) -> Floats:
        """Those of the visits that lie in the record as a whole."""
        whole = self.begins_inside & self.ends_inside
        return (self.end - self.begin)[whole]


def visits_of(
    times: Floats,
    inside: npt.NDArray[np.bool_],
    at_first: bool,
    first: float,
    last: float,
) -> ModeVisits:
    """ModeVisits from changes: ``inside`` says where the motion is after each of the ``times``.

    Changes between two modes that are both meant do not end a visit.
    """
    before = np.concatenate([[at_first], inside])[:-1] if inside.size else inside
    enters, leaves = times[inside & ~before], times[before & ~inside]
    begins = np.concatenate([[first], enters]) if at_first else enters
    at_last = bool(inside[-1]) if inside.size else at_first
    ends = np.concatenate([leaves, [last]]) if at_last else leaves
    begins_inside, ends_inside = (np.ones(begins.size, bool) for _ in range(2))
    if at_first:
        begins_inside[0] = False
    if at_last:
        ends_inside[-1] = False
    return ModeVisits(begins, ends, begins_inside, ends_inside)
