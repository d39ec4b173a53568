"""Whether a motion that does not repeat is chaotic, comes back to where it was, or goes elsewhere.

A neighbour that approaches a motion tells nothing of where that motion goes: next to one that
creeps towards a point, or runs away, others close in too. So two windows of its states are
compared.

The 0-1 test takes strobes with the period taken off that they nearly have. Weak chaos often
visits a few narrow bands in turn. That is a strong periodic part with little chaos on it, and the
test would need a very long series to see it. The mean of every band taken off, what is left is
chaotic or not as before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from nonsmooth.analysis.zero_one_test import correlations_of

__all__ = [
    "APART", "StrobeTest", "elsewhere", "no_closed_orbit", "runs_away", "strobe_test", "travels",
]  # fmt: skip

APART = 0.05  # of its spread by which a state may differ between two windows of one closed curve
_MOST = 0.9  # of the later states lie that close to earlier ones; a cycle has fast parts too
_RUNAWAY = 10.0  # times the spread of the window before is no bounded motion
_FREQUENCIES = 25  # of the 0-1 test
_LONGEST = 50  # period that the 0-1 test takes off
_EPSILON = float(np.finfo(float).eps)

Floats = npt.NDArray[np.float64]


def elsewhere(earlier: Floats, later: Floats, floor: Floats) -> npt.NDArray[np.bool_]:
    """Which states take other values in the later window: their range, or the time in its parts.

    The values of each window are sorted and compared one by one, from the smallest to the largest;
    the mean difference counts beside the spread of both windows. A short spike, which samples may
    miss, counts for no more than it lasts.

    shapes: earlier and later (K, n); floor (n,): a spread below it is none
    """
    spread = np.ptp(np.concatenate([earlier, later]), axis=0)
    away = np.abs(np.sort(later, axis=0) - np.sort(earlier, axis=0)).mean(axis=0)
    return np.asarray(away > APART * np.maximum(spread, floor))


def no_closed_orbit(
    earlier: Floats, later: Floats, names: tuple[str, ...], sizes: Floats, turns: bool, match: float
) -> str:
    """Why two windows show no closed orbit, "" where they do.

    One state alone goes one way for ever unless events turn it back.

    shapes: earlier and later (K, n), drifting states left out; sizes (n,) of the states since the
    start; turns: whether events happen
    """
    if len(names) < 2 and not turns:
        return (
            "one state that no event turns back has no cycle: it comes to rest slowly, grows or"
            " travels"
        )
    both = np.concatenate([earlier, later])
    floor = np.maximum(match * match * sizes, 4.0 * _EPSILON / match * np.abs(both).max(axis=0))
    changed = elsewhere(earlier, later, floor)
    if np.any(changed):
        which = ", ".join(name for name, is_one in zip(names, changed, strict=True) if is_one)
        return (
            f"the range of {which} still changes from window to window: a motion that comes to"
            " rest slowly, grows or travels, or a window shorter than some cycles"
        )
    spread = np.ptp(both, axis=0)
    if np.all(spread <= floor):
        return "nothing moves any more"
    scale = np.maximum(spread, floor)
    distances, _ = KDTree(earlier / scale).query(later / scale, p=np.inf)
    if np.quantile(distances, _MOST) > APART:
        return "the later states do not lie on the curve of the earlier ones"
    return ""


def runs_away(earlier: Floats, later: Floats) -> str:
    """Why two windows show a motion that grows without bound, "" where they do not."""
    if np.any(np.ptp(later, axis=0) > _RUNAWAY * np.ptp(earlier, axis=0)):
        return "the motion grows tenfold from window to window"
    return ""


def travels(earlier: Floats, later: Floats, names: tuple[str, ...]) -> str:
    """Which states left the range that they had in the window before, "" where none did."""
    left = (later.min(axis=0) > earlier.max(axis=0)) | (later.max(axis=0) < earlier.min(axis=0))
    if not np.any(left):
        return ""
    which = ", ".join(name for name, is_one in zip(names, left, strict=True) if is_one)
    return f"{which} travels: it has left its range of the window before (drift= declares a drift)"


class StrobeTest(NamedTuple):
    """K of a series, and how near it comes to repeating: root mean square, in its own scatter."""

    k: float
    nearest: float


def strobe_test(values: Floats) -> StrobeTest:
    """Test of one series without its strongest period."""
    periods = range(1, min(_LONGEST, values.size // 4) + 1)
    distance = [float(np.square(values[p:] - values[:-p]).mean()) for p in periods]
    p = 1 + int(np.argmin(distance))
    scatter = 2.0 * float(values.var())
    rest = values - values.mean()
    for k in range(p):
        rest[k::p] -= rest[k::p].mean()
    return StrobeTest(
        float(np.median(correlations_of(rest, _FREQUENCIES, 0)[1])),
        float(np.sqrt(distance[p - 1] / scatter)) if scatter > 0.0 else 0.0,
    )
