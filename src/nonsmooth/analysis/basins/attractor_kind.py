"""What an attractor is: a cycle and the ball that converges to it, or a set and its exponent."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor, canonical
from nonsmooth.analysis.basins.cycles import Cycle, refine
from nonsmooth.analysis.basins.recurrences import Measure
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.engine.lanes import ANY
from nonsmooth.engine.status import Status

__all__ = ["cycle_from", "kind_of_set"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_WIDEST, _NARROWEST = 0.02, 1e-6  # radius of a ball of convergence, beside the scale
_SAME_POINT = 1e-9  # beside the scale
_PLACED = 1e-6  # beside the scale, to which the place of a cycle must be known
_DIRECTIONS = 8  # in which it is tried, beside the axes
_NEARER, _BARELY = 0.5, 0.99  # of the radius, to which all starts must have come
_MOST_ITERATES = 200_000  # of all starts of a trial
_TRANSIENT = 1e-3  # growth of starts before they shrink is made good by turns that shrink them so
_STANDARD_ERRORS = 3.0  # above which a largest exponent is taken to be positive
_TOGETHER = 4  # iterates in a step of the exponent; more may span more digits than there are
_EXPONENT_STEPS, _TURNING = 1000, 10
# A smaller exponent is none: its growth over all steps, e**3, may come from a torus as well.
_NEUTRAL = 3.0 / (_TOGETHER * _EXPONENT_STEPS)
_POINTS = 3  # of a long cycle that are tried


def cycle_from(
    runner: Any,
    measure: Measure,
    state: Floats,
    mode: int,
    period: int,
    drifting: npt.NDArray[np.bool_],
) -> Attractor | None:
    """Cycle near a point that nearly repeats; None where there is none.

    Slow motions nearly repeat too, and Newton's method tells: the cycle is not where they are.
    """
    cycle = refine(runner, state, mode, period, ~drifting, measure.scale)
    if cycle is not None:
        # points that agree to their residual's size are the same ones, gone around more than once
        scaled = measure.scaled(cycle.points)
        for shorter in range(1, period):
            if period % shorter == 0 and np.allclose(
                scaled, np.roll(scaled, -shorter, axis=0), rtol=0.0, atol=_SAME_POINT
            ):
                return cycle_from(runner, measure, state, mode, shorter, drifting)
    if cycle is None or not cycle.step <= _PLACED:
        return None
    return canonical(
        Attractor(
            points=cycle.points,
            modes=cycle.modes,
            period=period,
            drift=cycle.drift / period,
            kind="periodic",
            multipliers=cycle.multipliers,
            residual=cycle.residual,
            radius=_radius(runner, measure, cycle, drifting) if cycle.stable else np.nan,
        )
    )


def _radius(runner: Any, measure: Measure, cycle: Cycle, drifting: npt.NDArray[np.bool_]) -> float:
    """Largest tried radius from which all starts around the cycle come nearer to it.

    By half the radius, or less where that takes too long.
    """
    d, period = measure.columns.size, len(cycle.points)
    generator = np.random.default_rng(0)
    mixed = generator.standard_normal((_DIRECTIONS, d))
    mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
    directions = np.vstack([np.eye(d), -np.eye(d), mixed])
    chosen = np.unique(np.linspace(0, period - 1, min(period, _POINTS)).astype(int))
    rate = np.abs(cycle.multipliers).max(initial=0.0)
    turns = 10 if rate < 0.7 else int(np.log(_TRANSIENT) / np.log(rate)) + 10
    turns = max(1, min(turns, _MOST_ITERATES // (period * len(directions) * chosen.size)))
    nearer = max(_NEARER, min(_BARELY, 2.0 * rate**turns))
    radius = _WIDEST
    while radius > _NARROWEST:
        ends = _ends(runner, measure, cycle, directions * radius, chosen, turns)
        if np.all(ends <= nearer * radius):
            return radius
        radius /= 4.0
    return _NARROWEST


def _ends(
    runner: Any, measure: Measure, cycle: Cycle, steps: Floats, chosen: Integers, turns: int
) -> Floats:
    """Distances from the cycle at which starts beside it end, scaled; inadmissible ones left out.

    From any of its points: off a section, a start may be one point ahead of its neighbours.
    """
    scale = measure.scale[measure.columns]
    starts = np.repeat(cycle.points[chosen], len(steps), axis=0)
    starts[:, measure.columns] += np.tile(steps * scale, (len(chosen), 1))
    lanes = runner.start(starts, ANY)
    ends, _ = runner.last(lanes, len(cycle.points) * turns)
    points = measure.scaled(cycle.points)
    distance = np.linalg.norm(measure.scaled(ends)[:, None] - points[None], axis=2).min(axis=1)
    found: Floats = distance[lanes.status != Status.INADMISSIBLE]
    return np.where(np.isnan(found), np.inf, found)


def kind_of_set(
    runner: Any, points: Floats, modes: Integers, drifting: npt.NDArray[np.bool_]
) -> Attractor:
    """A set of points that does not repeat, with its largest exponent."""
    found = Attractor(
        points=points,
        modes=modes,
        period=0,
        drift=np.where(drifting, (points[-1] - points[0]) / max(1, len(points) - 1), 0.0),
    )
    exponent, error = _largest_exponent(runner, points[-1], int(modes[-1]), drifting)
    kind = "aperiodic"
    if exponent > max(_STANDARD_ERRORS * error, _NEUTRAL):
        kind = "chaotic"
    elif abs(exponent) <= _NEUTRAL:
        kind = "quasi-periodic"
    return replace(found, kind=kind, exponent=exponent, exponent_error=error)


def _largest_exponent(
    runner: Any, state: Floats, mode: int, drifting: npt.NDArray[np.bool_]
) -> tuple[float, float]:
    """Largest exponent per iterate of the states that do not drift, with its standard error.

    The growth of one direction, which turns to the fastest within the first steps. Minus infinity
    where every direction dies at once, nan where the motion ends.
    """
    free = np.ix_(~drifting, ~drifting)
    direction = np.random.default_rng(0).standard_normal(int(np.sum(~drifting)))
    growth = []
    for _ in range(_EXPONENT_STEPS):
        found = runner.images(state, mode, _TOGETHER)
        if found is None:
            return np.nan, np.nan
        images, modes, derivative = found
        direction = derivative[free] @ direction
        size = float(np.linalg.norm(direction))
        if size == 0.0:
            return -np.inf, 0.0
        growth.append(np.log(size) / _TOGETHER)
        direction /= size
        state, mode = images[-1], int(modes[-1])
    rates = np.array(growth[_TURNING:])[:, None]
    return float(rates.mean()), float(block_averages(rates).standard_error[0])
