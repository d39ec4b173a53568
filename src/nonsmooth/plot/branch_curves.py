"""What is drawn of a branch: a quantity along it, and where it is stable and admissible."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.special_points import SpecialPoints
from nonsmooth.plot.style import axis_label, mode_numbers

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "INADMISSIBLE",
    "STABLE",
    "UNSTABLE",
    "BranchCurve",
    "branch_curve",
    "check_branch",
    "quantity",
]

Floats = npt.NDArray[np.float64]

STABLE, UNSTABLE, INADMISSIBLE = 0, 1, 2
_NEITHER = -1  # exactly where a change happens


class BranchCurve(NamedTuple):
    """A line through the points of a branch and the special points between them."""

    x: Floats
    y: Floats
    kind: npt.NDArray[np.int64]  # of the way to the next point: STABLE, UNSTABLE, INADMISSIBLE

    def ways(self, kind: int) -> npt.NDArray[np.bool_]:
        """Which points have a way of one kind to the next one."""
        return np.append(self.kind == kind, False)


def check_branch(branch: xr.Dataset) -> str:
    """The dataset is a branch; its parameter."""
    parameter = str(branch.attrs.get("parameter", ""))
    if "point" not in branch.dims or parameter not in branch or "stable" not in branch:
        raise OptionError(
            "the dataset is no branch: it has no dimension 'point' with orbits over a parameter;"
            " give it a result of continue_orbit"
        )
    if branch.sizes["point"] == 0:
        raise OptionError("the branch has no points to draw; see its attribute 'message'")
    return parameter


def quantity(branch: xr.Dataset, name: str, leg: int | str | None = None) -> tuple[Floats, str]:
    """A number for each point of a branch, and the label of its axis."""
    if name == "multipliers":
        sizes = np.abs(branch["multipliers"].transpose("point", "multiplier").values)
        largest = np.max(np.where(np.isnan(sizes), -1.0, sizes), axis=1, initial=0.0)
        label = "modulus of the largest multiplier"
        return np.where(np.all(np.isnan(sizes), axis=1), np.nan, largest), label
    if name == "durations":
        return _duration(branch, leg)
    if leg is not None:
        raise OptionError(f"leg = {leg!r} says whose duration is meant, and {name!r} has no legs")
    curves = [
        str(v)
        for v in (*branch.data_vars, *branch.coords)
        if branch[v].dims == ("point",) and branch[v].dtype.kind in "fiu"
    ]
    if name not in curves:
        known = [*curves, *(v for v in ("multipliers", "durations") if v in branch)]
        raise OptionError(unknown_name("variable", name, known))
    return branch[name].values.astype(float), axis_label(branch[name])


def _duration(branch: xr.Dataset, leg: int | str | None) -> tuple[Floats, str]:
    """How long one leg takes, or all legs in one mode together."""
    count = branch.sizes["leg"]
    durations = branch["durations"].transpose("point", "leg").values.astype(float)
    if isinstance(leg, str):
        modes = branch["leg_mode"].attrs.get("flag_meanings", "").split()
        if leg not in modes:
            raise OptionError(f"leg: {unknown_name('mode', leg, modes)}")
        numbers = mode_numbers(branch.rename(leg_mode="mode"), leg)
        here = np.isin(branch["leg_mode"].transpose("point", "leg").values, numbers)
        total = np.sum(np.where(here, durations, 0.0), axis=1)
        return np.where(np.all(np.isnan(durations), axis=1), np.nan, total), (
            f"time in {leg.replace('_', ' ')} per turn"
        )
    if leg is None or not 0 <= leg < count:
        raise OptionError(
            f"leg = {leg!r}: of which leg? Give its number, 0 to {count - 1}, or the name of a mode"
            " for all legs in it"
        )
    return durations[:, leg], f"duration of leg {leg}"


def branch_curve(
    branch: xr.Dataset, points: tuple[Floats, Floats], special: SpecialPoints,
    places: tuple[Floats, Floats],
) -> BranchCurve:  # fmt: skip
    """Line through the points of a branch; it changes its kind at special points.

    ``points`` and ``places`` are x and y of the points of the branch and of the special points.
    """
    kind = np.where(branch["stable"].values.astype(bool), STABLE, UNSTABLE)
    if "admissible" in branch:
        kind = np.where(branch["admissible"].values.astype(bool), kind, INADMISSIBLE)
    # a special point that is a point of the branch: rounding says which kind it is
    inner = np.flatnonzero((special.share > 0.0) & (special.share < 1.0))
    exact = special.before + (special.share == 1.0)
    kind[np.delete(exact, inner)] = _NEITHER
    place = special.before[inner] + 1
    x, y = (np.insert(old, place, new[inner]) for old, new in zip(points, places, strict=True))
    return BranchCurve(x, y, _ways(np.insert(kind, place, _NEITHER)))


def _ways(kinds: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Kind of the way from each point to the next: the worse of both where it is open."""
    ways = np.maximum(kinds[:-1], kinds[1:])
    for k in range(1, ways.size):  # between two special points
        ways[k] = ways[k - 1] if ways[k] == _NEITHER else ways[k]
    known = ways[ways != _NEITHER]
    ways[ways == _NEITHER] = known[0] if known.size else STABLE
    return ways
