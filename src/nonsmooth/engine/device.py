"""Runs on a graphics device: what `run_lanes` and `run_sweep` do, with one run in each thread.

The device has memory of its own. Records go there with the addresses that their arrays have on the
device, and what runs have written comes back into the arrays of the record. Tables stay there as
long as runs need them. Only modes with closed forms run there, by the same source as on the
processor.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import NO_LIMIT, Anchor, LaneTask, Records, allocate_segment
from nonsmooth.engine.library import constant, engine, ffi
from nonsmooth.engine.record import Integers, Record
from nonsmooth.engine.status import Status
from nonsmooth.engine.sweeps import Sweep
from nonsmooth.engine.tables import EXACT, Program, Sizes, Tables

__all__ = ["OPTIONS", "SOURCE", "Device", "DeviceLanes", "DeviceSweep", "Memory", "why_not"]

SOURCE = Path(__file__).parent / "_device.cu"  # written by build_engine.py
# of its compiler; nothing is contracted, as on the processor
OPTIONS = (
    "-std=c++20", "--device-as-default-execution-space", "--fmad=false", "-DNONSMOOTH_DEVICE",
    "--diag-suppress=20012,177,161",
)  # fmt: skip
_MOST = constant("MAX_ON_DEVICE")
_OF_SERIES = ("series", "doubt", "doubt_here", "majorants", "dual")  # scratch that no lane needs

_LOGS = ("events", "event_states")
_WRITTEN = (
    "modes", "sample_state", "sample_mode", "settling", "recording", "end_state", "since",
    "statuses",
)  # fmt: skip
_ROWS = 64  # of the log of a motion, to begin with

Bools = npt.NDArray[np.bool_]
Bytes = npt.NDArray[np.uint8]


class Memory(Protocol):
    """The memory of a device, and what runs there."""

    n_threads: int

    def put(self, data: Bytes, count: int = 1) -> tuple[Any, int]:
        """Copies of some bytes in the memory of the device, and the address of the first one."""

    def room(self, size: int) -> tuple[Any, int]:
        """Room for so many bytes, and its address."""

    def get(self, there: Any, data: Bytes) -> None:
        """Read what the device has written."""

    def call(self, kernel: str, *addresses: int) -> None:
        """Run a kernel by all threads, and wait for its end."""


class Device:
    """A device whose calls come one after the other, and the scratch of its threads."""

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self._calls = threading.Lock()
        self._scratch: dict[Sizes, _Placed] = {}

    def call(self, kernel: str, sizes: Sizes, *placed: _Placed) -> None:
        """Run a kernel by all threads and wait for its end; sizes are those of their scratch."""
        with self._calls:
            if sizes not in self._scratch:
                segment = allocate_segment(sizes)
                left_out = {name: getattr(segment, name)[:0] for name in _OF_SERIES}
                count = self.memory.n_threads
                self._scratch.clear()  # before more is asked for: that of all threads is large
                self._scratch[sizes] = _Placed(self.memory, segment.replace(**left_out), count)
            _kept, counter = self.memory.put(np.zeros(8, np.uint8))
            addresses = (each.address for each in placed)
            self.memory.call(kernel, self._scratch[sizes].address, *addresses, counter)


def why_not(program: Program) -> str:
    """Why a device cannot run a system, in words; empty where it can."""
    if np.any(program.kinds != EXACT):
        return "a mode of the system is not linear"
    rows = program.code_rows
    if np.any(rows["end"] > rows["first"]):
        return "a guard or a reset of the system is not linear"
    if program.sizes.augmented > _MOST:
        return f"the system has more than {_MOST} coordinates, the forcing among them"
    return ""


class _Placed:
    """A record in the memory of a device."""

    def __init__(
        self, memory: Memory, record: Record, count: int = 1, new: tuple[str, ...] = ()
    ) -> None:
        """So many copies of a record, each with its own arrays; ``new`` ones are only written."""
        self._memory, self._there = memory, dict[str, tuple[Any, Bytes]]()
        struct = ffi.typeof(record.struct)
        own = np.frombuffer(ffi.buffer(record.pointer), np.uint8)
        structs = np.tile(own, (count, 1)).view(np.uint64)
        for name, field in struct.fields:
            if field.type.kind not in ("struct", "pointer"):
                continue
            data = _bytes_of(record, name, field)
            if not data.size:
                continue
            there, address = memory.room(data.size) if name in new else memory.put(data, count)
            self._there[name] = there, data
            steps = np.arange(count, dtype=np.uint64) * np.uint64(data.size)
            structs[:, field.offset // 8] = np.uint64(address) + steps
        self._structs, self.address = memory.put(structs.view(np.uint8).reshape(-1))

    def take_back(self, *names: str) -> None:
        """Read arrays that the device has written."""
        for name in names:
            if name in self._there:
                self._memory.get(*self._there[name])


def _bytes_of(record: Record, name: str, field: Any) -> Bytes:
    """The memory of an array, or of one row."""
    value = record.__dict__[name]
    if isinstance(value, tuple):
        row = ffi.buffer(getattr(record.pointer, name), ffi.sizeof(field.type.item))
        return np.frombuffer(row, np.uint8)
    return np.asarray(value).reshape(-1).view(np.uint8)


class DeviceLanes:
    """Runs lanes of one set of parameter values on a device."""

    def __init__(self, device: Device, tables: Tables) -> None:
        self._device, self._sizes = device, tables.sizes
        stack = tables.as_lanes
        engine.nonsmooth_complete_tables(stack.pointer)
        self._tables = _Placed(device.memory, stack)

    def run(
        self,
        anchors: Anchor,
        records: Records,
        modes: Integers,
        end: tuple[int, float],
        statuses: Integers,
        tolerance: float,
    ) -> None:
        """Run all lanes to an instant; anchors, records and statuses are as after `run_lanes`."""
        task = LaneTask(
            modes, 0, modes.size, int(end[0]), float(end[1]), np.zeros(2, np.int64), statuses,
            tolerance, NO_LIMIT, NO_LIMIT,
        )  # fmt: skip
        lanes, written, asked = (
            _Placed(self._device.memory, record) for record in (anchors, records, task)
        )
        kernel = "nonsmooth_lanes_on_device"
        self._device.call(kernel, self._sizes, self._tables, lanes, written, asked)
        lanes.take_back(*anchors.in_lanes)
        written.take_back(*records.in_lanes)
        asked.take_back("statuses")


class DeviceSweep:
    """Runs motions of a sweep on a device, each with its own tables of a stack."""

    def __init__(self, device: Device, stack: Tables) -> None:
        self._device, self._sizes = device, stack.sizes
        self._tables = _Placed(device.memory, stack)

    def run(self, anchors: Anchor, sweep: Sweep) -> Sweep:
        """Run all motions that can go on; the sweep as `run_sweep` leaves it, with another log.

        The room of a log is not known beforehand: motions whose part of it was too small begin once
        more with more room.
        """
        ran = sweep.statuses == Status.COMPLETED
        logged = sweep.events.size > 0
        least, count = int(logged) * _ROWS, sweep.statuses.size
        starts = anchors.copied(), sweep.modes.copy(), sweep.since.copy(), sweep.settling.copy()
        whose, logs, states = [np.zeros(0, np.int64)], [sweep.events[:0]], [sweep.event_states[:0]]
        left, statuses = ran.copy(), sweep.statuses.copy()
        while np.any(left):
            first = np.concatenate([[0], np.cumsum(np.where(left, least, 0))])
            sweep = self._pass(anchors, sweep, first, left)
            full = left & (sweep.statuses == Status.BUFFER_FULL)
            done = left & ~full
            statuses[done] = sweep.statuses[done]
            rows = np.where(done, sweep.recording["events"], 0)
            whose.append(np.repeat(np.arange(count), rows))
            place = np.arange(rows.sum()) + np.repeat(first[:-1] - np.cumsum(rows) + rows, rows)
            logs.append(sweep.events[place])
            states.append(sweep.event_states[place])
            anchors.put(full, starts[0].part(full))
            for own, at_start in zip(
                (sweep.modes, sweep.since, sweep.settling), starts[1:], strict=True
            ):
                own[full] = at_start[full]
            left, least = full, 4 * least
        order = np.argsort(np.concatenate(whose), kind="stable")
        total = np.bincount(np.concatenate(whose), minlength=count)
        return sweep.replace(
            events=np.concatenate(logs)[order],
            event_states=np.concatenate(states)[order],
            logs=np.concatenate([[0], np.cumsum(total)]),
            statuses=statuses,
        )

    def _pass(self, anchors: Anchor, sweep: Sweep, first: Integers, chosen: Bools) -> Sweep:
        """Run the chosen motions, each with its part of the log from a first row on."""
        n_rows = int(first[-1])
        sweep = sweep.replace(
            events=np.empty(n_rows, sweep.events.dtype),
            event_states=np.empty((n_rows, *sweep.event_states.shape[1:])),
            logs=first,
            statuses=np.where(chosen, int(Status.COMPLETED), int(Status.REFUSED)),
            work=NO_LIMIT,
        )
        memory = self._device.memory
        lanes, task = _Placed(memory, anchors), _Placed(memory, sweep, new=_LOGS)
        self._device.call("nonsmooth_sweep_on_device", self._sizes, self._tables, lanes, task)
        lanes.take_back(*anchors.in_lanes)
        task.take_back(*_WRITTEN, *_LOGS)
        return sweep
