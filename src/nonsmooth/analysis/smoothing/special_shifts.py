"""Special points of a branch of orbits, and where they are when it is smoothed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SMOOTH", "Special", "matched", "specials_of"]

# those that branches of smooth systems have too; others are of an event
SMOOTH = ("fold", "flip", "torus", "symmetry_breaking", "branch_point")

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Special:
    """A special point: its kind and the value of the parameter."""

    kind: str
    value: float


def specials_of(branch: xr.Dataset) -> list[Special]:
    """Special points of a branch that have a counterpart on smooth ones."""
    pairs = zip(branch["special_kind"].values, branch["special_value"].values, strict=True)
    return [Special(str(kind), float(value)) for kind, value in pairs if kind in SMOOTH]


def matched(exact: list[Special], smooth: list[Special]) -> tuple[Floats, Floats]:
    """Value of the counterpart of each exact point, nan without one; and those that are left.

    Of all pairs of one kind the closest one belongs together, then the closest of the rest.
    """
    pairs = sorted(
        (abs(one.value - other.value), i, j)
        for i, one in enumerate(exact)
        for j, other in enumerate(smooth)
        if one.kind == other.kind
    )
    values = np.full(len(exact), np.nan)
    left = set(range(len(smooth)))
    for _, i, j in pairs:
        if np.isnan(values[i]) and j in left:
            values[i] = smooth[j].value
            left.discard(j)
    return values, np.array([smooth[j].value for j in sorted(left)])
