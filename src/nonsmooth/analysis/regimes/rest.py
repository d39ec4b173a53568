"""Whether motions rest, or are on their last way to where they will.

A state that decays to zero repeats to no part of its own size: a spiral looks alike at any size. So
the motion counts beside what the state was since the start, and beside what one strobe interval
makes of the sizes of all states: x = 0.5 at rest keeps a velocity of the size of rounding, whose
natural size is the one that a change of x by 0.5 would give it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.window import Windows

__all__ = ["approaches_rest", "drifts_rest", "natural_sizes", "rests", "sunk", "way_left"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

_ROUNDING = 16.0 * float(np.finfo(float).eps)  # of a size, from strobe to strobe
_REMEMBERED = 0.5  # multiplier of a part of an interval in which neighbours do not forget
_LEAST_PART = 1e-6  # of an interval
_PART = 0.5  # of the windows over which neighbours shrink at least, while they shrink in all


def rests(windows: Windows, i: int, drifting: Bools, sizes: Floats, match: float) -> bool:
    """Whether the states of motion i between strobes are those at strobes, but for drifts."""
    here = windows.points[i, -1]
    away = np.abs(windows.between[i] - here).max(axis=0)
    close = away <= match * np.maximum(np.abs(here), match * sizes)
    same_mode = np.all(windows.modes_between[i] == windows.modes[i, -1])
    return bool(np.all(close | drifting) and same_mode)


def drifts_rest(windows: Windows, i: int, drifting: Bools, first: Floats, match: float) -> bool:
    """Whether drifts have come to rest: hardly a step is left of the way since the start."""
    here, before = windows.points[i, -1], windows.points[i, -2]
    way = np.abs(here - first) * match
    step = np.maximum(np.abs(windows.between[i] - here).max(axis=0), np.abs(here - before))
    return bool(np.all((step <= way + _ROUNDING * np.abs(here))[drifting]))


def sunk(windows: Windows, drifting: Bools, sizes: Floats, match: float, driven: bool) -> Bools:
    """Which motions have died away, events included: to ``match`` times ``match`` of their sizes.

    Events go on for ever where a motion comes to rest on a surface. A force may switch modes
    although no state moves, so all states of a driven motion must have died away to zero.

    sizes: (M, n) since the start
    """
    left = np.maximum(np.abs(windows.low), np.abs(windows.high)) if driven else windows.ranges
    away = np.all((left <= match * match * sizes) | drifting, axis=1)
    return np.asarray(away & np.any((sizes > 0.0) & ~drifting, axis=1))


def natural_sizes(sizes: Floats, block_over: Callable[[float], Floats | None]) -> Floats:
    """Sizes since the start, or what a part of an interval makes of those of all states.

    The part is short enough that neighbours do not forget where they began.

    shapes: sizes (k,); block_over: derivatives (k, k) over a part of the interval after the last
    strobe, None where they are not known
    """
    natural, part = sizes, 1.0
    while part > _LEAST_PART and (block := block_over(part)) is not None:
        natural = np.maximum(natural, np.abs(block) @ sizes)
        if np.abs(np.linalg.eigvals(block)).max() > _REMEMBERED:
            break
        part /= 8.0
    return natural


def way_left(points: Floats, block: Floats) -> Floats:
    """Distance of each strobe but the last from where a map with these derivatives rests.

    Infinite where no such point is known. shapes: points (K, k), block (k, k); returns (K - 1, k)
    """
    steps = np.diff(points, axis=0)
    try:
        return np.asarray(np.abs(np.linalg.solve(np.eye(len(block)) - block, steps.T).T))
    except np.linalg.LinAlgError:
        return np.full(steps.shape, np.inf)


def approaches_rest(points: Floats, block: Floats, natural: Floats, match: float) -> bool:
    """Whether strobes lie within ``match`` of a point of rest and come nearer as neighbours do.

    A cycle as small as that keeps its distance. shapes: points (2 R + 1, k) of two windows in one
    mode; block (k, k), natural (k,)
    """
    modulus = float(np.abs(np.linalg.eigvals(block)).max(initial=0.0))
    if not modulus < 1.0:
        return False
    away = way_left(points, block)
    if not np.all(away[-1] <= match * natural):
        return False
    half = len(away) // 2
    unit = np.where(natural > 0.0, natural, 1.0)
    before, now = ((part / unit).max(initial=0.0) for part in (away[:half], away[half:]))
    inverse = np.abs(np.linalg.inv(np.eye(len(block)) - block))
    noise = float((_ROUNDING * (inverse @ natural) / unit).max(initial=0.0))
    return bool(now <= max(before * modulus ** (_PART * half), noise))
