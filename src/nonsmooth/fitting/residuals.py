"""Data of the segments of a record, and their residuals with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Residuals", "SegmentData", "in_order_of_segments", "joined", "no_residuals"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


class SegmentData(NamedTuple):
    """Which data lie in a segment; samples of one instant are run once."""

    times: Floats  # (K,) of samples
    instant: Integers  # (N,) of each sample
    channel: Integers  # (N,)
    data: Floats  # (N,)
    place: Integers  # (N,): sample of the record
    event_channel: Integers  # (E,) of picked events, in order of time
    event_time: Floats  # (E,)
    event_place: Integers  # (E,)


class Residuals(NamedTuple):
    """Residuals of data, in units of the noise of each channel, with derivatives."""

    residual: Floats  # (N,)
    head: Floats  # (N, h)
    state: Floats  # (N, n), by the state at the start of the own segment
    channel: Integers  # (N,)
    place: Integers  # (N,): sample of the record, or picked event
    segment: Integers  # (N,)
    matched: Bools  # (N,): not so where the motion has no event for a picked one
    surplus: Floats  # (M,): weight of the events of each segment that were not picked
    n_surplus: Integers  # (M,): how many these are


def no_residuals(h: int, n: int, segments: int) -> Residuals:
    """Residuals of no data in some segments, for h entries of the head and n states."""
    none, whole = np.zeros(0), np.zeros(0, np.int64)
    return Residuals(
        none, np.zeros((0, h)), np.zeros((0, n)), whole, whole, whole, np.zeros(0, bool),
        np.zeros(segments), np.zeros(segments, np.int64),
    )  # fmt: skip


def in_order_of_segments(found: Residuals) -> Residuals:
    """The same residuals as the solver takes them."""
    order = np.argsort(found.segment, kind="stable")
    return Residuals(
        found.residual[order], found.head[order], found.state[order], found.channel[order],
        found.place[order], found.segment[order], found.matched[order], found.surplus,
        found.n_surplus,
    )  # fmt: skip


def joined(parts: Sequence[Residuals]) -> Residuals:
    """Residuals one after the other."""
    return Residuals(*(np.concatenate(each) for each in zip(*parts, strict=True)))
