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
    from nonsmooth.engine.jit import is_kept, is_warm
    from nonsmooth.engine.loop import run

    if is_warm(run):
        return
    if is_kept(run):
        text = "once for this installation (a minute or two)"
    else:
        text = (
            "for this process alone (a minute or two): none of the folders where numba keeps"
            " machine code can be written; set NUMBA_CACHE_DIR to one that can"
        )
    print(f"nonsmooth: compiling its kernels, {text}", file=sys.stderr, flush=True)
