"""Say so when the kernels have to be compiled now."""

from __future__ import annotations

import sys

__all__ = ["announce_compilation"]

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
