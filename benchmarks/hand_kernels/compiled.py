"""Kernels in C, compiled when a benchmark starts and for the processor that runs it.

A kernel is a C file in this folder. The Python module of the same name declares its functions and
gives them the arguments that scripts have: numpy arrays of doubles and numbers. Calls let other
threads run meanwhile, as ctypes does.
"""

import ctypes
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[2]))
from build_engine import compiler

FOLDER = Path(__file__).parent
# The compiler of the engine takes C as well. Contraction of products and sums, which some compilers
# leave out where a standard is named, keeps the meaning of every comparison; a free order of sums
# or the assumption that all numbers are finite would not.
FLAGS = ["-x", "c", "-std=c11", "-O3", "-march=native", "-fno-math-errno", "-ffp-contract=fast"]

REAL, INTEGER = ctypes.c_double, ctypes.c_int64
NO_REALS = REAL * 0


class REALS:
    """The type of an argument that is an array of doubles; quicker than numpy's own."""

    @staticmethod
    def from_param(array):
        """Where the array begins; an array with gaps has no buffer."""
        assert array.dtype == np.float64
        return NO_REALS.from_buffer(array)


class Counts(ctypes.Structure):
    """What the kernels of long runs return (first_crossing.h)."""

    _fields_ = (("events", INTEGER), ("evaluations", INTEGER))


def version():
    """The compiler, as it calls itself."""
    said = subprocess.run([*compiler(), "--version"], capture_output=True, text=True, check=True)
    return said.stdout.splitlines()[0]


def library(name):
    """The functions of a C file, compiled now."""
    # a library that is loaded does without its file, but on Windows, where the folder stays
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        made = Path(folder) / name
        source = FOLDER / f"{name}.c"
        command = [*compiler(), *FLAGS, "-shared", "-fPIC", str(source), "-o", str(made), "-lm"]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(made))


def function(library, name, result, *arguments):
    """A function with its types declared."""
    found = getattr(library, name)
    found.restype, found.argtypes = result, arguments
    return found
