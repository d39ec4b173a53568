"""Motions at many parameter values: each begins, settles and is recorded, in one call for all.

What `LaneRunner` does for many starts at one set of parameter values, this does for many sets with
a start each. One runner belongs to one thread.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.device import Device, DeviceSweep
from nonsmooth.engine.lanes import Anchor, allocate_segment, allocate_tangent, lane_anchors
from nonsmooth.engine.record import Rows, dtype_of
from nonsmooth.engine.status import Status
from nonsmooth.engine.sweeps import Sweep, allocate_sweep, run_sweep
from nonsmooth.engine.tables import Tables, allocate_stack, set_up
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.devices import device_for
from nonsmooth.system.system import System

__all__ = ["Motions", "Recorded", "SweepRunner", "SweepStarts", "Times"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_MOST = 16  # motions in one call, a few milliseconds of work
_BYTES = 2**25  # of their tables
_MOST_ON_DEVICE, _ON_DEVICE = 2**15, 2**30  # the same of a graphics device
_LEAST_ON_DEVICE = 512  # motions, of which fewer run faster on the processor
_FIRST_EVENTS = 4096  # rows of the logs of all motions, to begin with
_RATES, _SCRATCH = no_rates(), no_scratch()


class SweepStarts(NamedTuple):
    """Where K motions begin."""

    states: Floats  # (K, n)
    modes: Integers  # (K,): the mode, or how it is found, see `run_lanes`
    numbers: Integers  # (K,) window of each
    phases: Floats  # (K,)


class Times(NamedTuple):
    """Windows and phases at which K motions are sampled, s times each."""

    numbers: Integers  # (K, s)
    phases: Floats  # (K, s)

    def at(self, which: slice) -> Times:
        """Some of the times of each motion."""
        numbers, phases = self.numbers[:, which], self.phases[:, which]
        return Times(np.ascontiguousarray(numbers), np.ascontiguousarray(phases))

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

    def select(self, chosen: Integers) -> Motions:
        """Copy of some of the motions, to go on without these."""
        return Motions(
            self.anchors.part(chosen), self.modes[chosen], self.statuses[chosen],
            self.end_states[chosen], self.uncertain[chosen], self.estimated[chosen],
            self.since[chosen],
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
        self.segment = allocate_segment(self._sizes)
        self._tangent = allocate_tangent(self._sizes, -1, 0).as_lanes

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

    def tables(self, i: int) -> Tables:
        """Tables of one set."""
        return self._stack.part(i)

    def start(self, starts: SweepStarts, usable: npt.NDArray[np.bool_]) -> Motions:
        """Motions at their starts; those that are not ``usable``, (K,), are refused."""
        count = len(starts.states)
        return Motions(
            lane_anchors(self._sizes, starts.numbers, starts.phases, starts.states),
            modes=starts.modes,
            statuses=np.where(usable, Status.COMPLETED, Status.REFUSED).astype(np.int64),
            end_states=np.full((count, self._sizes.states), np.nan),
            uncertain=np.zeros(count, np.int64),
            estimated=np.zeros(count, np.int64),
            since=np.full(2 * count, -np.inf).view(dtype_of("Instant")),
        )

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
        stop: threading.Event | None = None,
    ) -> Recorded:
        """Run the motions that can go on to their first times, and on to the last with a log.

        They belong to all sets, or to those at ``sets``. Only those that are ``chosen``, (K,),
        where not all are. ``ends`` (K, 1) lie at the last times or behind them. ``follows`` has
        the instants (K, 1) where motions go on that follow the one before, if that has come to its
        end.
        """
        last = (times if ends is None else ends).last
        sweep = allocate_sweep(
            self._sizes, motions.modes, *times, ends=last, room=_FIRST_EVENTS if log else 0,
            tolerance=self.tolerance, follows=follows is not None,
        )  # fmt: skip
        if follows is not None:
            sweep.begins["number"], sweep.begins["phase"] = (each[:, 0] for each in follows)
        sweep.since[:] = motions.since
        sweep.statuses[:] = motions.statuses
        if chosen is not None:
            sweep.statuses[~chosen] = Status.REFUSED
        ran = sweep.statuses == Status.COMPLETED
        stack = self._stack if sets is None else self._stack.part(sets)
        if (
            self._device is not None
            and follows is None
            and sets is None
            and (np.count_nonzero(ran) >= _LEAST_ON_DEVICE)
        ):
            sweep = self._swept_on_device(self._device, motions, sweep)
        else:
            sweep = self._swept(stack, motions, sweep, stop)
        for name in ("uncertain", "estimated"):
            getattr(motions, name)[:] += sweep.settling[name] + sweep.recording[name]
        motions.statuses[ran], motions.since[ran] = sweep.statuses[ran], sweep.since[ran]
        motions.end_states[ran] = sweep.end_state[ran]
        end = int(sweep.logs[-1])
        refused = motions.statuses == Status.REFUSED
        return Recorded(
            sweep.statuses, np.where(refused, np.nan, stack.clock["window"]), *times,
            sweep.sample_state, sweep.sample_mode, sweep.events[:end], sweep.event_states[:end],
            sweep.logs, sweep.sample_state,
        )  # fmt: skip

    def _swept(
        self, stack: Tables, motions: Motions, sweep: Sweep, stop: threading.Event | None
    ) -> Sweep:
        """The sweep at its end, run one motion after the other."""
        status = Status.PAUSED
        while status != Status.COMPLETED:
            if stop is not None and stop.is_set():
                raise Stopped
            if status == Status.BUFFER_FULL:
                sweep = sweep.enlarged()
            status = run_sweep(
                stack, _RATES, _SCRATCH, motions.anchors, self.segment, self._tangent, sweep
            )
        return sweep

    def _swept_on_device(self, device: Device, motions: Motions, sweep: Sweep) -> Sweep:
        """The same, side by side on a device."""
        if self._on_device is None:
            self._on_device = DeviceSweep(device, self._stack)
        return self._on_device.run(motions.anchors, sweep)
