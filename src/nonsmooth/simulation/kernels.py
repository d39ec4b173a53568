"""Compiling the kernels ahead of time, and saying so when it has to happen now."""

from __future__ import annotations

import sys
import time

__all__ = ["announce_compilation", "warm_up"]

_announced = False


def announce_compilation() -> None:
    """Print one line if the kernels are not compiled yet on this installation."""
    global _announced
    if _announced:
        return
    _announced = True
    from nonsmooth.engine.jit import is_warm
    from nonsmooth.engine.loop import run

    if not is_warm(run):
        print(
            "nonsmooth: compiling its kernels, once for this installation (under a minute)",
            file=sys.stderr,
            flush=True,
        )


def warm_up() -> float:
    """Compile every kernel and store the machine code; returns the seconds it took.

    Returns
    -------
    float
        Seconds; a few tenths when the kernels were compiled already.

    Examples
    --------
    >>> from nonsmooth.simulation.kernels import warm_up
    >>> warm_up() >= 0.0
    True
    """
    from nonsmooth.simulation.simulate import simulate
    from nonsmooth.system.parts import Mode
    from nonsmooth.system.system import System

    began = time.monotonic()
    simulate(System(states=["x"], modes={"decay": Mode({"x": "-x"})}), {"x": 1.0}, t_end=1.0)
    return time.monotonic() - began
