"""The kernels for graphics devices, compiled for the processor: the same source, one thread."""

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from engine.native_shim import build_engine
from nonsmooth.engine.device import SOURCE, Device


class ProcessorMemory:
    """The memory of the processor in the place of that of a device."""

    n_threads = 1

    def __init__(self, library):
        self.library = library
        self.called = []

    def put(self, data, count=1):
        own = np.tile(data, count)
        return own, own.ctypes.data

    def room(self, size):
        own = np.empty(size, np.uint8)
        return own, own.ctypes.data

    def get(self, there, data):
        data[...] = there[: data.size]

    def call(self, kernel, *addresses):
        self.called.append(kernel)
        getattr(self.library, kernel)(*map(ctypes.c_void_p, addresses))


@cache
def _library():
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        made = Path(folder) / f"device{build_engine.PLATFORMS[''].suffix}"
        flags = [*build_engine.FLAGS, "-O1", "-DNONSMOOTH_DEVICE", "-shared", "-x", "c++"]
        command = [*build_engine.compiler(), *flags, str(SOURCE), "-o", str(made)]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(made))


def device():
    """A device that is the processor."""
    return Device(ProcessorMemory(_library()))
