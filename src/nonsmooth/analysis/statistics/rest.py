"""Whether motions that nothing drives are at rest, or on the last of their way there.

A state that decays to zero repeats to no part of its own size: a spiral looks alike at any size. So
the motion counts beside what the state was since the start, and beside what one strobe interval
makes of the sizes of all states: x = 0.5 at rest keeps a velocity of the size of rounding, whose
natural size is the one that a change of x by 0.5 would give it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.extremes import state_ranges

__all__ = ["comes_to_rest", "floor_of", "halves", "natural_sizes", "way_left"]

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

_ROUNDING = 16.0 * float(np.finfo(float).eps)  # of a size, from strobe to strobe
_HALF = 0.5  # of the spread of every state at most is left in the second half of a decay
_REMEMBERED = 0.5  # multiplier of a part of an interval in which neighbours do not forget
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # no two of its powers are whole half turns of one oscillation
# parts of an interval that are asked together, and shorter ones, each by itself
_ASKED = ((_GOLDEN**2, _GOLDEN, 1.0), *((_GOLDEN**2 / 8.0**k,) for k in range(1, 8)))
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
        return bool(np.all(halves(points[None], _ROUNDING * natural)))
    return block is not None and _approaches(points, block, natural, match)


def halves(points: Floats, floor: Floats) -> Bools:
    """Which states have lost half of their spread or more in the second half of their points.

    So has one that has none: whose spread is not above the floor.

    shapes: points (M, K, k), floor (k,) or (M, k); returns (M, k)
    """
    middle = points.shape[1] // 2
    before, now = (state_ranges(part) for part in (points[:, : middle + 1], points[:, middle:]))
    return np.asarray(now <= np.maximum(_HALF * before, floor))


def natural_sizes(
    sizes: Floats,
    chosen: Bools,
    blocks_over: Callable[[Sequence[float], Bools], tuple[Bools, Floats]],
) -> Floats:
    """Sizes since the start, or what parts of an interval make of those of all states.

    That is what each state would be if all others moved by their sizes. Several parts are asked, as
    a velocity has its turn again after half a turn of its position, and nothing of it is left then.
    They are ever shorter until neighbours in no direction forget where they began. What grows
    within a part is taken back to the size where it began.

    shapes: sizes (M, k), chosen (M,); blocks_over: derivatives (M, P, k, k) over P ever longer
    parts of the interval after the last strobe of some motions, and where they are known (M, P)
    """
    natural, going = sizes.copy(), chosen & (sizes.shape[1] > 0)
    for parts in _ASKED:
        if not np.any(going):
            break
        known, blocks = blocks_over(parts, going)
        blocks = np.where(known[..., None, None], blocks, 0.0)
        moduli = np.abs(np.linalg.eigvals(blocks))
        made = (np.abs(blocks) @ sizes[:, None, :, None])[..., 0]
        made /= moduli.max(axis=2, initial=1.0)[..., None]
        natural = np.maximum(natural, made.max(axis=1))
        # of the shortest part
        going &= ~(known[:, 0] & (moduli[:, 0].min(axis=1) > _REMEMBERED))
    return natural


def floor_of(natural: Floats, match: float) -> Floats:
    """Least scale of states of some natural size: ``match`` of it, and far above rounding.

    Strobes repeat to ``match`` of a scale, which is ``match`` squared of a natural size then.
    """
    return np.maximum(match, _ROUNDING / match) * natural


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
