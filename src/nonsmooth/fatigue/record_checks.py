"""Checks of records: samples and their times."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.fatigue.checks import Array, real_numbers

__all__ = ["check_times", "record_values"]


def record_values(name: str, values: Any) -> Array:
    """Samples of a record: one dimension, two at least, all finite."""
    try:
        found = real_numbers(values)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name}: give samples as numbers, not {values!r:.60}") from None
    if found.ndim != 1:
        raise OptionError(f"{name} has {found.ndim} dimensions; give one series of samples")
    if found.size < 2:
        raise OptionError(f"{name} has {found.size} samples; a record needs two at least")
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        raise OptionError(
            f"{name}: {bad.size} samples are not finite, the first at index {bad[0]}; repair them"
            " or cut them off"
        )
    return found


def check_times(times: Any, size: int) -> Array:
    """Times of samples: as many, increasing."""
    found = record_values("times", times)
    if found.size != size:
        raise OptionError(f"times: {found.size} came for {size} samples; give one for each")
    back = np.flatnonzero(np.diff(found) <= 0.0)
    if back.size:
        raise OptionError(
            f"times must increase, and they do not after index {back[0]}: {found[back[0]]:.9g},"
            f" {found[back[0] + 1]:.9g}"
        )
    return found
