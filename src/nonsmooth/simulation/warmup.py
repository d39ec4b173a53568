"""Compiling the kernels ahead of time."""

from __future__ import annotations

import time

from nonsmooth.simulation.simulate import simulate
from nonsmooth.system.parts import Mode
from nonsmooth.system.system import System

__all__ = ["warm_up"]


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
    decay = System(states=["x"], modes={"decay": Mode({"x": "-x"})})
    simulate(decay, {"x": 1.0}, t_end=1.0, tangent=[])
    return time.monotonic() - began
