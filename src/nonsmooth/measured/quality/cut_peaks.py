"""Single peaks that are cut off: flat tops into which a signal rises too steeply to stop there.

A smooth signal slows down before it stands still, and so does a mass that friction holds. What is
clipped keeps its slope up to the flat top and has it again behind it: the parabolas through the
samples on either side both lead well beyond the rail.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from nonsmooth.measured.quality.flaw import Readings

__all__ = ["cut_tops"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int64]

_LEAST = 3  # equal samples that are a flat top
_MOST = 20  # flat tops that are looked at, the longest ones
_FEWEST, _REACH = 5, 8  # samples on either side that tell the slope
_NEAR = 0.5  # of the range of the channel, within which they lie, or they are no part of the peak
_LEVELS = 64  # of the recorder, by which the channel moves at least
_FITS = 0.1  # of the way beyond the rail, that they may be off their parabola


def cut_tops(data: Readings, rail: float, first: Places, length: Places) -> Mask:
    """Which of the longest flat tops at a rail were cut off; none where all are too short to tell.

    Rounding moves an extrapolation by half a step times the sizes of its weights at most, and
    noise moves it by its deviation times the root of their squares. The limit for the latter is
    exceeded by chance on one side, of any of the tops, at the rate of the test; both sides must
    exceed it.
    """
    from scipy.stats import norm

    chosen = np.argsort(-length, kind="stable")[:_MOST]
    chosen = chosen[length[chosen] >= _LEAST]
    if not chosen.size or _range(data) < _LEVELS * data.noise.step:
        return np.zeros(0, bool)
    deviations = float(norm.isf(data.rate / chosen.size))
    sign = 1.0 if rail == np.nanmax(data.values) else -1.0
    found = [_is_cut_off(data, sign, int(first[k]), int(length[k]), deviations) for k in chosen]
    return np.array(found, bool)


def _is_cut_off(data: Readings, sign: float, first: int, count: int, deviations: float) -> bool:
    """Whether the samples on either side of a flat top lead beyond it."""
    reach = min(max(count, _FEWEST), _REACH)
    before = data.values[max(first - reach, 0) : first]
    behind = data.values[first + count : first + count + reach][::-1]
    return all(
        side.size == reach
        and _leads_beyond(data, sign * (side - data.values[first]), count, deviations)
        for side in (before, behind)
    )


def _leads_beyond(data: Readings, below: Floats, count: int, deviations: float) -> bool:
    """Whether the parabola through samples before a flat top is beyond it, in its middle or before.

    ``below`` is how far they lie above the rail, the last one next to it. Where they reach far
    down, or the cubic through them does not lead beyond the rail as well, they are too few for the
    motion that they belong to.
    """
    ahead = 0.5 * min(count + 1, below.size)
    weights, off = _extrapolation(below.size, ahead, 2)
    noise = data.noise
    rounding = 0.5 * noise.step
    scatter = deviations * noise.most if noise.visible else 0.0
    beyond = float(weights @ below)
    limit = rounding * (1.0 + np.abs(weights).sum()) + scatter * float(np.sqrt(weights @ weights))
    if not beyond > limit:  # nan among them, too
        return False
    cubic = _extrapolation(below.size, ahead, 3)[0] @ below
    if cubic <= 0.0 or below.min() < -_NEAR * _range(data):
        return False
    # a step and a pulse lead anywhere
    most = np.maximum(rounding * np.abs(off).sum(axis=1), _FITS * beyond)
    most += scatter * np.sqrt((off**2).sum(axis=1))
    return bool(np.all(np.abs(off @ below) <= most))


def _range(data: Readings) -> float:
    """Between the lowest and the highest sample."""
    return float(np.nanmax(data.values) - np.nanmin(data.values))


@cache
def _extrapolation(count: int, ahead: float, degree: int) -> tuple[Floats, Floats]:
    """Weights of samples in their polynomial beyond the last one, and in how far each is off it."""
    powers = np.vander(np.arange(count, dtype=float), degree + 1)
    fit = np.linalg.pinv(powers)
    weights = np.vander([count - 1.0 + ahead], degree + 1)[0] @ fit
    return weights, np.eye(count) - powers @ fit
