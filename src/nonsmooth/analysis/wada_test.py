"""`wada_test`: whether every boundary point touches every basin."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.outcomes import LEFT_OUT, Outcomes, outcomes_of
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number

__all__ = ["wada_test"]

_FEWEST = 3  # basins; two always share their boundary

Mask = npt.NDArray[np.bool_]


def wada_test(
    basins: xr.Dataset | xr.DataArray | npt.ArrayLike,
    fatten: int = 5,
    *,
    leave_out: Iterable[int] = LEFT_OUT,
) -> xr.Dataset:
    """Wada property of three or more basins by merging: whether all share one boundary.

    For each basin all others are merged into one, which leaves one boundary. The basins have the
    Wada property when all these boundaries are the same. On a grid they are when each lies within
    a few cells of every other.

    Parameters
    ----------
    basins : xarray.Dataset, xarray.DataArray, array_like of int
        Result of `basins_of_attraction`, its ``label``, or any array of labels in one or more
        dimensions.
    fatten : int, optional
        Cells by which boundaries are made thicker for the comparison.

    Other Parameters
    ----------------
    leave_out : iterable of int, optional
        Labels that are no outcome: by default starts that are unsettled (0), inadmissible (-2) or
        not computed (-3). Those that ended early (-1) count as one outcome.

    Returns
    -------
    xarray.Dataset
        Over ``label`` and ``other``: ``distance``, in cells, of that point of the boundary of
        ``label`` which lies farthest from the boundary of ``other``, diagonal steps counted as
        one; and ``fraction_within``, how much of it lies within ``fatten`` cells. ``wada`` is true
        when no distance exceeds ``fatten``, ``largest_distance`` is the largest of them.

    Raises
    ------
    OptionError
        For what is no array of labels, fewer than three basins, or one without a boundary.

    See Also
    --------
    basin_entropy : whether a boundary is fractal.

    Notes
    -----
    True means: at this resolution. Confirm it on a finer grid, or on a part of the region: the
    largest distance in cells must not grow. A basin of a few cells far from the others' boundary
    makes it false; ``fraction_within`` tells how much of the boundary is shared. Cells that are
    left out have no boundary.

    References
    ----------
    A. Daza, A. Wagemakers and M. A. F. Sanjuan, Ascertaining when a basin is Wada: the merging
    method, Scientific Reports 8, 9954 (2018).

    Examples
    --------
    Three stripes, of which the outer ones do not touch:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> stripes = np.repeat([1, 2, 3], 20) * np.ones((30, 1), int)
    >>> found = ns.wada_test(stripes)
    >>> bool(found["wada"]), float(found["largest_distance"])
    (False, 20.0)
    """
    outcomes = outcomes_of(basins, leave_out)
    thick = whole_number("fatten", fatten)
    numbers = outcomes.numbers
    if numbers.size < _FEWEST:
        raise OptionError(
            f"the Wada property is one of three basins or more, and there are {numbers.size} here"
        )
    boundaries = [_boundary(outcomes, int(number)) for number in numbers]
    for number, boundary in zip(numbers, boundaries, strict=True):
        if not boundary.any():
            raise OptionError(
                f"the basin with label {number} has no boundary with another; leave it out by"
                " leave_out="
            )
    distance, within = _distances(boundaries, thick)
    dims = ("label", "other")
    return xr.Dataset(
        {
            "distance": (dims, distance, {"long_name": "largest distance to the other boundary"}),
            "fraction_within": (
                dims,
                within,
                {"long_name": f"fraction within {thick} cells of the other boundary"},
            ),
            "largest_distance": ((), float(distance.max()), {"long_name": "largest distance"}),
            "wada": ((), bool(distance.max() <= thick), {"long_name": "whether they are Wada"}),
        },
        {
            "label": ("label", numbers, {"long_name": "label"}),
            "other": ("other", numbers, {"long_name": "label of the other"}),
        },
        outcomes.attrs | {"fatten": thick},
    )


def _boundary(outcomes: Outcomes, number: int) -> Mask:
    """Cells beside the boundary of one basin with all others merged, on both of its sides."""
    inside, counts = outcomes.labels == number, outcomes.counts
    found = np.zeros(inside.shape, bool)
    for axis in range(inside.ndim):
        low = tuple(slice(None, -1) if k == axis else slice(None) for k in range(inside.ndim))
        high = tuple(slice(1, None) if k == axis else slice(None) for k in range(inside.ndim))
        differ = (inside[low] != inside[high]) & counts[low] & counts[high]
        found[low] |= differ
        found[high] |= differ
    return found


def _distances(
    boundaries: list[Mask], thick: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    from scipy.ndimage import distance_transform_cdt

    count = len(boundaries)
    distance, within = np.zeros((count, count)), np.ones((count, count))
    for k, other in enumerate(boundaries):
        away = distance_transform_cdt(~other, metric="chessboard")
        for i, boundary in enumerate(boundaries):
            here = away[boundary]
            distance[i, k], within[i, k] = here.max(), (here <= thick).mean()
    return distance, within
