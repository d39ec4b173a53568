"""Samples that are missing, not finite or codes for no reading."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.measured.places import Places

__all__ = ["check_finite"]

_LARGEST = 1e30  # a reading; codes for none are often larger still

Floats = npt.NDArray[np.float64]


def check_finite(
    arrays: Mapping[str, Floats], start: float, step: float, first: int, places: Places
) -> None:
    """Refuse gaps, and say where the first one is and which part of the record has none.

    first: number of the first sample, before a part was cut out
    """
    for name, values in arrays.items():
        with np.errstate(invalid="ignore"):
            large = np.isfinite(values) & (np.abs(values) > _LARGEST)
        if large.any():
            k = int(np.argmax(large))
            raise OptionError(
                f"{name}: {values[k]:g} at t = {start + step * k:.7g} is beyond"
                f" {_LARGEST:g} ({places.at(first + k)}{places.note}); what"
                " does the recorder write where it has no reading?"
            )
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size == 0:
            continue
        ends = np.concatenate([[-1], bad, [values.size]])
        k = int(np.argmax(np.diff(ends)))
        low, high = start + step * (ends[k] + 1), start + step * (ends[k + 1] - 1)
        raise OptionError(
            f"{places.fault(name, first + int(bad[0]))}{name}: {bad.size} samples are not finite,"
            f" the first at t = {start + step * bad[0]:.7g}; the longest part without a gap is"
            f" time_range=({low:.9g}, {high:.9g})"
        )
