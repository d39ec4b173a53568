"""An axis that ends where single values are so large that nothing else could be read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["cut_axis"]

_SHARE, _TIMES, _LEAST = 0.9, 3.0, 10.0
_LOW = 0.04  # of the height, below zero


def cut_axis(ax: Axes, values: npt.NDArray[np.float64]) -> float:
    """End the vertical axis where positive values can be read; infinite if it needs no end.

    That is at three times what nine of ten are below, or at 10.
    """
    finite = values[np.isfinite(values)]
    usual = float(np.quantile(finite, _SHARE)) if finite.size else 0.0
    top = max(_LEAST, _TIMES * usual)
    low, high = ax.get_ylim()
    set_here = low == -_LOW * high  # by an earlier call
    if not np.any(values > _TIMES * top) or not (ax.get_autoscaley_on() or set_here):
        return np.inf
    ax.set_ylim(-_LOW * top, top)
    return top
