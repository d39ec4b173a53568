"""Lanes on a graphics device: what `run_lanes` does, with one lane in each thread.

The device has memory of its own. Records go there with the addresses that their arrays have on the
device, and what runs have written comes back into the arrays of the record. Tables stay there as
long as lanes of the same parameter values run. Only modes with closed forms run there.

What talks to the device is CuPy, which compiles the kernels when they are first used and keeps
them. The same kernels, compiled for the processor, are how tests see this code without a device.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.lanes import NO_LIMIT, Anchor, LaneTask, Records, allocate_segment
from nonsmooth.engine.library import constant, engine, ffi
from nonsmooth.engine.record import Integers, Record, zeros
from nonsmooth.engine.tables import EXACT, Tables
from nonsmooth.errors import OptionError

__all__ = ["Device", "DeviceLanes", "graphics_device", "why_not"]

_SOURCE = Path(__file__).parent / "_device.cu"
_THREADS = 64  # in a block: a device has room for many of them, each of which may end by itself
_BLOCKS = 4  # for each multiprocessor, as many as their registers allow
_OPTIONS = (
    "-std=c++20",
    "--device-as-default-execution-space",
    "--fmad=false",  # nothing is contracted, as on the processor
    "-DNONSMOOTH_DEVICE",
    "--diag-suppress=20012,177,161",
)
_MOST = constant("MAX_ON_DEVICE")
_OF_SERIES = ("series", "doubt", "doubt_here", "majorants", "dual")  # scratch that no lane needs

Bytes = npt.NDArray[np.uint8]


class Device(Protocol):
    """Where kernels run, with its memory."""

    n_threads: int

    def put(self, data: Bytes, count: int = 1) -> tuple[Any, int]:
        """Copies of some bytes in the memory of the device, and the address of the first one."""

    def get(self, there: Any, data: Bytes) -> None:
        """Read what the device has written."""

    def call(self, kernel: str, *addresses: int) -> None:
        """Run a kernel by all threads, and wait for its end."""


class _Graphics:
    """A device that CuPy finds."""

    def __init__(self, cupy: Any) -> None:
        self._cupy = cupy
        self._module = cupy.RawModule(code=_SOURCE.read_text(), options=_OPTIONS)
        self.blocks = _BLOCKS * int(cupy.cuda.Device().attributes["MultiProcessorCount"])
        self.n_threads = self.blocks * _THREADS

    def put(self, data: Bytes, count: int = 1) -> tuple[Any, int]:
        there = self._cupy.asarray(data)
        if count > 1:
            there = self._cupy.tile(there, count)
        return there, int(there.data.ptr)

    def get(self, there: Any, data: Bytes) -> None:
        there.get(out=data)

    def call(self, kernel: str, *addresses: int) -> None:
        pointers = tuple(self._cupy.uint64(address) for address in addresses)
        self._module.get_function(kernel)((self.blocks,), (_THREADS,), pointers)
        self._cupy.cuda.get_current_stream().synchronize()


@cache
def graphics_device() -> Device:
    """The device, with its kernels compiled; `OptionError` where there is none."""
    cure = "leave out device='gpu', or install the extra of your CUDA version: nonsmooth[gpu]"
    try:
        import cupy
    except ImportError as fault:
        raise OptionError(f"CuPy, which talks to graphics devices, is not installed: {cure}") from fault
    try:
        count = cupy.cuda.runtime.getDeviceCount()
    except cupy.cuda.runtime.CUDARuntimeError as fault:
        raise OptionError(f"no graphics device was found ({fault}): leave out device='gpu'") from fault
    if count == 0:
        raise OptionError("no graphics device was found: leave out device='gpu'")
    return _Graphics(cupy)


def why_not(tables: Tables) -> str:
    """Why a device cannot run a system, in words; empty where it can."""
    if np.any(tables.kinds != EXACT):
        return "a mode of the system is not linear"
    rows = tables.code_rows
    if np.any(rows["end"] > rows["first"]):
        return "a guard or a reset of the system is not linear"
    if tables.sizes.augmented > _MOST:
        return f"the system has more than {_MOST} coordinates, the forcing among them"
    return ""


class _Placed:
    """A record in the memory of a device."""

    def __init__(self, device: Device, record: Record, count: int = 1) -> None:
        """So many copies of a record, each with arrays of its own."""
        self._device, self._there = device, dict[str, tuple[Any, Bytes]]()
        struct = ffi.typeof(record.struct)
        size = ffi.sizeof(struct)
        own = np.frombuffer(ffi.buffer(record.pointer), np.uint8)
        structs = np.tile(own, (count, 1)).view(np.uint64)
        for name, field in struct.fields:
            if field.type.kind not in ("struct", "pointer"):
                continue
            data = _bytes_of(record, name, field)
            if not data.size:
                continue
            there, address = device.put(data, count)
            self._there[name] = there, data
            steps = np.arange(count, dtype=np.uint64) * np.uint64(data.size)
            structs[:, field.offset // 8] = np.uint64(address) + steps
        self._structs, self.address = device.put(structs.view(np.uint8).reshape(-1))
        assert structs.shape[1] * 8 == size

    def take_back(self, *names: str) -> None:
        """Read arrays that the device has written."""
        for name in names:
            if name in self._there:
                self._device.get(*self._there[name])


def _bytes_of(record: Record, name: str, field: Any) -> Bytes:
    """The memory of an array, or of one row."""
    value = record.__dict__[name]
    if isinstance(value, tuple):
        return np.frombuffer(ffi.buffer(getattr(record.pointer, name), ffi.sizeof(field.type.item)), np.uint8)
    return np.asarray(value).reshape(-1).view(np.uint8)


class DeviceLanes:
    """Runs lanes of one set of parameter values on a device."""

    def __init__(self, device: Device, tables: Tables) -> None:
        self._device = device
        stack = tables.as_lanes
        engine.nonsmooth_complete_tables(stack.pointer)
        segment = allocate_segment(tables.sizes)
        scratch = segment.replace(**{name: getattr(segment, name)[:0] for name in _OF_SERIES})
        self._tables = _Placed(device, stack)
        self._segments = _Placed(device, scratch, device.n_threads)

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
        placed = [_Placed(self._device, record) for record in (anchors, records, task)]
        _next, counter = self._device.put(np.zeros(8, np.uint8))
        lanes, written, asked = placed
        self._device.call(
            "nonsmooth_lanes_on_device", self._tables.address, lanes.address,
            self._segments.address, written.address, asked.address, counter,
        )  # fmt: skip
        lanes.take_back(*anchors.in_lanes)
        written.take_back(*records.in_lanes)
        asked.take_back("statuses")
