"""`reversals`: where a record turns, which is all that cycle counting needs of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.fatigue.checks import Array
from nonsmooth.fatigue.record_checks import record_values

__all__ = ["refined", "reversals", "turning_places"]


def reversals(values: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Places at which a record turns, its two ends included.

    Of equal samples in a row the last one counts, as ASTM E1049 leaves open and as `rainflow`
    does.

    Parameters
    ----------
    values : array_like
        Samples.

    Returns
    -------
    numpy.ndarray
        Indices, increasing.

    Examples
    --------
    >>> from nonsmooth.fatigue import reversals
    >>> reversals([0.0, 1.0, 2.0, 2.0, 1.0, 3.0]).tolist()
    [0, 3, 4, 5]
    """
    return turning_places(record_values("values", values))


def turning_places(found: Array) -> npt.NDArray[np.intp]:
    """The same of checked samples."""
    last = np.flatnonzero(np.append(found[1:] != found[:-1], True))
    rising = np.diff(found[last]) > 0.0
    inner = last[1:-1][rising[1:] != rising[:-1]] if last.size > 2 else last[:0]
    return np.concatenate([[0], inner, [found.size - 1]]).astype(np.intp)


def refined(found: Array) -> Array:
    """Samples whose reversals have the values of parabolas through the nearest three samples."""
    inner = turning_places(found)[1:-1]
    before, at, after = found[inner - 1], found[inner], found[inner + 1]
    bend = before - 2.0 * at + after  # not zero where a record turns
    values = found.copy()
    values[inner] = at - (after - before) ** 2 / (8.0 * bend)
    return values
