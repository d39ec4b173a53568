"""Angles of a motion, which repeats up to whole turns of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.system.system import System

__all__ = ["cuts_of", "folded", "periods_of", "periods_of_states", "whole_turns"]

Floats = npt.NDArray[np.float64]


def periods_of_states(system: System) -> Floats:
    """Period of each state that is an angle of the equations, zero of the others, (n,)."""
    return periods_of(system, system.states)


def periods_of(system: System, names: Sequence[str]) -> Floats:
    """The same of some names, zero of those that are no angles, (d,)."""
    return np.array([system.angles.get(name, 0.0) for name in names])


def whole_turns(changes: Floats, periods: Floats) -> Floats:
    """The whole periods of angles that are nearest to some changes; zero of other states.

    shapes: changes (..., n), periods (n,)
    """
    length = np.where(periods > 0.0, periods, 1.0)
    return np.where(periods > 0.0, length * np.rint(changes / length), 0.0)


def cuts_of(points: Floats, periods: Floats) -> Floats:
    """Where the circle of each angle is cut open for the points of each motion, (..., n).

    In the middle of the widest gap between the points, so that points that lie close together on
    the circle stay so. Of the cuts that are whole turns apart it is the one for which the middle
    of the points is within half a turn of zero.

    shapes: points (..., s, n), nan where there are none; periods (n,)
    """
    cuts = np.zeros((*points.shape[:-2], points.shape[-1]))
    for i in np.flatnonzero(periods > 0.0).tolist():
        period = periods[i]
        around = np.sort(np.mod(points[..., i], period), axis=-1)  # nan comes last
        known = np.isfinite(around)
        last = np.where(known, around, -np.inf).max(axis=-1, keepdims=True)
        gaps = np.diff(around, axis=-1, append=np.nan)
        beyond = np.where(np.isfinite(last), around[..., :1] + period - last, np.nan)
        gaps = np.where(around == last, beyond, gaps)
        widest = np.argmax(np.nan_to_num(gaps, nan=-1.0), axis=-1)[..., None]
        gap = np.take_along_axis(gaps, widest, axis=-1)[..., 0]
        cut = np.take_along_axis(around, widest, axis=-1)[..., 0] + 0.5 * gap
        cuts[..., i] = cut - period * np.rint((cut + 0.5 * period) / period)
    return np.nan_to_num(cuts)


def folded(points: Floats, cuts: Floats, periods: Floats) -> Floats:
    """Points within one turn of each angle from its cut on; a point there already is not rounded.

    shapes: points (..., n), cuts that broadcast to it, periods (n,)
    """
    length = np.where(periods > 0.0, periods, 1.0)
    turns = np.floor((points - cuts) / length)
    return np.where(periods > 0.0, points - length * turns, points)
