"""Short runs with derivatives, many with the same parameters: the segments of a record.

Segments begin at different times and have different samples, so each is a lane of its own; the
tables and their derivatives by parameters are set up once for all of them.

In some modes relations hold some of the states: a ring stands where the rotor presses it, a mass
lies on its slider. A start of a segment has all states as numbers, which agree with such relations
only when the fit has ended. So a start tells a mode, that in which the segment before has ended,
and states that the mode holds are left out of it: the engine puts them in their place.

The mode counts too where a state fits several of them, as with a latch, a relay or a thermostat.

A motion that needs far more work than the record calls for ends early. A record in other units than
its model asks for motions of another size, which may be a thousand times as fast as its samples: no
data speak of them, and a fit would spend hours on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import (
    ANY,
    NO_LIMIT,
    Anchor,
    Records,
    Tangent,
    allocate_anchor,
    allocate_columns,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run_within,
)
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import members
from nonsmooth.errors import ModelError
from nonsmooth.fitting.event_instants import EventInstants, named_events, rates_of_instants
from nonsmooth.fitting.observation import MotionSamples
from nonsmooth.runs.clock import instants
from nonsmooth.runs.runner import NO_DERIVATIVES, build_derivatives, build_tables
from nonsmooth.runs.section_search import NamedEvents
from nonsmooth.system.model.value_checks import sure_values
from nonsmooth.system.system import System

__all__ = ["Flight", "Flights"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MOST_KEPT = 500  # of different numbers of samples
_FIRST_ROOM = 64  # events of a flight; the room doubles where they are more
_MUCH = 10  # times the work that a motion needs
_SOON = 1e-3  # of the time between samples: within one step of a motion
_BEFORE = 1e-9  # of a window: the state just before an event is sampled so much earlier


class Flight(NamedTuple):
    """States at the samples of a run, and their derivatives by start and parameters."""

    samples: MotionSamples  # K of them
    columns: Floats  # (K, n, n + p)
    events: EventInstants | None = None  # where events were asked for

    @property
    def last_mode(self) -> int:
        """Number of the mode in which the run has ended."""
        return int(self.samples.modes[-1])


class _Buffers(NamedTuple):
    """What a run needs and writes."""

    anchor: Anchor
    records: Records
    tangent: Tangent


class Flights:
    """Runs of a system at the values of the last `set_up`."""

    def __init__(
        self, system: System, chosen: Sequence[str], tolerance: float, events: Sequence[str] = ()
    ) -> None:
        self.system, self.chosen, self.tolerance = system, tuple(chosen), tolerance
        self.n = len(system.states)
        self.values: dict[str, float] = {}
        self._limit = NO_LIMIT, 0.0  # work of a run: for each sample, and per time
        self._work_done = 0  # by the last run
        self._kept: dict[int, _Buffers] = {}
        self._picks = [NamedEvents(system, name) for name in events]
        self._room = _FIRST_ROOM
        self._parents = [mode.parent for mode in system.structure.running]
        self._placed = np.isnan(list(system.open_state.values()))  # where a start leaves them out

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
        self._held = members(self.tables.modes["slaved"], self.n)
        # without a hint a start leaves out only what any start may leave out: a mass that rests at
        # a wall is held there, and a mass that comes to the wall is not at rest
        scanned = self._held.any(axis=1) & ~(self._held & ~self._placed).any(axis=1)
        self._scanned: list[int] = np.flatnonzero(scanned).tolist()
        self.values = values
        return True

    @property
    def window(self) -> float:
        """Length of a window: the period, where there is one."""
        return self.tables.window

    def fly(
        self, state: Floats, begin: float, times: Floats, mode: int = ANY, *, events: bool = False
    ) -> Flight | None:
        """Run through some times, not decreasing; None where the run ends early.

        It begins in a mode, or where that does not admit the state, in the first one that does.
        With ``events`` it also tells when those that the flights look for happen.
        """
        look = self._look_for_events if events and self._picks else self._look
        turned = None
        for start, wanted, moved in self._starts(state, mode):
            turned = moved
            status, flight = look(start, wanted, begin, times)
            if status != Status.INADMISSIBLE:
                break
        if flight is None or turned is None:
            return flight
        found = flight.columns
        found[:, :, : self.n] = found[:, :, : self.n] @ turned
        if flight.events is not None:
            by_start = flight.events.columns
            by_start[:, : self.n] = by_start[:, : self.n] @ turned
        return flight

    def limit_work(self, state: Floats, begin: float, end: float, count: int) -> None:
        """Let runs end early that need far more work than a motion through so many samples.

        That needs as much as the motion from a state, for each run in proportion to its length, and
        a step of the engine for each sample, as that state may be one of rest. A run with samples
        of its own may do a step for each of these too. There is no limit where the motion from the
        state ends early.
        """
        self._limit = NO_LIMIT, 0.0
        step = self._work(state, begin, np.array([begin + _SOON * (end - begin) / count]))
        whole = self._work(state, begin, np.linspace(begin, end, count + 1)[1:])
        if step is not None and whole is not None:
            self._limit = _MUCH * step, _MUCH * (whole + step * count) / (end - begin)

    def _work(self, state: Floats, begin: float, times: Floats) -> int | None:
        """Work of a run, see work.hpp; None where it ends early."""
        return None if self.fly(state, begin, times) is None else self._work_done

    def fitting_modes(self, state: Floats, begin: float) -> list[int]:
        """Modes that a state fits as it is, none of which holds any of it."""
        free = np.flatnonzero(~self._held.any(axis=1)).tolist()
        looked = ((k, self._log(state, k, begin, begin)[0]) for k in free)
        return [k for k, status in looked if status == Status.COMPLETED]

    def _look(
        self, start: Floats, mode: int, begin: float, times: Floats
    ) -> tuple[Status, Flight | None]:
        """A run from a start that is tried."""
        buffers = self._buffers(times.size)
        numbers, phases = instants(np.append(begin, times), self.window)
        status = self._run(start, mode, numbers, phases, buffers)
        if status != Status.COMPLETED or not np.isfinite(buffers.tangent.samples).all():
            return status, None
        records = buffers.records
        samples = MotionSamples(
            numbers[1:], phases[1:], records.sample_mode.copy(), records.sample_state.copy()
        )
        return status, Flight(samples, buffers.tangent.samples.transpose(0, 2, 1).copy())

    def _look_for_events(
        self, start: Floats, mode: int, begin: float, times: Floats
    ) -> tuple[Status, Flight | None]:
        """The same with the events on the way: a second run samples the states before them."""
        status, log = self._log(start, mode, begin, float(times[-1]))
        if status != Status.COMPLETED:
            return status, None
        rows, states, name = named_events(self._picks, log)
        happened = rows["number"] * self.window + rows["phase"]
        before = np.maximum(happened - _BEFORE * self.window, begin)
        order = np.argsort(np.concatenate([times, before]), kind="stable")
        status, flight = self._look(start, mode, begin, np.concatenate([times, before])[order])
        if flight is None:
            return status, None
        place = np.empty(order.size, np.int64)
        place[order] = np.arange(order.size)
        own, early = place[: times.size], place[times.size :]
        columns = rates_of_instants(
            self.tables, self._derivatives, self._segment, rows, states, happened,
            flight.columns[early],
        )  # fmt: skip
        if columns is None:
            return status, None
        seen = flight.samples
        samples = MotionSamples(
            seen.number[own], seen.phase[own], seen.modes[own], seen.states[own]
        )
        events = EventInstants(happened, name, columns)
        return status, Flight(samples, flight.columns[own], events)

    def _log(self, start: Floats, mode: int, begin: float, end: float) -> tuple[Status, Records]:
        """The log of a run without derivatives."""
        sizes, none = self.tables.sizes, np.zeros(0)
        numbers, phases = instants(np.array([begin, end]), self.window)
        while True:
            records = allocate_records(sizes, none.astype(np.int64), none, self._room)
            buffers = _Buffers(allocate_anchor(sizes), records, allocate_tangent(sizes, -1, 0))
            status = self._run(start, mode, numbers, phases, buffers)
            if status != Status.BUFFER_FULL:
                return status, records
            self._room *= 2

    def _starts(self, state: Floats, mode: int) -> Iterator[tuple[Floats, int, Floats | None]]:
        """Starts to try in order, with what they are by the state given where that is not itself.

        What a mode holds is left out, as nan. A start that no mode takes lies behind a surface, as
        a mass within its slider: at last it is put on the surface, from where it may leave.
        """
        if mode != ANY and self._held[mode].any():
            kin = [k for k, parent in enumerate(self._parents) if parent == self._parents[mode]]
            for k in sorted(kin, key=lambda k: k != mode):
                yield np.where(self._held[k], np.nan, state), k, None
        elif mode != ANY:
            yield state, mode, None
        yield state, ANY, None
        for k in self._scanned:
            yield np.where(self._held[k], np.nan, state), k, None
        for k in self._scanned:
            if not members(self.tables.modes["implicit"][k], self.n).any():
                start, moved = self._on_relations(state, k)
                yield start, ANY, moved

    def _on_relations(self, state: Floats, mode: int) -> tuple[Floats, Floats]:
        """A state put on the relations of a mode, and its derivatives by the state."""
        known = self._segment.z.copy()  # powers of time and the like are those of the last try
        known[: self.n] = state
        start, moved = state.copy(), np.eye(self.n)
        for i in np.flatnonzero(self._held[mode]):
            row = self.tables.relation_row(mode, int(i))
            start[i], moved[i] = row @ known, row[: self.n]
        return start, moved

    def _buffers(self, count: int) -> _Buffers:
        """Arrays for a run with so many samples; those of a number of samples are used again."""
        if count not in self._kept:
            if len(self._kept) >= _MOST_KEPT:
                self._kept.clear()
            sizes, width = self.tables.sizes, self.n + len(self.chosen)
            number, phase = np.zeros(count, np.int64), np.zeros(count)
            self._kept[count] = _Buffers(
                allocate_anchor(sizes),
                allocate_records(sizes, number, phase, 0),
                allocate_columns(sizes, width, count),
            )
        return self._kept[count]

    def _run(
        self, start: Floats, mode: int, numbers: Integers, phases: Floats, buffers: _Buffers
    ) -> Status:
        """Run from the first of some instants to the last one."""
        anchor, records, tangent = buffers
        for array in (records.counters, anchor.place, anchor.order, tangent.columns, tangent.ready):
            array[...] = 0
        for array in (records.sample_state, records.end_state, tangent.samples):
            array[...] = np.nan
        records.sample_mode[:] = -1
        records.since["number"] = records.since["phase"] = -np.inf
        count = records.sample_number.size  # none where only events are logged
        records.sample_number[:], records.sample_phase[:] = numbers[1:][:count], phases[1:][:count]
        anchor.move_to((int(numbers[0]), float(phases[0])))
        anchor.state[:] = start
        carried = self._derivatives if tangent.samples.size else NO_DERIVATIVES
        lane = (self.tables, carried.rates, carried.scratch, anchor, self._segment, tangent)
        end = int(numbers[-1]), float(phases[-1])
        length = (end[0] - int(numbers[0])) * self.window + end[1] - float(phases[0])
        per_sample, per_time = self._limit
        most = per_sample * (1 + count) + int(per_time * length)
        status, self._work_done = run_within(lane, records, mode, end, self.tolerance, most)
        return status
