"""Instants of events in short runs, and by how much they change.

The instant of an event changes by what its guard changes, over the rate of the guard. The guard
changes with the state just before the event and by parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import Records, Segment, allocate_tangent
from nonsmooth.engine.orbits import WordLegs, allocate_leg_results, pass_legs
from nonsmooth.engine.record import Rows
from nonsmooth.engine.tables import PATH_LENGTH, Tables
from nonsmooth.runs.runner import Derivatives
from nonsmooth.runs.section_search import NamedEvents

__all__ = ["EventInstants", "named_events", "rates_of_instants"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class EventInstants(NamedTuple):
    """When events of some names happen in a flight, and by how much that changes."""

    times: Floats  # (E,), in order
    name: Integers  # (E,): which of the names
    columns: Floats  # (E, n + p): derivatives of the instants by start and parameters


def named_events(picks: Sequence[NamedEvents], log: Records) -> tuple[Rows, Floats, Integers]:
    """Rows of a log that are looked for, in order of time, the states before, and their names."""
    rows, states = log.events[: log.n_events], log.event_states[: log.n_events]
    found = [pick(rows, states)[0].row for pick in picks]
    meant = np.concatenate(found)
    of = np.repeat(np.arange(len(found)), [each.size for each in found])
    order = np.argsort(meant, kind="stable")
    meant = meant[order]
    return rows[meant], states[meant, 0], of[order]


def rates_of_instants(
    tables: Tables,
    derivatives: Derivatives,
    segment: Segment,
    rows: Rows,
    states: Floats,
    times: Floats,
    columns: Floats,
) -> Floats | None:
    """Derivatives of the instants of events, (E, n + p); None where a guard only touches zero.

    shapes: states (E, n) before the events, columns (E, n, n + p) of derivatives there
    """
    count, (n, width) = times.size, columns.shape[1:]
    if not count:
        return np.zeros((0, width))
    paths = np.full((count, PATH_LENGTH), -1, np.int64)
    paths[:, 0] = rows["exit"]
    modes, states, times = (
        np.ascontiguousarray(each) for each in (rows["from_mode"], states, times)
    )
    found = allocate_leg_results(tables.sizes, width - n, count)
    passed = pass_legs(
        tables, derivatives.rates, derivatives.scratch, segment,
        allocate_tangent(tables.sizes, width - n, 1),
        WordLegs(modes, paths, states, times, times), found,
    )  # fmt: skip
    if passed < count or not np.all(found.guard_rate):
        return None
    change = np.einsum("en,enc->ec", found.guard_row[:, :n], columns)
    change[:, n:] += found.guard_row[:, n:]
    moved: Floats = -change / found.guard_rate[:, None]
    return moved
