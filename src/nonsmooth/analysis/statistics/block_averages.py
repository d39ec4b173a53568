"""Standard errors of time averages, from blocks that are long enough to be independent."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["BlockAverages", "block_averages", "means_differ"]

_BLOCKS = 32  # of fewer the error itself is not known to an eighth
_ERRORS = 5.0  # standard errors between two halves of a record
_ALIKE = 4.0  # times that of the second half: an error of the first one, of one motion


class BlockAverages(NamedTuple):
    """Standard errors of the means of some series, and how they were found."""

    standard_error: npt.NDArray[np.float64]  # (k,)
    length: int  # values per block
    n_blocks: int
    independent: bool  # whether neighbouring blocks are not seen to be correlated


def block_averages(values: npt.NDArray[np.float64]) -> BlockAverages:
    """Standard errors of the means of the columns of ``values`` (N, k).

    The series is cut into 32 blocks, or a few more, so that they are as long as they can be:
    correlations of chaotic motion have long tails, which shorter blocks miss although their
    neighbours do not seem to be correlated. They count as independent where the correlation of
    neighbours is below two over the root of their number in every column.

    Where blocks happen to hold whole cycles of a motion they are alike, and tell nothing of the
    cycle that the record cuts off at its ends. So the error is no smaller than what the sum of the
    values wanders within a block, over their number.
    """
    length = max(1, len(values) // _BLOCKS)
    count = len(values) // length
    if count < 2:
        return BlockAverages(np.full(values.shape[1], np.nan), length, count, False)
    latest = values[len(values) - count * length :]  # the remainder is left out at the start
    blocks = latest.reshape(count, length, values.shape[1]).mean(axis=1)
    error = blocks.std(axis=0, ddof=1) / np.sqrt(count)
    away = latest.reshape(count, length, values.shape[1]) - blocks[:, None]
    sums = np.cumsum(away, axis=1)  # which end at zero
    error = np.maximum(error, np.ptp(sums, axis=1).max(axis=0) / len(latest))
    # neighbours that balance each other only make the error too large
    independent = count >= _BLOCKS and bool(np.all(_neighbours(blocks) < 2.0 / np.sqrt(count)))
    return BlockAverages(error, length, count, independent)


def means_differ(first: tuple[float, float], second: tuple[float, float], least: float) -> bool:
    """Whether two halves of a record, each a mean with its error, differ: it had not settled.

    Where chaos ends in the first half its error is large, which must not hide a calm second one.
    ``least``: a smaller difference is none.
    """
    (mean, error), (later, other) = first, second
    if mean == later == -np.inf:
        return False
    spread = float(np.hypot(min(error, _ALIKE * other), other))
    return abs(mean - later) > max(_ERRORS * spread, least)


def _neighbours(blocks: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Correlation of neighbouring blocks, zero where they differ by rounding only."""
    away = blocks - blocks.mean(axis=0)
    power = (away * away).sum(axis=0)
    rounding = len(blocks) * (1e-13 * np.abs(blocks).max(axis=0)) ** 2
    product = (away[1:] * away[:-1]).sum(axis=0)
    return np.where(power > rounding, product / np.maximum(power, 1e-300), 0.0)
