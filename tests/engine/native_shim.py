"""Parts of the engine that only tests call by themselves: shim.cpp, compiled at first use."""

import ctypes
import importlib.util
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from house.tree import ROOT
from nonsmooth.engine.library import ffi
from nonsmooth.engine.record import Record, array_pointer, rows_of

SHIM = Path(__file__).with_name("shim.cpp")
# what arrays of each kind of numpy hold
ELEMENTS = {"f": "double", "c": "Complex", "i": "int64_t", "V": "TapeRow"}


def _build_script():
    """build_engine.py, which is no part of the package."""
    spec = importlib.util.spec_from_file_location("build_engine", ROOT / "build_engine.py")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


build_engine = _build_script()


@cache
def _library():
    """The shim, compiled as the engine is; once it is loaded its file may go."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        made = Path(folder) / f"shim{build_engine.PLATFORMS[''].suffix}"
        command = [*build_engine.compiler(), *build_engine.FLAGS, f"-I{build_engine.SOURCES}"]
        libraries = [] if sys.platform == "win32" else ["-lm"]
        subprocess.run([*command, "-shared", SHIM, "-o", made, *libraries], check=True)
        return ctypes.CDLL(str(made))


def _call(name, *arguments):
    """Call a function of the shim: numbers by value, records and arrays by pointer."""
    kept, given = [], []
    for argument in arguments:
        if isinstance(argument, int):
            given.append(ctypes.c_int64(argument))
        elif isinstance(argument, float):
            given.append(ctypes.c_double(argument))
        else:
            kept.append(_pointer(argument))  # as long as the call lasts
            given.append(ctypes.c_void_p(int(ffi.cast("intptr_t", kept[-1]))))
    getattr(_library(), name)(*given)


def _pointer(argument):
    if isinstance(argument, Record):
        return argument.pointer
    return array_pointer(ELEMENTS[argument.dtype.kind], argument)


def turn(angles):
    """Numbers cos x + i sin x, as the engine computes them."""
    turns = np.zeros(len(angles), complex)
    _call("shim_turn", np.asarray(angles, float), turns)
    return turns


def motion_rows(z):
    """Bernstein rows of exp(z t), (M, 2, 16), with their sizes and what they leave out."""
    z = np.asarray(z, complex)
    rows, bounds = np.zeros((len(z), 2, 16)), np.zeros((len(z), 2))
    _call("shim_motion_rows", z, rows, bounds)
    return rows, bounds[:, 0], bounds[:, 1]


def run_tape(parameters, rows, chosen):
    """Slots of a tape without literals, and their derivatives by the chosen parameters."""
    parameters, tape = np.array(parameters, float), rows_of("TapeRow", rows)
    chosen = np.array(chosen, np.int64)
    slots = np.zeros(len(parameters) + len(tape))
    rates = np.zeros((len(slots), len(chosen)))
    _call("shim_run_tape", parameters, tape, chosen, slots, rates)
    return slots, rates


def augmented(tables, number, phase, z):
    """Fill what augmented coordinates z (N,) have beyond the states."""
    _call("shim_augmented", tables.as_lanes, int(number), float(phase), z)


def augmented_columns(tables, rates, time, z, columns):
    """Fill what columns (C, N) have beyond the states, at a time with augmented coordinates z."""
    _call("shim_augmented_columns", tables.as_lanes, rates, float(time), z, columns)


def advance_columns(tables, rates, scratch, mode, z, s, columns, out):
    """States of columns (C, N) after a time s in a mode, into out (C, n) or wider."""
    given = tables.as_lanes, rates, scratch, mode, z, float(s), columns, out
    _call("shim_advance_columns", *given)


def remainders(tables, segment, mode, length):
    """Bounds of what the registers of a step are off their polynomials by over a length."""
    bounds = np.zeros(len(segment.series))
    _call("shim_remainders", tables.as_lanes, segment, mode, float(length), bounds)
    return bounds


class Look(NamedTuple):
    """What a look by signs reads: coefficients (16,), their margin, what fades, the step."""

    coefficients: np.ndarray
    margin: float
    fading: float
    step: float


def look(tables, segment, guard, level, order, time):
    """A look by signs in mode 0 at a time after the start ``segment.z`` of a segment."""
    read = np.zeros(19)
    _call("shim_look", tables.as_lanes, segment, 0, guard, level, order, float(time), read)
    return Look(read[:16], *read[16:].tolist())
