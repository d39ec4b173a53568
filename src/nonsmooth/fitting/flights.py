"""Short runs with derivatives, many with the same parameters: the segments of a record.

Segments begin at different times and have different samples, so each is a lane of its own; the
tables and their derivatives by parameters are set up once for all of them.

The instant of an event changes by what its guard changes, over the rate of the guard. The guard
changes with the state just before the event, which a second run samples there, and by parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    ANY,
    Records,
    Tangent,
    allocate_anchor,
    allocate_columns,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
)
from nonsmooth.engine.orbits import WordLegs, allocate_leg_results, pass_legs
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import PATH_LENGTH
from nonsmooth.errors import ModelError
from nonsmooth.fitting.observation import MotionSamples
from nonsmooth.runs.clock import instants
from nonsmooth.runs.runner import NO_DERIVATIVES, build_derivatives, build_tables
from nonsmooth.runs.section_search import NamedEvents
from nonsmooth.system.model.value_checks import sure_values
from nonsmooth.system.system import System

__all__ = ["EventInstants", "Flight", "Flights"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_FIRST_ROOM = 64  # events of a flight; the room doubles where they are more
_BEFORE = 1e-9  # of a window: the state just before an event is sampled so much earlier


class EventInstants(NamedTuple):
    """When events of some names happen in a flight, and by how much that changes."""

    times: Floats  # (E,), in order
    name: Integers  # (E,): which of the names
    columns: Floats  # (E, n + p): derivatives of the instants by start and parameters


class Flight(NamedTuple):
    """States at the samples of a run, and their derivatives by start and parameters."""

    samples: MotionSamples  # K of them
    columns: Floats  # (K, n, n + p)
    events: EventInstants | None = None  # where events were asked for


class Flights:
    """Runs of a system at the values of the last `set_up`."""

    def __init__(
        self, system: System, chosen: Sequence[str], tolerance: float, events: Sequence[str] = ()
    ) -> None:
        self.system, self.chosen, self.tolerance = system, tuple(chosen), tolerance
        self.n = len(system.states)
        self.n_runs = 0
        self.values: dict[str, float] = {}
        self._picks = [NamedEvents(system, name) for name in events]
        self._room = _FIRST_ROOM

    def set_up(self, changed: dict[str, float]) -> bool:
        """Take values of the chosen parameters; whether the system admits them."""
        values = self.system.parameter_values | changed
        if values == self.values:
            return True
        self.values = {}
        grids = {name: np.array([value]) for name, value in changed.items()}
        try:
            if not sure_values(self.system, grids)[0]:
                self.system.with_parameters(**changed)
            self.tables = build_tables(self.system, values)
            self._derivatives = build_derivatives(self.system, self.tables, self.chosen, values)
        except ModelError:
            return False
        self._segment = allocate_segment(self.tables.sizes, len(self.chosen))
        self._scratch: Tangent | None = None
        self.values = values
        return True

    @property
    def window(self) -> float:
        """Length of a window: the period, where there is one."""
        return self.tables.window

    def fly(
        self, state: Floats, begin: float, times: Floats, *, events: bool = False
    ) -> Flight | None:
        """Run through some times, not decreasing; None where the run ends early.

        With ``events`` also when those that the flights look for happen before the last time.
        """
        if not (events and self._picks):
            return self._fly(state, begin, times)
        log = self._log(state, begin, float(times[-1]))
        if log is None:
            return None
        meant, of = self._named(log)
        rows = log.events[: log.n_events][meant]
        happened = rows["number"] * self.window + rows["phase"]
        before = np.maximum(happened - _BEFORE * self.window, begin)
        order = np.argsort(np.concatenate([times, before]), kind="stable")
        flight = self._fly(state, begin, np.concatenate([times, before])[order])
        if flight is None:
            return None
        place = np.empty(order.size, np.int64)
        place[order] = np.arange(order.size)
        own, early = place[: times.size], place[times.size :]
        columns = self._instant_columns(rows, log.event_states[: log.n_events][meant, 0],
                                        happened, flight.columns[early])  # fmt: skip
        if columns is None:
            return None
        seen = flight.samples
        samples = MotionSamples(
            seen.number[own], seen.phase[own], seen.modes[own], seen.states[own]
        )
        return Flight(samples, flight.columns[own], EventInstants(happened, of, columns))

    def _fly(self, state: Floats, begin: float, times: Floats) -> Flight | None:
        sizes, p = self.tables.sizes, len(self.chosen)
        numbers, phases = instants(np.append(begin, times), self.window)
        records = allocate_records(sizes, numbers[1:], phases[1:], 0)
        if self._scratch is None:
            self._scratch = allocate_columns(sizes, self.n + p, 1)
        tangent = self._scratch.replace(samples=np.full((times.size, self.n + p, self.n), np.nan))
        tangent.columns[:], tangent.ready[:] = 0.0, 0
        status = self._run(state, numbers, phases, records, tangent)
        if status != Status.COMPLETED or not np.isfinite(tangent.samples).all():
            return None
        samples = MotionSamples(numbers[1:], phases[1:], records.sample_mode, records.sample_state)
        return Flight(samples, tangent.samples.transpose(0, 2, 1))

    def _run(
        self, state: Floats, numbers: Integers, phases: Floats, records: Records, tangent: Tangent
    ) -> Status:
        """Run from the first of some instants to the last one."""
        anchor = allocate_anchor(self.tables.sizes)
        anchor.move_to((int(numbers[0]), float(phases[0])))
        anchor.state[:] = state
        carried = self._derivatives if tangent.samples.size else NO_DERIVATIVES
        lane = (self.tables, carried.rates, carried.scratch, anchor, self._segment, tangent)
        self.n_runs += 1
        return run(lane, records, ANY, (int(numbers[-1]), float(phases[-1])), self.tolerance)

    def _log(self, state: Floats, begin: float, end: float) -> Records | None:
        """The log of a run without derivatives; None where the run ends early."""
        sizes, none = self.tables.sizes, np.zeros(0)
        numbers, phases = instants(np.array([begin, end]), self.window)
        while True:
            records = allocate_records(sizes, none.astype(np.int64), none, self._room)
            status = self._run(state, numbers, phases, records, allocate_tangent(sizes, -1, 0))
            if status != Status.BUFFER_FULL:
                return records if status == Status.COMPLETED else None
            self._room *= 2

    def _named(self, log: Records) -> tuple[Integers, Integers]:
        """Rows of a log that are looked for, in order of time, and which name each has."""
        rows, states = log.events[: log.n_events], log.event_states[: log.n_events]
        found = [pick(rows, states)[0].row for pick in self._picks]
        meant = np.concatenate(found)
        of = np.repeat(np.arange(len(found)), [each.size for each in found])
        order = np.argsort(meant, kind="stable")
        return meant[order], of[order]

    def _instant_columns(
        self, rows: npt.NDArray[np.void], states: Floats, times: Floats, columns: Floats
    ) -> Floats | None:
        """Derivatives of the instants of events, (E, n + p); None where a guard only touches zero.

        shapes: states (E, n) before the events, columns (E, n, n + p) of derivatives there
        """
        count, p = times.size, len(self.chosen)
        if not count:
            return np.zeros((0, self.n + p))
        paths = np.full((count, PATH_LENGTH), -1, np.int64)
        paths[:, 0] = rows["exit"]
        modes = np.ascontiguousarray(rows["from_mode"])
        states, times = np.ascontiguousarray(states), np.ascontiguousarray(times)
        found = allocate_leg_results(self.tables.sizes, p, count)
        tangent = allocate_tangent(self.tables.sizes, p, 1)
        passed = pass_legs(
            self.tables, self._derivatives.rates, self._derivatives.scratch, self._segment,
            tangent, WordLegs(modes, paths, states, times, times), found,
        )  # fmt: skip
        if passed < count or not np.all(found.guard_rate):
            return None
        change = np.einsum("en,enc->ec", found.guard_row[:, : self.n], columns)
        change[:, self.n :] += found.guard_row[:, self.n :]
        moved: Floats = -change / found.guard_rate[:, None]
        return moved
