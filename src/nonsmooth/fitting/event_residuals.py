"""Residuals of picked events, and which event of a motion a picked one is.

Both are instants in order. Where there are as many of one as of the other they belong together in
order, however far apart they still are. Otherwise two belong together if each is the nearest of the
other, which keeps the order.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.fitting.event_instants import EventInstants
from nonsmooth.fitting.residuals import Residuals, SegmentData, no_residuals

__all__ = ["matched_to", "residuals_of_events"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def residuals_of_events(
    found: EventInstants,
    plan: SegmentData,
    picked: Sequence[int],
    waits: Sequence[float],
    noise: Floats,
    h: int,
    n: int,
    *,
    repeats: bool,
) -> Residuals:
    """Residuals of the events picked in a segment, with derivatives by its start and parameters.

    Where the motion has no event for a picked one, the residual is the time between events.
    ``picked`` are the channels, ``waits`` how far an event may be from the picked one that it is;
    h entries of the head, n states.
    """
    count, p = plan.event_time.size, found.columns.shape[1] - n
    result = no_residuals(h, n, 1)._replace(
        residual=np.empty(count),
        head=np.zeros((count, h)),
        state=np.zeros((count, n)),
        channel=plan.event_channel,
        place=plan.event_place,
        matched=np.zeros(count, bool),
    )
    for k, (c, wait) in enumerate(zip(picked, waits, strict=True)):
        own, there = np.flatnonzero(plan.event_channel == c), np.flatnonzero(found.name == k)
        of = matched_to(plan.event_time[own], found.times[there], wait, repeats=repeats)
        missed = of < 0
        result.residual[own[missed]] = wait / noise[c]
        here, event = own[~missed], there[of[~missed]]
        result.residual[here] = (found.times[event] - plan.event_time[here]) / noise[c]
        columns = found.columns[event] / noise[c]
        result.head[here, :p] = columns[:, n:]
        result.state[here] = columns[:, :n]
        result.matched[here] = True
        more = there.size - np.unique(of[~missed]).size
        result.n_surplus[0] += more
        result.surplus[0] = np.hypot(result.surplus[0], np.sqrt(more) * wait / noise[c])
    return result


def matched_to(picked: Floats, found: Floats, wait: float, *, repeats: bool) -> Integers:
    """Place of the event of the motion that each picked one is, -1 for none within ``wait``.

    Where the motion ``repeats`` itself, each of its events may have been picked many times.

    shapes: picked (E,) and found (F,) in order; returns (E,)
    """
    if not found.size or not picked.size:
        return np.full(picked.size, -1)
    if picked.size == found.size and not repeats:
        return np.arange(picked.size)
    nearest = _nearest(picked, found)
    if not repeats:
        mutual = _nearest(found, picked)[nearest] == np.arange(picked.size)
        nearest = np.where(mutual, nearest, -1)
    near = np.abs(picked - found[nearest]) < wait
    return np.where(near & (nearest >= 0), nearest, -1)


def _nearest(these: Floats, those: Floats) -> Integers:
    """Place of the nearest of those for each of these."""
    behind = np.clip(np.searchsorted(those, these), 0, those.size - 1)
    before = np.maximum(behind - 1, 0)
    is_before = np.abs(these - those[before]) <= np.abs(those[behind] - these)
    nearest: Integers = np.where(is_before, before, behind)
    return nearest
