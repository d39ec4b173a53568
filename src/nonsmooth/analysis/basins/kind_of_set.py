"""What a motion is that does not repeat: chaotic, quasi-periodic, or on its way out of chaos."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.folded_runner import turned
from nonsmooth.analysis.statistics.block_averages import block_averages, means_differ

__all__ = ["ESCAPING", "kind_of_set"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_STANDARD_ERRORS = 3.0  # above which a largest exponent is taken to be positive
_TOGETHER = 4  # iterates in a step of the exponent; more may span more digits than there are
_TURNING = 10  # steps in which the direction turns to the fastest
_NEUTRAL = 3.0  # logarithm of the growth over all steps that may come from a torus as well
ESCAPING = "escaping"  # kind of a set of points that was chaotic at first


def kind_of_set(
    runner: Any, points: Floats, modes: Integers, drifting: npt.NDArray[np.bool_], steps: int
) -> Attractor:
    """A set of points that does not repeat, with its largest exponent.

    It is chaotic up to the second half of the iterates of the exponent, at least.
    """
    found = Attractor(
        points=points,
        modes=modes,
        period=0,
        drift=np.where(drifting, (points[-1] - points[0]) / max(1, len(points) - 1), 0.0)
        + turned(runner, points[0], int(modes[0]), len(points)) / len(points),
    )
    rates = _growth(runner, points[-1], int(modes[-1]), drifting, steps)
    exponent, error = _mean(rates)
    kind, neutral, chaotic_for = "aperiodic", _NEUTRAL / (_TOGETHER * steps), 0
    if exponent > max(_STANDARD_ERRORS * error, neutral):
        first, second = map(_mean, np.array_split(rates, 2))
        if means_differ(first, second, 2.0 * neutral):
            kind = ESCAPING
        else:
            kind, chaotic_for = "chaotic", len(points) + _TOGETHER * (rates.size // 2)
    elif abs(exponent) <= neutral:
        kind = "quasi-periodic"
    return replace(
        found, kind=kind, exponent=exponent, exponent_error=error, chaotic_for=chaotic_for
    )


def _growth(
    runner: Any, state: Floats, mode: int, drifting: npt.NDArray[np.bool_], steps: int
) -> Floats:
    """Growth per iterate, in each step, of the states that do not drift; (steps,) or less.

    That of one direction, which turns to the fastest within the first steps. Minus infinity where
    every direction dies at once, nan where the motion ends.
    """
    free = np.ix_(~drifting, ~drifting)
    direction = np.random.default_rng(0).standard_normal(int(np.sum(~drifting)))
    growth = []
    for _ in range(steps):
        found = runner.images(state, mode, _TOGETHER)
        if found is None:
            return np.array([np.nan])
        images, modes, derivative = found
        direction = derivative[free] @ direction
        size = float(np.linalg.norm(direction))
        if size == 0.0:
            return np.array([-np.inf])
        growth.append(np.log(size) / _TOGETHER)
        direction /= size
        state, mode = images[-1], int(modes[-1])
    return np.array(growth[_TURNING:])


def _mean(rates: Floats) -> tuple[float, float]:
    """Mean of rates with its standard error."""
    if not np.all(np.isfinite(rates)):
        return float(rates[-1]), 0.0
    return float(rates.mean()), float(block_averages(rates[:, None]).standard_error[0])
