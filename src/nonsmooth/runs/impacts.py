"""Which events are impacts, and how many a log tells of.

An impact is an exit that the model calls so, such as ``impact`` or ``upper_impact``, or one with a
reset. One row of the log may hold several of them, as where two balls arrive at one instant.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import exits_of_path
from nonsmooth.system.system import System

__all__ = ["Impacts", "happened", "impacts_of", "rows_passing"]

Integers = npt.NDArray[np.int64]
_WORD = "impact"


def happened(rows: Rows) -> npt.NDArray[np.bool_]:
    """Which rows are events: all but the start and tangencies, at which nothing changes."""
    kinds = rows["kind"]
    return np.asarray((kinds != EventKind.GRAZE) & (kinds != EventKind.START))


class Impacts:
    """Exits of a system that are impacts."""

    def __init__(self, system: System) -> None:
        exits = system.compiled.program.wiring.exits
        named = np.zeros(exits.shape, bool)
        for m, names in enumerate(system.compiled.exit_names):
            named[m, : len(names)] = [_WORD in name.split("_") for name in names]
        self._is_impact = named | exits["resetting"]["words"].any(axis=-1)
        self._leads_to_rest = np.zeros(exits.shape, bool)
        for m, e in np.argwhere(exits["onto"] >= 0):
            if exits["onto"][m, e] != e:
                self._leads_to_rest[m, exits["onto"][m, e]] = True
        self._targets = exits["target"]

    def count(self, rows: Rows) -> int:
        """Impacts among rows of the event log."""
        return int(self.in_rows(rows[happened(rows)]).sum())

    def in_rows(self, rows: Rows) -> Integers:
        """Impacts for which each row of an event log stands, (r,).

        Of more exits at one instant than a row remembers, the first ones count.
        """
        found = np.zeros(rows.size, np.int64)
        one, several = rows["passes"] == 1, rows["passes"] > 1
        found[one] = self._is_impact[rows["from_mode"][one], rows["exit"][one]]
        found[several] = _by_kind(rows[several], self._along)
        return found

    def _along(self, mode: int, path: int, passes: int) -> int:
        """Impacts along a path of exits; the one onto rest belongs to the impact before it."""
        count = 0
        for k, way in enumerate(exits_of_path(path, passes)):
            belongs = k > 0 and self._leads_to_rest[mode, way]
            count += int(self._is_impact[mode, way] and not belongs)
            mode = int(self._targets[mode, way])
        return count


def rows_passing(system: System, rows: Rows, exits: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Which rows of an event log pass one of some exits, the first one of an instant or not, (r,).

    shapes: exits (m, e)
    """
    targets = system.compiled.program.wiring.exits["target"]

    def passes(mode: int, path: int, count: int) -> int:
        for way in exits_of_path(path, count):
            if way < exits.shape[1] and exits[mode, way]:
                return 1
            mode = int(targets[mode, way])
        return 0

    found = (rows["exit"] >= 0) & exits[rows["from_mode"], rows["exit"]]
    several = (rows["passes"] > 1) & ~found
    found[several] = _by_kind(rows[several], passes) > 0
    return np.asarray(found)


def _by_kind(rows: Rows, told: Callable[[int, int, int], int]) -> Integers:
    """What is told of each row by its mode and path, asked once for rows that are alike."""
    kinds = columns(rows, "from_mode", "path", "passes")
    distinct, which = np.unique(kinds, axis=0, return_inverse=True)
    each = np.array([told(*map(int, kind)) for kind in distinct], np.int64)
    return np.asarray(each[which.ravel()])


@lru_cache(maxsize=32)
def impacts_of(system: System) -> Impacts:
    """Impacts of a system; the last few systems are remembered."""
    return Impacts(system)
