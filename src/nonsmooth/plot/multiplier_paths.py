"""Multipliers along a branch as paths: which one of an orbit goes on as which one of the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["NO_BOUND", "multiplier_paths", "path_pieces"]

Complex = npt.NDArray[np.complex128]

_JUMPS = (  # where multipliers may jump
    "grazing", "corner", "gained", "lost",
    "crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding",
)  # fmt: skip
NO_BOUND = 1e8  # larger at a graze of a rigid wall: infinite but for rounding, and on no path
_JUMP = 0.1  # beyond it a line would show a motion that there is none of


def multiplier_paths(multipliers: npt.ArrayLike) -> Complex:
    """Multipliers (point, multiplier) in such an order that each column is one path.

    From orbit to orbit those belong together whose distances add up to the least. What is no
    number, where an orbit has fewer, stays so.
    """
    from scipy.optimize import linear_sum_assignment

    paths: Complex = np.array(multipliers, dtype=complex)
    last = paths[0].copy()
    for k in range(1, len(paths)):
        distance = np.abs(last[:, None] - paths[k][None, :])
        # missing ones take what places are left
        far = 1.0 + 2.0 * np.nansum(distance[np.isfinite(distance)])
        _, order = linear_sum_assignment(np.where(np.isfinite(distance), distance, far))
        paths[k] = paths[k][order]
        last = np.where(np.isnan(paths[k]), last, paths[k])
    return paths


def path_pieces(branch: xr.Dataset) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Straight pieces (piece, end, re and im) of all paths, and the point where each begins."""
    values = branch["multipliers"].transpose("point", "multiplier").values
    with np.errstate(invalid="ignore"):
        values = np.where(np.abs(values) <= NO_BOUND, values, np.nan)
    paths = multiplier_paths(values)
    jumps = np.zeros(max(len(paths) - 1, 0), bool)
    if branch.sizes.get("special") and jumps.size:
        at = branch["special_point"].values[np.isin(branch["special_kind"].values, _JUMPS)]
        jumps[np.clip(at, 0, jumps.size - 1)] = True
    begin, end = paths[:-1], paths[1:]
    with np.errstate(invalid="ignore"):
        drawn = np.isfinite(begin) & np.isfinite(end)
        drawn &= ~(jumps[:, None] & (np.abs(end - begin) > _JUMP))
    where = np.nonzero(drawn)
    ends = np.stack([begin[where], end[where]], axis=1)
    return np.stack([ends.real, ends.imag], axis=2), where[0]
