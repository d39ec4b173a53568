"""Where many lanes run: on the processor, or on a graphics device where there is one."""

from __future__ import annotations

import os
import threading
import warnings
from contextlib import AbstractContextManager, ExitStack
from functools import cache
from typing import Any

from nonsmooth.arguments import checked
from nonsmooth.engine.device import OPTIONS, SOURCE, Bytes, Device, why_not
from nonsmooth.errors import OptionError, ResultWarning, unknown_choice
from nonsmooth.system.system import System

__all__ = ["device_for", "use_device"]

_NAMES = ("cpu", "gpu")
_VARIABLE = "NONSMOOTH_DEVICE"
_THREADS = 64  # in a block: small ones, since each thread comes to its end by itself
_BLOCKS = 8  # for each multiprocessor: as many as the registers of so many threads allow
_REGISTERS = "-maxrregcount=128"  # of a thread; more leave room for fewer threads, fewer spill


class _Choice:
    """What was chosen last, by `use_device` or by the environment."""

    name = ""


@checked
def use_device(name: str) -> AbstractContextManager[Any]:
    """Run many motions at once on a graphics device, or on the processor again.

    The choice holds for all calls that follow, in all threads; in a ``with`` block it holds there
    alone. Basins, ensembles and maps of regimes then run their motions on the device, where there
    are hundreds at once; single motions, orbits and derivatives stay on the processor, which is
    faster for them. The environment variable NONSMOOTH_DEVICE makes the same choice for commands
    of the shell.

    Parameters
    ----------
    name : {"cpu", "gpu"}
        Where motions run. A ``"gpu"`` is a device of NVIDIA that CuPy finds.

    Returns
    -------
    context manager
        At the end of its ``with`` block the former choice holds again.

    Raises
    ------
    OptionError
        Where there is no such device, or CuPy is not installed: the message says what to install.

    Notes
    -----
    The device runs the source of the engine itself, one motion in each thread. What differs is the
    last digit of functions such as the exponential, so labels agree, and a chaotic motion parts
    from that of the processor as it parts from itself after a change of the last digit. Only
    systems whose modes, guards and resets are linear run there; for others a warning says that the
    processor does the work. The kernels are compiled when they are first used, which takes
    some minutes, and kept for the next time.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> grid = {"x": np.linspace(-2, 2, 4), "v": np.linspace(-2, 2, 4)}
    >>> with ns.use_device("cpu"):
    ...     basins = ns.basins_of_attraction(ns.models.soft_impact(), grid)
    """
    block = ExitStack()
    block.callback(_choose, _chosen())
    if name not in _NAMES:
        raise OptionError(unknown_choice("name", name, _NAMES))
    if name == "gpu":
        _graphics()
    _choose(name)
    return block


def _choose(name: str) -> None:
    _Choice.name = name


def _chosen() -> str:
    """What holds now: at first what the environment says."""
    if not _Choice.name:
        name = os.environ.get(_VARIABLE, "cpu")
        if name not in _NAMES:
            raise OptionError(unknown_choice(_VARIABLE, name, _NAMES))
        if name == "gpu":
            _graphics()
        _choose(name)
    return _Choice.name


def device_for(system: System) -> Device | None:
    """The device for many motions of a system, None where the processor runs them."""
    if _chosen() == "cpu":
        return None
    reason = why_not(system.compiled.program)
    if reason:
        text = f"the processor runs these motions, not the graphics device, since {reason}"
        warnings.warn(text, ResultWarning, stacklevel=2)
        return None
    return _graphics()


class _Memory:
    """Memory and kernels of a device, by CuPy."""

    def __init__(self, cupy: Any) -> None:
        self._cupy = cupy
        self._module = cupy.RawModule(code=SOURCE.read_text(), options=(*OPTIONS, _REGISTERS))
        self._module.compile()  # now, and not when the first motions run
        self._blocks = _BLOCKS * int(cupy.cuda.Device().attributes["MultiProcessorCount"])
        self.n_threads = self._blocks * _THREADS

    def put(self, data: Bytes, count: int = 1) -> tuple[Any, int]:
        there = self._cupy.asarray(data)
        if count > 1:
            there = self._cupy.tile(there, count)
        return there, int(there.data.ptr)

    def room(self, size: int) -> tuple[Any, int]:
        there = self._cupy.empty(size, self._cupy.uint8)
        return there, int(there.data.ptr)

    def get(self, there: Any, data: Bytes) -> None:
        there.get(out=data)

    def call(self, kernel: str, *addresses: int) -> None:
        pointers = tuple(self._cupy.uint64(address) for address in addresses)
        self._module.get_function(kernel)((self._blocks,), (_THREADS,), pointers)
        self._cupy.cuda.get_current_stream().synchronize()


_making = threading.Lock()


def _graphics() -> Device:
    with _making:  # threads that ask at once compile the kernels once
        return _made()


@cache
def _made() -> Device:
    try:
        import cupy
    except ImportError as fault:
        raise OptionError(
            "CuPy, which runs kernels on graphics devices, is not installed: `pip install"
            " 'nonsmooth[gpu]'` brings that for CUDA 13, and cupy-cuda12x is that for CUDA 12; or"
            " stay with use_device('cpu')"
        ) from fault
    try:
        reason = "" if cupy.cuda.runtime.getDeviceCount() else "CuPy sees none"
    except cupy.cuda.runtime.CUDARuntimeError as fault:
        reason = str(fault)
    if reason:
        raise OptionError(f"no graphics device was found ({reason}): stay with use_device('cpu')")
    return Device(_Memory(cupy))
