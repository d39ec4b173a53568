"""`correlation_dimension`: how many pairs of points are close, over the distance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.point_sets import Points, points_of, scaled
from nonsmooth.analysis.statistics.power_law import PowerLaw, fit_power_law, leave_one_out_error
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number

__all__ = ["correlation_dimension"]

_LEAST = 200  # points
_MOST = 20_000  # points; pairs grow with their square
_BLOCKS = 8  # pieces of the motion for the error
_PAIRS = 1_000  # closer than the smallest distance that is fitted
_LONGEST = 3  # 2**-3 of the extent is the longest distance that is fitted
_RADII = 2.0 ** -np.arange(0.0, 20.5, 0.5)[::-1]  # distances, in extents
_FEWEST = 3  # distances through which a line is fitted

Floats = npt.NDArray[np.float64]


def correlation_dimension(
    points: xr.Dataset | xr.DataArray | npt.ArrayLike,
    *,
    attractor: int | None = None,
    states: Sequence[str] | None = None,
    window: int = 1,
) -> xr.Dataset:
    r"""Correlation dimension of a set of points, such as a chaotic attractor on a section.

    The correlation sum, the share of all pairs of points that are closer than
    :math:`\varepsilon`, goes as :math:`\varepsilon^{D_2}`.

    Parameters
    ----------
    points : xarray.Dataset, xarray.DataArray, array_like
        Result of `attractors`, of `stroboscopic_map` or `poincare_section`, or an array with one
        row per point, in the order of time.

    Other Parameters
    ----------------
    attractor : int, optional
        Number of an attractor, where the dataset has several.
    states : sequence of str, optional
        Coordinates that are taken from a dataset; by default all states that do not drift.
    window : int, optional
        Pairs closer in time than so many points do not count. One is right for a section; samples
        of a curve need as many as lie within its correlation time.

    Returns
    -------
    xarray.Dataset
        ``correlation_dimension`` with its ``standard_error``; over ``distance`` the
        ``correlation_sum``, the ``fit``, and ``fitted``, true where the line is fitted. Attribute
        ``n_points``.

    Raises
    ------
    OptionError
        For what holds no points, or fewer than 200.

    See Also
    --------
    box_dimension : counts places, however often they are visited.

    Notes
    -----
    Each coordinate is divided by its extent first; distances are Euclidean after that. Of more
    than 20000 points so many are taken, evenly spread over the motion. The line is fitted to
    distances up to an eighth of the extent within which there are a thousand pairs. The standard
    error joins the jackknife over eight pieces of the motion, the scatter about the line, and half
    the difference between the lines through the shorter and the longer half of the distances.
    Several thousand points give two digits up to a dimension of about three.

    References
    ----------
    P. Grassberger and I. Procaccia, Measuring the strangeness of strange attractors, Physica D 9,
    189-208 (1983). J. Theiler, Spurious dimension from correlation algorithms applied to limited
    time-series data, Physical Review A 34, 2427-2432 (1986): ``window``.

    Examples
    --------
    Points of a circle:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> angle = 2 * np.pi * np.random.default_rng(0).random(3000)
    >>> found = ns.correlation_dimension(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    >>> round(float(found["correlation_dimension"]), 1)
    1.0
    """
    values, attrs = points_of(points, attractor, states)
    if len(values) < _LEAST:
        raise OptionError(
            f"{len(values)} points are too few for a dimension, which needs {_LEAST} at least,"
            " better thousands"
        )
    apart = whole_number("window", window)
    step = -(-len(values) // _MOST)
    apart = -(-apart // step)
    unit = scaled(values)[::step]
    if apart >= len(unit) // 2:
        raise OptionError(f"window = {window} leaves no pairs of {len(values)} points")
    pairs, total = _pairs(unit, apart)
    counts = pairs.sum(axis=(0, 1))
    used = (counts >= 2 * _PAIRS) & (_RADII <= 2.0**-_LONGEST)
    if np.count_nonzero(used) < _FEWEST:
        raise OptionError(
            f"{len(values)} points have too few pairs that are close; take more points"
        )
    law = fit_power_law(_RADII[used], counts[used] / total)
    without = [
        counts - pairs[b].sum(axis=0) - pairs[:, b].sum(axis=0) + pairs[b, b]
        for b in range(_BLOCKS)
    ]
    estimates = [fit_power_law(_RADII[used], each[used].astype(float)).exponent for each in without]
    jackknife = leave_one_out_error(np.array(estimates))
    error = float(np.sqrt(jackknife**2 + law.scatter**2 + law.bend**2))
    attrs |= {"n_points": len(unit), "window": apart * step}
    return _dataset(counts / total, used, law, error, attrs)


def _pairs(unit: Points, window: int) -> tuple[npt.NDArray[np.int64], float]:
    """Ordered pairs within each distance between pieces of the motion, and pairs in all."""
    from scipy.spatial import cKDTree

    if unit.shape[1] == 0:  # one point only, visited again and again
        unit = np.zeros((len(unit), 1))
    block = np.arange(len(unit)) * _BLOCKS // len(unit)
    trees = [cKDTree(unit[block == b]) for b in range(_BLOCKS)]
    pairs = np.empty((_BLOCKS, _BLOCKS, _RADII.size), np.int64)
    for b in range(_BLOCKS):
        for c in range(b, _BLOCKS):
            pairs[b, c] = pairs[c, b] = trees[b].count_neighbors(trees[c], _RADII)
        pairs[b, b] -= trees[b].n  # each point with itself
    for lag in range(1, window):
        distance = np.sqrt(((unit[lag:] - unit[:-lag]) ** 2).sum(axis=1))
        within = (distance[:, None] <= _RADII).astype(np.int64)
        np.subtract.at(pairs, (block[lag:], block[:-lag]), within)
        np.subtract.at(pairs, (block[:-lag], block[lag:]), within)
    return pairs, float((len(unit) - window + 1) * (len(unit) - window))


def _dataset(
    sums: Floats,
    used: npt.NDArray[np.bool_],
    law: PowerLaw,
    error: float,
    attrs: dict[str, Any],
) -> xr.Dataset:
    return xr.Dataset(
        {
            "correlation_dimension": (
                (), law.exponent, {"long_name": "correlation dimension"},
            ),
            "standard_error": ((), error, {"long_name": "standard error of the dimension"}),
            "correlation_sum": ("distance", sums, {"long_name": "correlation sum"}),
            "fit": ("distance", law.at(_RADII), {"long_name": "fitted power law"}),
            "fitted": ("distance", used, {"long_name": "whether the line is fitted to it"}),
        },
        {"distance": ("distance", _RADII.copy(), {"long_name": "distance in extents"})},
        attrs,
    )  # fmt: skip
