"""Compiling the kernels ahead of time."""

from __future__ import annotations

import time

import numpy as np

from nonsmooth.engine.lanes import as_lanes, run_lanes
from nonsmooth.engine.layout import allocate_segment, allocate_tables, stack_of_one
from nonsmooth.engine.records import allocate_anchor, allocate_records
from nonsmooth.engine.tangent import allocate_tangent
from nonsmooth.engine.variation_tables import no_columns, no_rates
from nonsmooth.simulation.simulate import simulate
from nonsmooth.system.parts import Mode
from nonsmooth.system.system import System

__all__ = ["warm_up", "warm_up_loop"]


def warm_up() -> float:
    """Compile every kernel and store the machine code; returns the seconds it took.

    Returns
    -------
    float
        Seconds; a few tenths when the kernels were compiled already.

    Examples
    --------
    >>> from nonsmooth.simulation.warmup import warm_up
    >>> warm_up() >= 0.0
    True
    """
    began = time.monotonic()
    simulate(_decay(), {"x": 1.0}, t_end=1.0, tangent=[])
    return time.monotonic() - began


def warm_up_loop() -> None:
    """Compile the loop alone, the largest kernel: no lane is run, so it needs no tables made."""
    program = _decay().compiled.program
    lanes = as_lanes(
        allocate_anchor(program.sizes),
        allocate_tangent(program.sizes, -1, 0),
        allocate_records(program.sizes, np.zeros(0, np.int64), np.zeros(0), 0),
    )
    anchors, tangents, records = lanes
    nothing, passed = np.zeros(1, np.int64), np.zeros(2, np.int64)
    run_lanes(
        stack_of_one(allocate_tables(program)), no_rates(), no_columns(), anchors,
        allocate_segment(program.sizes), tangents, records, nothing.copy(), 0, 0, 0, 0.0, passed,
        nothing, 0.0,
    )  # fmt: skip


def _decay() -> System:
    return System(states=["x"], modes={"decay": Mode({"x": "-x"})})
