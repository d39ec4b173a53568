"""Samples that a check of a record has flagged, drawn apart from the good ones.

A channel ``x`` that was checked has a mask ``x_quality`` beside it, zero for good samples. What was
computed from flagged samples looks like everything else, so pictures of records, and of what was
made of them, give such samples a mark of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.plot.style import PALETTE
from nonsmooth.plot.trace import DENSE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["are_flagged", "mark_flagged"]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_LABEL = "flagged"
# told apart from lines and dots by shape, and from the colours of lines by its hue
_CROSS: dict[str, Any] = {
    "linestyle": "none",
    "marker": "x",
    "markersize": 4.0,
    "markeredgewidth": 0.9,
    "color": PALETTE["blue"],
    "zorder": 3,
}


def are_flagged(data: xr.Dataset, names: Sequence[str]) -> Bools:
    """Which samples have a flag in one of some variables over the same dimensions."""
    found = np.zeros(data[names[0]].shape, bool)
    for name in names:
        mask = f"{name}_quality"
        if mask in data.variables and data[mask].dims == data[names[0]].dims:
            found |= data[mask].values != 0
    return found


def mark_flagged(ax: Axes, across: Floats, up: Floats, flagged: Bools) -> None:
    """Crosses on flagged samples, with one entry in the legend however often it is called."""
    here = flagged & np.isfinite(across) & np.isfinite(up)
    if not here.any():
        return
    known = _LABEL in ax.get_legend_handles_labels()[1]
    ax.plot(
        across[here], up[here], **_CROSS, label="_" if known else _LABEL,
        rasterized=int(here.sum()) > DENSE,
    )  # fmt: skip
