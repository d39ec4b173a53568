"""`uncertainty_exponent`: how much a better known start helps to foretell its outcome."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.outcomes import LEFT_OUT, Outcomes, blocks_of, outcomes_of
from nonsmooth.analysis.statistics.power_law import PowerLaw, fit_power_law, leave_one_out_error
from nonsmooth.errors import OptionError, ResultWarning, quote
from nonsmooth.runs.options import whole_number

__all__ = ["uncertainty_exponent"]

_SMALLEST = 16  # cells per side
_PART = 8  # of the shortest side is the longest distance
_MIXED = 0.5  # of the fraction for labels without any order; above, it saturates
_ERRORS = 2.0  # standard errors within which a boundary counts as smooth

_FEWEST = 3  # distances through which a line is fitted
_ENOUGH = 5  # distances; of fewer the message tells

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


class UncertainFraction(NamedTuple):
    """Fraction of uncertain cells over the distance, and where the line is fitted."""

    sizes: Floats
    fraction: Floats
    used: Mask


def uncertainty_exponent(
    basins: xr.Dataset | xr.DataArray | npt.ArrayLike,
    *,
    distances: Sequence[int] | None = None,
    between: tuple[int, int] | None = None,
    leave_out: Iterable[int] = LEFT_OUT,
) -> xr.Dataset:
    r"""Uncertainty exponent of basins, and the dimension of the boundary between them.

    A start known to a distance :math:`\varepsilon` is uncertain when a start that far away has
    another outcome. The fraction of uncertain starts goes as :math:`\varepsilon^\alpha`; the
    boundary has the dimension :math:`D - \alpha` in a region of dimension D. Where
    :math:`\alpha` is small, a start must be known very much better for a somewhat surer
    outcome.

    Parameters
    ----------
    basins : xarray.Dataset, xarray.DataArray, array_like of int
        Result of `basins_of_attraction`, its ``label``, or any array of labels in one or more
        dimensions. Of truth values, false is outcome 1 and true outcome 2.

    Other Parameters
    ----------------
    distances : sequence of int, optional
        Distances in cells, three at least, to all of which the line is fitted. By default 1, 2,
        3, 4, 6, 8, 12, ... up to an eighth of the shortest side, fitted as long as the fraction is
        at most half of what labels strewn at random would give.
    between : tuple of int, optional
        Two labels: only the boundary between these is looked at.
    leave_out : iterable of int, optional
        Labels that are no outcome: by default starts that are unsettled (0), inadmissible (-2) or
        not computed (-3). Those that ended early (-1) count as one outcome.

    Returns
    -------
    xarray.Dataset
        ``uncertainty_exponent``, its ``standard_error``, ``boundary_dimension``; over ``distance``
        the ``uncertain_fraction``, the ``fit``, and ``fitted``, which is true where the line is
        fitted. Attributes: ``message`` says when the boundary looks smooth or there is none, when
        the exponent is not determined, or the grid is coarse, ``n_cells`` how many cells count.

    Raises
    ------
    OptionError
        For what is no array of labels, fewer than 16 cells on a side, or distances that do not
        fit.

    Warns
    -----
    ResultWarning
        When no cell has one of the labels of ``between``.

    See Also
    --------
    basin_entropy : uncertainty at one scale.

    Notes
    -----
    All cells of the grid are looked at, not some at random: a cell is uncertain when its label
    differs from that of any cell at exactly that distance, up or down along each axis. Cells that
    are left out are neither counted nor compared with, and outside the grid there is nothing.
    The line is fitted to the logarithms, all distances with the same weight. The standard error
    joins three parts: the jackknife over blocks of cells, eight per side, as all distances share
    the same cells; the scatter about the line; and half the difference between the lines through
    the shorter and the longer half of the distances, as some boundaries repeat themselves at
    certain scales only. Look at `nonsmooth.plot.uncertainty` too.

    References
    ----------
    C. Grebogi, S. W. McDonald, E. Ott and J. A. Yorke, Final state sensitivity: an obstruction to
    predictability, Physics Letters A 99, 415-418 (1983).

    Examples
    --------
    A smooth boundary: twice as well known, half as many starts are uncertain.

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> halves = np.ones((100, 100), int)
    >>> halves[:, 50:] = 2
    >>> found = ns.uncertainty_exponent(halves)
    >>> round(float(found["uncertainty_exponent"]), 6), found.attrs["message"]
    (1.0, 'the boundary looks smooth: the exponent is 1 within two standard errors')
    """
    outcomes = outcomes_of(basins, leave_out)
    steps = _check_distances(distances, outcomes.labels.shape)
    pair = _check_pair(between)
    absent = [] if pair is None else [k for k in pair if k not in outcomes.numbers]
    if absent:
        warnings.warn(
            f"between = {pair}: no cell that counts has the label {absent[0]}, so there is no such"
            f" boundary; labels are {', '.join(map(str, outcomes.numbers))}",
            ResultWarning,
            stacklevel=2,
        )
    block, count = blocks_of(outcomes.labels.shape)
    sums = np.empty((len(steps), count))
    for k, step in enumerate(steps):
        sums[k] = np.bincount(block[_uncertain(outcomes, step, pair)], minlength=count)
    cells = np.bincount(block[outcomes.counts], minlength=count).astype(float)
    sizes = np.array(steps, float)
    fraction = sums.sum(axis=1) / cells.sum()
    used = fraction <= (_MIXED * _fraction_of_mixed(outcomes, pair) if distances is None else 1.0)
    saturated = np.count_nonzero(used) < _FEWEST
    used[:_FEWEST] |= saturated
    law = fit_power_law(sizes[used], fraction[used])
    jackknife = _jackknife(sizes[used], sums[used], cells)
    error = float(np.sqrt(jackknife**2 + law.scatter**2 + law.bend**2))
    attrs = outcomes.attrs | {
        "n_cells": int(cells.sum()),
        "between": "" if pair is None else f"{pair[0]} {pair[1]}",
        "message": _message(law, error, fraction, bool(saturated))
        + _coarse(int(np.count_nonzero(used & (fraction > 0.0))), saturated, distances),
    }
    return _dataset(
        UncertainFraction(sizes, fraction, used), law, error, outcomes.labels.ndim, attrs
    )


def _uncertain(outcomes: Outcomes, step: int, pair: tuple[int, int] | None) -> Mask:
    """Cells that count and have another outcome at this distance along some axis."""
    labels, counts = outcomes.labels, outcomes.counts
    if pair is not None:
        counts = counts & np.isin(labels, pair)
    found = np.zeros(labels.shape, bool)
    for axis in range(labels.ndim):
        low = tuple(slice(None, -step) if k == axis else slice(None) for k in range(labels.ndim))
        high = tuple(slice(step, None) if k == axis else slice(None) for k in range(labels.ndim))
        differ = (labels[low] != labels[high]) & counts[low] & counts[high]
        found[low] |= differ
        found[high] |= differ
    return found


def _fraction_of_mixed(outcomes: Outcomes, pair: tuple[int, int] | None) -> float:
    """Fraction of uncertain cells if the same labels were strewn over the grid at random."""
    labels = outcomes.labels[outcomes.counts]
    _, counts = np.unique(labels, return_counts=True)
    neighbours = 2 * outcomes.labels.ndim
    share = counts / labels.size
    if pair is None:
        return float(share @ (1.0 - share**neighbours))
    first, second = (np.count_nonzero(labels == label) / labels.size for label in pair)
    one = first * (1.0 - (1.0 - second) ** neighbours)
    return float(one + second * (1.0 - (1.0 - first) ** neighbours))


def _jackknife(sizes: Floats, sums: Floats, cells: Floats) -> float:
    """Error of the exponent from leaving out one block of cells after the other."""
    used = np.flatnonzero(cells)
    if used.size < 2:
        return float("nan")
    total, all_cells = sums.sum(axis=1), cells.sum()
    laws = [
        fit_power_law(sizes, (total - sums[:, b]) / max(all_cells - cells[b], 1.0)) for b in used
    ]
    return leave_one_out_error(np.array([law.exponent for law in laws]))


def _message(law: PowerLaw, error: float, fraction: Floats, saturated: bool) -> str:
    if not fraction.any():
        return "no cell is uncertain: there is one outcome only, or no boundary that was looked at"
    if not np.isfinite(law.exponent):
        return "cells are uncertain at one distance only, so there is no exponent; refine the grid"
    if saturated:
        return (
            "the basins are mixed at nearly every distance, so the exponent is that of the three"
            " shortest ones and too small; refine the grid"
        )
    if abs(law.exponent - 1.0) <= max(_ERRORS * error, 1e-9):
        if law.exponent <= _ERRORS * error:
            return (
                "the exponent is not determined: 0 and 1 are both within two standard errors;"
                " refine the grid, along its shortest side first"
            )
        return "the boundary looks smooth: the exponent is 1 within two standard errors"
    return "fitted"


def _coarse(n_fitted: int, saturated: Any, distances: Any) -> str:
    """Warn of a line through few distances, unless they were chosen or the message says why."""
    if saturated or distances is not None or not 1 < n_fitted < _ENOUGH:
        return ""
    return f"; the grid is coarse, the line is fitted to {n_fitted} distances only; refine the grid"


def _dataset(
    curve: UncertainFraction, law: PowerLaw, error: float, ndim: int, attrs: dict[str, Any]
) -> xr.Dataset:
    return xr.Dataset(
        {
            "uncertainty_exponent": ((), law.exponent, {"long_name": "uncertainty exponent"}),
            "standard_error": (
                (), error, {"long_name": "standard error of the uncertainty exponent"},
            ),
            "boundary_dimension": (
                (), ndim - law.exponent, {"long_name": "dimension of the boundary"},
            ),
            "uncertain_fraction": (
                "distance", curve.fraction, {"long_name": "fraction of uncertain starts"},
            ),
            "fit": ("distance", law.at(curve.sizes), {"long_name": "fitted power law"}),
            "fitted": ("distance", curve.used, {"long_name": "whether the line is fitted to it"}),
        },
        {"distance": ("distance", curve.sizes, {"long_name": "distance in cells"})},
        attrs,
    )  # fmt: skip


def _check_distances(distances: Any, shape: tuple[int, ...]) -> list[int]:
    side = min(shape)
    if side < _SMALLEST:
        raise OptionError(
            f"the shortest side of the grid has {side} cells, and {_SMALLEST} are needed at least,"
            " better some hundreds; compute the basins on a finer grid"
        )
    if distances is None:
        longest = max(4, side // _PART)
        doubled = [2**k for k in range(longest.bit_length())]
        return sorted({d for s in doubled for d in (s, s + s // 2) if d <= longest})
    try:
        steps = sorted({whole_number("distances", float(d)) for d in distances})
    except (TypeError, ValueError, OverflowError):
        raise OptionError(
            f"distances = {quote(distances)}: give whole numbers of cells, such as (1, 2, 4, 8)"
        ) from None
    if len(steps) < _FEWEST or steps[-1] >= side:
        raise OptionError(
            f"distances = {quote(distances)}: give three or more different ones, below the shortest"
            f" side of {side} cells"
        )
    return steps


def _check_pair(between: Any) -> tuple[int, int] | None:
    if between is None:
        return None
    try:
        first, second = (int(label) for label in between)
    except (TypeError, ValueError, OverflowError):
        first = second = 0
    if first == second:
        raise OptionError(f"between = {quote(between)}: give two different labels, such as (1, 2)")
    return first, second
