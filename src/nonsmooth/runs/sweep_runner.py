"""Motions at many parameter values: each begins, settles and is recorded, in one call for all.

What `LaneRunner` does for many starts at one set of parameter values, this does for many sets with
a start each. One runner belongs to one thread.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import allocate_scratch, no_rates
from nonsmooth.engine.device import DeviceSweep
from nonsmooth.engine.lanes import (
    Anchor,
    Tangent,
    allocate_columns,
    allocate_segment,
    lane_anchors,
    lane_tangents,
)
from nonsmooth.engine.record import Rows, dtype_of, zeros
from nonsmooth.engine.status import Status
from nonsmooth.engine.sweeps import Division, Sweep, allocate_sweep, run_sweep
from nonsmooth.engine.tables import EXACT, Tables, allocate_stack, set_up
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.devices import device_for
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.system.system import System

__all__ = [
    "Motions", "Recorded", "SweepRunner", "SweepStarts", "Times", "motions_per_task",
    "seconds_of_motion",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MOST = 64  # motions in one call, some milliseconds of work
_BYTES = 2**25  # of their tables
# motions of a task at least; tasks of a sweep, so that many threads have work, and little is lost
# of one that is stopped; and work of a task that is worth what Python does for each
_LEAST_TOGETHER, _TASKS, _WORTH = 16, 16, 0.1  # the last one in seconds
_PER_PAIR, _OF_SERIES = 1e-7, 10.0  # seconds of a window per pair of coordinates; times with series
_MOST_ON_DEVICE, _ON_DEVICE = 2**15, 2**30  # the same of a graphics device
_LEAST_ON_DEVICE = 512  # motions, of which fewer run faster on the processor
_FIRST_EVENTS = 4096  # rows of the logs of all motions, to begin with
_RATES = no_rates()  # columns are derivatives by initial states alone
_OF_ONE_CALL = ("samples", "events", "segments", "uncertain", "estimated")  # counters


def motions_per_task(count: int, seconds: float = np.inf) -> int:
    """How many of so many motions one task has, whoever runs it, if each takes so long."""
    least = np.clip(_WORTH / seconds, _LEAST_TOGETHER, _MOST)
    return int(np.clip(count // _TASKS, least, _MOST))


def seconds_of_motion(system: System, windows: int) -> float:
    """How long a motion of so many windows takes, within a factor of a few."""
    program = system.compiled.program
    has_series = np.any(allocate_stack(program, 1).kinds != EXACT)
    per_window = _PER_PAIR * program.sizes.augmented**2 * (_OF_SERIES if has_series else 1.0)
    return max(windows, 1) * float(per_window)


class SweepStarts(NamedTuple):
    """Where K motions begin."""

    states: Floats  # (K, n)
    modes: Integers  # (K,): the mode, or how it is found, see `run_lanes`
    numbers: Integers  # (K,) window of each
    phases: Floats  # (K,)

    def replaced(self, chosen: npt.NDArray[np.bool_], other: SweepStarts) -> SweepStarts:
        """The same with other starts of those motions that are chosen, (K,)."""
        return SweepStarts(
            np.where(chosen[:, None], other.states, self.states),
            np.where(chosen, other.modes, self.modes),
            np.where(chosen, other.numbers, self.numbers),
            np.where(chosen, other.phases, self.phases),
        )


class Times(NamedTuple):
    """Windows and phases at which K motions are sampled, s times each."""

    numbers: Integers  # (K, s)
    phases: Floats  # (K, s)

    def at(self, which: slice) -> Times:
        """Some of the times of each motion."""
        numbers, phases = self.numbers[:, which], self.phases[:, which]
        return Times(np.ascontiguousarray(numbers), np.ascontiguousarray(phases))

    def along(self, places: Integers) -> Times:
        """Times at some places of each motion, (K, places)."""
        return Times(
            np.take_along_axis(self.numbers, places, axis=1),
            np.take_along_axis(self.phases, places, axis=1),
        )

    def replaced(self, chosen: npt.NDArray[np.bool_], other: Times) -> Times:
        """The same with other times of those motions that are chosen, (K,)."""
        return Times(
            np.where(chosen[:, None], other.numbers, self.numbers),
            np.where(chosen[:, None], other.phases, self.phases),
        )

    @property
    def last(self) -> tuple[Integers, Floats]:
        """The last times, (K,) each."""
        return self.numbers[:, -1], self.phases[:, -1]


class Motions(NamedTuple):
    """K motions on their way, each with tables of its own; n states."""

    anchors: Anchor  # with the number of motions in front
    modes: Integers  # (K,): how each goes on, see `run_lanes`
    statuses: Integers  # (K,)
    end_states: Floats  # (K, n)
    uncertain: Integers  # (K,): events that rounding leaves open, from the start on
    estimated: Integers  # (K,): steps the errors of which are estimated, likewise
    since: Rows  # (K,): window and phase up to which these are counted
    counters: Rows  # (K,): what the engine counts on the way, as of impacts that accumulate

    def select(self, chosen: Integers) -> Motions:
        """Copy of some of the motions, to go on without these."""
        return Motions(
            self.anchors.part(chosen), self.modes[chosen], self.statuses[chosen],
            self.end_states[chosen], self.uncertain[chosen], self.estimated[chosen],
            self.since[chosen], self.counters[chosen],
        )  # fmt: skip

    @property
    def places(self) -> Rows:
        """Number, mode and phase of the start of each last segment, or of an early end, (K,)."""
        return self.anchors.place


class Recorded(NamedTuple):
    """What K motions leave behind that are run together; s samples, r events in all."""

    statuses: Integers  # (K,)
    windows: Floats  # (K,): lengths, nan of what was refused
    numbers: Integers  # (K, s)
    phases: Floats  # (K, s)
    states: Floats  # (K, s, n), nan behind the end of a motion
    modes: Integers  # (K, s), -1 there
    rows: Rows  # (r,): the logs one after the other, no rows for the starts
    event_states: Floats  # (r, 2, n): before and after each event
    logs: Integers  # (K + 1,): first row of each log, and the end of the last one
    travelled: Floats  # (K, s, n): the states again, of angles with all whole turns

    @property
    def last(self) -> SweepStarts:
        """The last samples, as points where motions begin."""
        return SweepStarts(
            self.states[:, -1], self.modes[:, -1], self.numbers[:, -1], self.phases[:, -1]
        )


class SweepRunner:
    """Runs motions of a system at several sets of parameter values."""

    def __init__(self, system: System, tolerance: float) -> None:
        self.system = system
        self.tolerance = tolerance
        self._program = system.compiled.program
        self._sizes = self._program.sizes
        one = allocate_stack(self._program, 1)
        self._device = device_for(system)
        most, size = (_MOST, _BYTES) if self._device is None else (_MOST_ON_DEVICE, _ON_DEVICE)
        self.most = int(np.clip(size // one.n_bytes, 1, most))  # sets at a time
        self._room = one if self.most == 1 else allocate_stack(self._program, self.most)
        self._stack = self._room
        self._on_device: DeviceSweep | None = None
        self.is_driven = is_driven(self._room.part(0))
        self.kinds = self._room.kinds  # (m,) of the modes
        self.segment = allocate_segment(self._sizes)
        self._scratch = allocate_scratch(self._program, np.zeros(0, np.int64))
        self._no_columns = allocate_columns(self._sizes, 0, 0)

    def set_up(self, values: Floats) -> npt.NDArray[np.bool_]:
        """Take sets of parameter values, (K, p); which of them have tables."""
        count = len(values)
        self._stack, self._on_device = self._room.part(slice(count)), None
        done = np.zeros(count, bool)
        first = 0
        while first < count:
            rest = self._stack.part(slice(first, count)) if first else self._stack
            _, _, passed = set_up(self._program, values[first:], rest)
            done[first : first + passed] = True
            first += passed + 1  # the set behind those has none
        return done

    @property
    def windows(self) -> Floats:
        """Length of a window for each set, of no meaning where it has no tables."""
        return np.asarray(self._stack.clock["window"])

    @property
    def frequencies(self) -> Floats:
        """Frequencies of the forcing for each set, (K, F)."""
        return np.asarray(self._stack.harmonics[:, 0])

    def tables(self, i: int) -> Tables:
        """Tables of one set."""
        return self._stack.part(i)

    def start(self, starts: SweepStarts, usable: npt.NDArray[np.bool_]) -> Motions:
        """Motions at their starts; those that are not ``usable``, (K,), are refused."""
        count = len(starts.states)
        return Motions(
            lane_anchors(self._sizes, starts.numbers, starts.phases, starts.states),
            modes=starts.modes.copy(),  # which the engine writes
            statuses=np.where(usable, Status.COMPLETED, Status.REFUSED).astype(np.int64),
            end_states=np.full((count, self._sizes.states), np.nan),
            uncertain=np.zeros(count, np.int64),
            estimated=np.zeros(count, np.int64),
            since=np.full(2 * count, -np.inf).view(dtype_of("Instant")),
            counters=zeros(Sweep.struct, recording=(count,))["recording"],
        )

    def columns(self, columns: Floats, samples: int, growth: Floats | None = None) -> Tangent:
        """Columns of derivatives by the initial states for K motions, with so many samples.

        Where their ``growth`` up to here is given, it is measured, and they stay orthonormal.

        shapes: columns (K, C, n), growth (K, C)
        """
        count, measures = columns.shape[1], growth is not None
        one = allocate_columns(self._sizes, count, samples, measures=measures)
        made = lane_tangents(one, len(columns))
        made.columns[..., : self._sizes.states] = columns
        if growth is not None:
            made.growth[:] = growth
        return made

    def run(
        self,
        motions: Motions,
        times: Times,
        *,
        chosen: npt.NDArray[np.bool_] | None = None,
        ends: Times | None = None,
        follows: Times | None = None,
        log: bool = True,
        sets: slice | None = None,
        columns: Tangent | None = None,
        division: Division | None = None,
        stop: threading.Event | None = None,
    ) -> Recorded:
        """Run the motions that can go on to their first times, and on to the last with a log.

        They belong to all sets, or to those at ``sets``. Only those that are ``chosen``, (K,),
        where not all are. ``ends`` (K, 1) lie at the last times or behind them. ``follows`` has
        the instants (K, 1) where motions go on that follow the one before, if that has come to its
        end. ``columns`` of derivatives are those of `columns`; a start makes them the identity. One
        of each motion may be divided by its size, see `Division`.
        """
        last = (times if ends is None else ends).last
        sweep = allocate_sweep(
            self._sizes, motions.modes, *times, ends=last, room=_FIRST_EVENTS if log else 0,
            tolerance=self.tolerance, follows=follows is not None, division=division,
        )  # fmt: skip
        if follows is not None:
            sweep.begins["number"], sweep.begins["phase"] = (each[:, 0] for each in follows)
        sweep.since[:], sweep.settling[:] = motions.since, motions.counters
        sweep.statuses[:] = motions.statuses
        if chosen is not None:
            sweep.statuses[~chosen] = Status.REFUSED
        ran = sweep.statuses == Status.COMPLETED
        stack = self._stack if sets is None else self._stack.part(sets)
        device = self._device_for(ran, whole=follows is None and sets is None and columns is None)
        if device is not None:
            sweep = device.run(motions.anchors, sweep)
        if columns is None:
            columns = lane_tangents(self._no_columns, sweep.statuses.size)
        status = Status.PAUSED if device is None else Status.COMPLETED
        while status != Status.COMPLETED:
            if stop is not None and stop.is_set():
                raise Stopped
            if status == Status.BUFFER_FULL:
                sweep = sweep.enlarged()
            status = run_sweep(
                stack, _RATES, self._scratch, motions.anchors, self.segment, columns, sweep
            )
        for name in ("uncertain", "estimated"):
            getattr(motions, name)[:] += sweep.settling[name] + sweep.recording[name]
        motions.statuses[ran], motions.since[ran] = sweep.statuses[ran], sweep.since[ran]
        motions.end_states[ran] = sweep.end_state[ran]
        motions.counters[ran] = sweep.recording[ran]
        for name in _OF_ONE_CALL:
            motions.counters[name] = 0
        end = int(sweep.logs[-1])
        refused = motions.statuses == Status.REFUSED
        return Recorded(
            sweep.statuses, np.where(refused, np.nan, stack.clock["window"]), *times,
            sweep.sample_state, sweep.sample_mode, sweep.events[:end], sweep.event_states[:end],
            sweep.logs, sweep.sample_state,
        )  # fmt: skip

    def _device_for(self, ran: npt.NDArray[np.bool_], *, whole: bool) -> DeviceSweep | None:
        """What runs a ``whole`` sweep of enough motions on a device, None where this one does."""
        if self._device is None or not whole or np.count_nonzero(ran) < _LEAST_ON_DEVICE:
            return None
        if self._on_device is None:
            self._on_device = DeviceSweep(self._device, self._stack)
        return self._on_device
