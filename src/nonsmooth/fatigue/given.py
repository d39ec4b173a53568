"""Checks of numbers and records that are given, with messages that say which one is wrong."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError

__all__ = ["Floats", "check_times", "finite", "positive", "record_values"]

Floats = npt.NDArray[np.float64]


def finite(name: str, value: Any) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise OptionError(f"{name} = {value!r:.60} is not a finite number")
    return float(value)


def positive(name: str, value: Any, unit: str = "") -> float:
    """A finite number above zero."""
    number = finite(name, value)
    if number <= 0.0:
        raise OptionError(f"{name} = {number:g}{unit and ' ' + unit}: it must be above zero")
    return number


def record_values(name: str, values: Any) -> Floats:
    """Samples of a record: one dimension, two at least, all finite."""
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
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


def check_times(times: Any, size: int) -> Floats:
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
