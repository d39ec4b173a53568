"""Quality flags beside a channel: a mask over time that filters and integrals carry on.

A mask is a coordinate ``x_quality`` of the channel ``x``, an ancillary variable of the standard
name ``quality_flag`` as the CF conventions have it. Flaws may meet in one sample, so the flags are
bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.measured.quality.flaw import FLAGS

__all__ = ["carried", "is_mask", "mask_words", "masked", "masks_at", "quality_of"]

Flags = npt.NDArray[np.uint8]

_BEHIND = "_quality"  # the name of a channel


def mask_words(name: str) -> dict[str, Any]:
    """Attributes of the mask of a channel."""
    return {
        "long_name": f"quality of {name}",
        "standard_name": "quality_flag",
        "flag_masks": np.array(list(FLAGS.values()), dtype=np.uint8),
        "flag_meanings": " ".join(FLAGS),
    }


def quality_of(data: xr.Dataset, name: str) -> Flags | None:
    """Flags of the samples of a channel; None where it has no mask."""
    mask = f"{name}{_BEHIND}"
    return data[mask].values.astype(np.uint8) if mask in data.variables else None


def is_mask(data: xr.Dataset, name: str) -> bool:
    """Whether a coordinate is the mask of a channel."""
    return name.endswith(_BEHIND) and data[name].attrs.get("standard_name") == "quality_flag"


def masked(
    data: xr.Dataset, flags: Mapping[str, Flags], dim: str | tuple[str, ...] = "time"
) -> xr.Dataset:
    """Data with the masks of some channels as coordinates."""
    found = data.assign_coords(
        {f"{name}{_BEHIND}": (dim, each, mask_words(name)) for name, each in flags.items()}
    )
    for name in flags:
        found[name].attrs["ancillary_variables"] = f"{name}{_BEHIND}"
    return found


def carried(
    data: xr.Dataset, found: xr.Dataset, sources: Mapping[str, str], reach: int, part: slice
) -> xr.Dataset:
    """What a filter has made of data, with the flags of every sample that it has taken in.

    sources: the channel that each variable was made of; reach: samples that the filter takes in on
    either side; part: what is left of the samples
    """
    flags = {}
    for name, source in sources.items():
        before = quality_of(data, source)
        if before is not None:
            flags[name] = _widened(before, reach)[part]
    return masked(found, flags) if flags else found


def masks_at(data: xr.Dataset, first: npt.NDArray[np.int64], count: int) -> dict[str, Flags]:
    """Flags that ``count`` samples from each of the ``first`` ones on have together, by channel."""
    flags = {}
    for name in map(str, data.data_vars):
        before = quality_of(data, name)
        if before is not None:
            flags[name] = np.bitwise_or.reduce([before[first + k] for k in range(count)])
    return flags


def _widened(flags: Flags, reach: int) -> Flags:
    """Flags of each sample and of its neighbours on either side."""
    from scipy.ndimage import maximum_filter1d

    found = np.zeros_like(flags)
    for bit in FLAGS.values():
        here = (flags & bit > 0).astype(np.uint8)
        found |= maximum_filter1d(here, 2 * reach + 1, mode="constant") * np.uint8(bit)
    return found
