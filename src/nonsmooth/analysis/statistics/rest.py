"""Whether motions that nothing drives are at rest, or on the last of their way there.

A state that decays to zero repeats to no part of its own size: a spiral looks alike at any size. So
the motion counts beside what the state was since the start, and beside what one strobe interval
makes of the sizes of all states: x = 0.5 at rest keeps a velocity of the size of rounding, whose
natural size is the one that a change of x by 0.5 would give it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

__all__ = ["comes_to_rest", "halves", "natural_sizes", "way_left"]

Floats = npt.NDArray[np.float64]

_ROUNDING = 16.0 * float(np.finfo(float).eps)  # of a size, from strobe to strobe
_HALF = 0.5  # of the spread of every state at most is left in the second half of a decay
_REMEMBERED = 0.5  # multiplier of a part of an interval in which neighbours do not forget
_LEAST_PART = 1e-6  # of an interval
_PART = 0.5  # of the strobes over which neighbours shrink at least, while they shrink in all


def comes_to_rest(
    points: Floats,
    ranges: Floats,
    natural: Floats,
    block: Floats | None,
    match: float,
    *,
    passes: bool,
) -> bool:
    """Whether a motion keeps within ``match`` of its natural sizes, and nearer and nearer to rest.

    As its neighbours do; or where it passes from mode to mode, by half or more of every spread, as
    derivatives over one interval say nothing there.

    shapes: points (K, k) of strobes in a row without drifts; ranges (k,) of the states over them;
    natural (k,), see `natural_sizes`; block (k, k) of derivatives over an interval behind the last
    strobe, None where not known; passes: whether events happened
    """
    if not np.all(ranges <= match * natural):
        return False
    if passes:
        return bool(np.all(halves(points[None])))
    return block is not None and _approaches(points, block, natural, match)


def halves(points: Floats) -> npt.NDArray[np.bool_]:
    """Which states have lost half of their spread or more in the second half of their points.

    shapes: points (M, K, k); returns (M, k)
    """
    middle = points.shape[1] // 2
    before, now = (np.ptp(part, axis=1) for part in (points[:, : middle + 1], points[:, middle:]))
    return np.asarray(now <= _HALF * before)


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


def _approaches(points: Floats, block: Floats, natural: Floats, match: float) -> bool:
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
