"""`basin_entropy`: how uncertain the outcome is within boxes of starts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.outcomes import LEFT_OUT, Outcomes, blocks_of, outcomes_of
from nonsmooth.analysis.statistics.power_law import leave_one_out_error
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number

__all__ = ["basin_entropy"]

_ERRORS = 2.0  # standard errors above log 2 at which the boundary counts as fractal
_ROUNDING = 1e-9  # two outcomes of equal shares in every box have log 2, and errors of zero
_BLOCK_BOXES = 2  # per side of a block for the error, at least

Floats = npt.NDArray[np.float64]


class Boxes(NamedTuple):
    """Boxes of which enough cells count: their entropy, whether outcomes mix, their block."""

    entropy: Floats
    mixed: npt.NDArray[np.bool_]
    block: npt.NDArray[np.int64]


def basin_entropy(
    basins: xr.Dataset | xr.DataArray | npt.ArrayLike,
    box: int = 5,
    *,
    leave_out: Iterable[int] = LEFT_OUT,
) -> xr.Dataset:
    r"""Basin entropy and boundary basin entropy.

    The grid is cut into boxes. With the shares :math:`p_k` of the outcomes in a box its entropy
    is :math:`-\sum_k p_k \log p_k`. The basin entropy is its mean over all boxes: 0 for one
    outcome, log N for N outcomes mixed at random. The boundary basin entropy is the mean over
    the boxes with more than one outcome; above log 2 the boundary is fractal.

    Parameters
    ----------
    basins : xarray.Dataset, xarray.DataArray, array_like of int
        Result of `basins_of_attraction`, its ``label``, or any array of labels in one or more
        dimensions.
    box : int, optional
        Cells along each side of a box, two at least.

    Other Parameters
    ----------------
    leave_out : iterable of int, optional
        Labels that are no outcome: by default starts that are unsettled (0), inadmissible (-2) or
        not computed (-3). Those that ended early (-1) count as one outcome.

    Returns
    -------
    xarray.Dataset
        ``basin_entropy`` and ``boundary_basin_entropy`` with ``basin_entropy_error`` and
        ``boundary_basin_entropy_error``, ``n_boxes`` and ``n_boundary_boxes``,
        ``n_outcomes``, and ``fractal``: true when the boundary basin entropy exceeds log 2 by two
        standard errors. False says nothing: there are fractal boundaries below log 2.

    Raises
    ------
    OptionError
        For what is no array of labels, or boxes that do not fit into it.

    See Also
    --------
    uncertainty_exponent : the same over many scales.

    Notes
    -----
    Boxes stand side by side from the first cell on; cells left over at the far sides are dropped.
    Of a box with cells that are left out the others count, if they are half of the box or more.
    Without a boundary the boundary basin entropy is nan. The entropy of few cells is too small:
    for outcomes at random by (N - 1)/(2 n) in boxes of n cells. Errors are from a jackknife over
    blocks of neighbouring boxes, at most eight per side.

    The test with log 2 rests on a boundary between two basins that is smooth within nearly all
    boxes, where no box can hold more than log 2. Where three smooth basins meet in many boxes, on
    a coarse grid, it misleads.

    References
    ----------
    A. Daza, A. Wagemakers, B. Georgeot, D. Guery-Odelin and M. A. F. Sanjuan, Basin entropy: a
    new tool to analyze uncertainty in dynamical systems, Scientific Reports 6, 31416 (2016).

    Examples
    --------
    Cells of a chessboard, in boxes of four:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> chessboard = 1 + np.indices((8, 8)).sum(axis=0) % 2
    >>> entropy = ns.basin_entropy(chessboard, box=2)
    >>> float(entropy["basin_entropy"] / np.log(2))
    1.0
    """
    outcomes = outcomes_of(basins, leave_out)
    side = whole_number("box", box)
    shape = outcomes.labels.shape
    if side < 2 or side > min(shape):
        raise OptionError(
            f"box = {side}: give 2 cells or more, and not more than the shortest side of"
            f" {min(shape)} cells"
        )
    boxes = _boxes(outcomes, side)
    total, boundary = boxes.entropy.size, int(np.count_nonzero(boxes.mixed))
    sums = np.bincount(boxes.block, boxes.entropy)
    mean, mean_error = _ratio(sums, np.bincount(boxes.block))
    at_boundary, boundary_error = _ratio(sums, np.bincount(boxes.block, boxes.mixed))
    fractal = bool(at_boundary - _ERRORS * boundary_error > np.log(2.0) + _ROUNDING)
    text = "basin entropy"
    variables = {
        "basin_entropy": (mean, text),
        "basin_entropy_error": (mean_error, f"standard error of the {text}"),
        "boundary_basin_entropy": (at_boundary, f"boundary {text}"),
        "boundary_basin_entropy_error": (boundary_error, f"standard error of the boundary {text}"),
        "n_boxes": (total, "boxes that count"),
        "n_boundary_boxes": (boundary, "boxes with more than one outcome"),
        "n_outcomes": (outcomes.numbers.size, "outcomes"),
        "fractal": (fractal, "whether the boundary basin entropy exceeds log 2"),
    }
    return xr.Dataset(
        {name: ((), value, {"long_name": label}) for name, (value, label) in variables.items()},
        attrs=outcomes.attrs | {"box": side},
    )


def _boxes(outcomes: Outcomes, side: int) -> Boxes:
    """Entropy of each box of which half the cells or more count."""
    shape = tuple(size // side for size in outcomes.labels.shape)
    kept = tuple(slice(count * side) for count in shape)
    labels, counts = outcomes.labels[kept], outcomes.counts[kept]
    cells = _sums(counts, shape, side)
    entropy, kinds = np.zeros(shape), np.zeros(shape, int)
    for number in outcomes.numbers:
        share = _sums((labels == number) & counts, shape, side) / np.maximum(cells, 1)
        present = share > 0.0
        kinds += present
        entropy[present] -= share[present] * np.log(share[present])
    enough = 2 * cells >= side ** len(shape)
    if not enough.any():
        raise OptionError(
            f"no box of {side} cells a side has half of its cells with an outcome; take a smaller"
            " box="
        )
    coarse = tuple(max(1, count // _BLOCK_BOXES) for count in shape)
    block, _ = blocks_of(coarse)
    nearest = np.ix_(
        *(
            np.minimum(np.arange(n) // _BLOCK_BOXES, m - 1)
            for n, m in zip(shape, coarse, strict=True)
        )
    )
    return Boxes(entropy[enough], kinds[enough] > 1, block[nearest][enough])


def _sums(
    values: npt.NDArray[np.bool_], shape: tuple[int, ...], side: int
) -> npt.NDArray[np.int64]:
    """Cells that are true in each box."""
    split = values.reshape([length for count in shape for length in (count, side)])
    total: npt.NDArray[np.int64] = split.sum(axis=tuple(range(1, 2 * len(shape), 2)))
    return total


def _ratio(numerators: npt.NDArray[Any], denominators: npt.NDArray[Any]) -> tuple[float, float]:
    """Ratio of two sums over blocks, with its jackknife error; nan where there is nothing."""
    whole, parts = numerators.sum(), denominators.sum()
    if parts == 0.0:
        return float("nan"), float("nan")
    used = denominators > 0.0
    rest = parts - denominators[used]
    with np.errstate(invalid="ignore", divide="ignore"):  # of a single block
        estimates = (whole - numerators[used]) / rest
    return float(whole / parts), leave_one_out_error(estimates)
