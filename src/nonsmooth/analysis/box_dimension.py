"""`box_dimension`: how many boxes a set of points needs, over their size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.point_sets import Points, points_of, scaled
from nonsmooth.analysis.statistics.power_law import PowerLaw, fit_power_law
from nonsmooth.errors import OptionError, quote
from nonsmooth.runs.options import whole_number

__all__ = ["box_dimension"]

_FEWEST = 3  # sizes through which a line is fitted
_ENOUGH = 5  # fine sizes, without which the coarse ones are fitted too
_PER_BOX = 20  # points per box, at least, where the line is fitted
_COARSE = 8  # boxes per side; with fewer the shape of the set matters
_LARGEST = 2**16  # boxes per side
_BITS = 62  # of the number of a box

Floats = npt.NDArray[np.float64]


def box_dimension(
    points: xr.Dataset | xr.DataArray | npt.ArrayLike,
    *,
    attractor: int | None = None,
    states: Sequence[str] | None = None,
    boxes: Sequence[int] | None = None,
) -> xr.Dataset:
    r"""Box-counting dimension of a set of points, such as a chaotic attractor on a section.

    A grid of boxes of size :math:`\varepsilon` is laid over the points; the number of boxes with
    a point grows as :math:`\varepsilon^{-D}`.

    Parameters
    ----------
    points : xarray.Dataset, xarray.DataArray, array_like
        Result of `attractors`, of `stroboscopic_map` or `poincare_section`, or an array with one
        row per point.

    Other Parameters
    ----------------
    attractor : int, optional
        Number of an attractor, where the dataset has several.
    states : sequence of str, optional
        Coordinates that are taken from a dataset; by default all states that do not drift.
    boxes : sequence of int, optional
        Boxes per side of the extent of the points, three numbers at least, to all of which the
        line is fitted. By default 2, 3, 4, 6, 8, 11, 16, ...; fitted as long as there are
        twenty points per box, and from 8 on where that leaves five sizes.

    Returns
    -------
    xarray.Dataset
        ``box_dimension`` with its ``standard_error``; over ``boxes_per_side`` the number of
        ``boxes`` with a point, the ``fit``, and ``fitted``, true where the line is fitted.
        Attribute ``n_points``.

    Raises
    ------
    OptionError
        For what holds no points, or too few of them.

    See Also
    --------
    correlation_dimension : weighs places by how often they are visited; needs fewer points.

    Notes
    -----
    Each coordinate is divided by its extent first, which changes no dimension; coordinates that
    are constant are left out. Of a set in n dimensions about :math:`20 \varepsilon^{-D}` points
    are needed: ten thousand are few, a million are better. Places that are hardly ever visited
    are missed, so the result comes from below. The standard error joins the scatter about the
    line, half the difference between the lines through the coarser and the finer half of the
    boxes, and the difference between all points and the first half of them.

    References
    ----------
    J. D. Farmer, E. Ott and J. A. Yorke, The dimension of chaotic attractors, Physica D 7,
    153-180 (1983).

    Examples
    --------
    A motion with two frequencies that have no common measure is a curve on a section.

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> angle = np.arange(20_000) * (np.sqrt(5) - 1) * np.pi
    >>> found = ns.box_dimension(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    >>> round(float(found["box_dimension"]), 1)
    1.0
    """
    values, attrs = points_of(points, attractor, states)
    given = _check_boxes(boxes)
    if len(values) < 2 * _PER_BOX:
        raise OptionError(
            f"{len(values)} points are too few for a dimension, which needs thousands; that of a"
            " periodic motion on a section is 0"
        )
    unit = scaled(values)
    sides = given or _sides(unit)
    counts = np.array([_count(unit, side) for side in sides], float)
    used = _used(sides, counts, len(unit)) if given is None else np.ones(len(sides), bool)
    sizes = np.array(sides, float)
    law = fit_power_law(sizes[used], counts[used])
    half = unit[: len(unit) // 2]
    fewer = [_count(half, side) for side, fit in zip(sides, used, strict=True) if fit]
    missed = law.exponent - fit_power_law(sizes[used], np.array(fewer, float)).exponent
    error = float(np.sqrt(law.scatter**2 + law.bend**2 + missed**2))
    return _dataset(sizes, counts, used, law, error, attrs | {"n_points": len(values)})


def _sides(unit: Points) -> list[int]:
    """Boxes per side, root two apart, until there are few points per box."""
    most = min(_LARGEST, 2 ** (_BITS // max(1, unit.shape[1])))
    sides: list[int] = []
    side = 2.0
    while round(side) <= most:
        sides.append(round(side))
        if 4 * _count(unit, sides[-1]) > len(unit):
            break
        side *= np.sqrt(2.0)
    return sides


def _count(unit: Points, side: int) -> int:
    """Boxes with a point in them."""
    number = np.zeros(len(unit), np.int64)
    for along in unit.T:
        # the last point of all belongs to the last box
        number = number * side + np.minimum((along * side).astype(np.int64), side - 1)
    return int(np.unique(number).size)


def _used(sides: list[int], counts: Floats, n_points: int) -> npt.NDArray[np.bool_]:
    dense = counts * _PER_BOX <= n_points
    fine = dense & (np.array(sides) >= _COARSE)
    used = fine if np.count_nonzero(fine) >= _ENOUGH else dense
    if np.count_nonzero(used) < _FEWEST:
        raise OptionError(
            f"{n_points} points are too few for a dimension: already {sides[_FEWEST - 1]} boxes"
            f" per side leave fewer than {_PER_BOX} points per box; take more points, or fewer"
            " coordinates by states="
        )
    return used


def _check_boxes(boxes: Any) -> list[int] | None:
    if boxes is None:
        return None
    try:
        sides = sorted({whole_number("boxes", float(side)) for side in boxes})
    except (TypeError, ValueError, OverflowError):
        raise OptionError(
            f"boxes = {quote(boxes)}: give whole numbers of boxes per side, such as (8, 16, 32)"
        ) from None
    if len(sides) < _FEWEST or sides[-1] > _LARGEST:
        raise OptionError(
            f"boxes = {quote(boxes)}: give three or more different numbers, none above {_LARGEST}"
        )
    return sides


def _dataset(
    sizes: Floats,
    counts: Floats,
    used: npt.NDArray[np.bool_],
    law: PowerLaw,
    error: float,
    attrs: dict[str, Any],
) -> xr.Dataset:
    side = "boxes_per_side"
    return xr.Dataset(
        {
            "box_dimension": ((), law.exponent, {"long_name": "box-counting dimension"}),
            "standard_error": ((), error, {"long_name": "standard error of the dimension"}),
            "boxes": (side, counts.astype(int), {"long_name": "boxes with a point"}),
            "fit": (side, law.at(sizes), {"long_name": "fitted power law"}),
            "fitted": (side, used, {"long_name": "whether the line is fitted to it"}),
        },
        {side: (side, sizes.astype(int), {"long_name": "boxes per side"})},
        attrs,
    )
