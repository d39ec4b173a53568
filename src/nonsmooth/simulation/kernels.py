"""Say so when the kernels have to be compiled now."""

from __future__ import annotations

import sys

__all__ = ["announce_compilation", "announce_derivatives", "announce_orbits"]

_announced = False
_announced_derivatives = False
_announced_orbits = False


def announce_compilation() -> None:
    """Print one line if the kernels are not compiled yet on this installation."""
    global _announced
    if _announced:
        return
    _announced = True
    from nonsmooth.engine.jit import is_kept, is_warm
    from nonsmooth.engine.lanes import run_lanes

    if is_warm(run_lanes):
        return
    if is_kept(run_lanes):
        text = "once for this installation (some minutes)"
    else:
        text = (
            "for this process alone (some minutes): none of the folders where numba keeps"
            " machine code can be written; set NUMBA_CACHE_DIR to one that can"
        )
    print(f"nonsmooth: compiling its kernels, {text}", file=sys.stderr, flush=True)


def announce_derivatives() -> None:
    """Print one line if what derivatives need on top is not compiled yet."""
    global _announced_derivatives
    if _announced_derivatives:
        return
    _announced_derivatives = True
    from nonsmooth.engine.jit import is_warm
    from nonsmooth.engine.variation_setup import set_up_rates

    if not is_warm(set_up_rates):
        text = "nonsmooth: compiling the kernels of derivatives (some seconds)"
        print(text, file=sys.stderr, flush=True)


def announce_orbits() -> None:
    """Print one line if what periodic orbits need on top is not compiled yet."""
    global _announced_orbits
    if _announced_orbits:
        return
    _announced_orbits = True
    from nonsmooth.engine.jit import is_warm
    from nonsmooth.engine.legs import pass_legs

    if not is_warm(pass_legs):
        text = "nonsmooth: compiling the kernels of periodic orbits (some minutes)"
        print(text, file=sys.stderr, flush=True)
