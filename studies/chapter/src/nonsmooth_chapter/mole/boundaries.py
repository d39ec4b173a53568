"""How fractal the boundaries between basins of the mole are.

By the grid of a window round a periodic point (`nonsmooth.uncertainty_exponent`), and over the
whole section by pairs of starts that lie a small distance apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import attractors, basins_of_attraction, uncertainty_exponent
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.mole.basins import SECTION, WINDOW, oscillator, section_basins

__all__ = ["DISTANCES", "exponent_on_grid", "exponents_of_pairs"]

DISTANCES = tuple(10.0 ** (-k / 2) for k in range(4, 11))

_HALF = (0.25, 0.125)  # of the window round a periodic point, in p and y
_FEWEST, _COUNTED = 3, 10  # distances through which a line is fitted, pairs that make one count
_BLOCKS = 5  # along p and along y, left out one by one
_MIXED = 0.5  # part of what labels strewn at random would give, above which it saturates


def exponent_on_grid(omega: float, cells: int = 96) -> Evidence:
    """Uncertainty exponent in a window round a point of the largest periodic basin.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    cells : int, optional
        Cells along p and along y.

    Returns
    -------
    dict
        ``period`` of the point, its ``place``, ``exponent``, ``error`` and ``message``.

    Examples
    --------
    >>> found = exponent_on_grid(1.7, cells=32)
    >>> found["period"], 0.0 < found["exponent"] < 0.8
    (3, True)
    """
    found = attractors(oscillator(omega), WINDOW, completion=SECTION)
    cycles = found.isel(attractor=np.flatnonzero(found["period"].values))
    largest = cycles.isel(attractor=int(np.argmax(cycles["fraction"].values)))
    p, y = (float(largest["points"].sel(state=name)[0]) for name in "py")
    window = {"p": (p - _HALF[0], p + _HALF[0]), "y": (y - _HALF[1], y + _HALF[1])}
    found = uncertainty_exponent(section_basins(omega, cells, window))
    return {
        "period": int(largest["period"]),
        "place": [p, y],
        "exponent": float(found["uncertainty_exponent"]),
        "error": float(found["standard_error"]),
        "message": str(found.attrs["message"]),
    }


def exponents_of_pairs(
    omega: float, starts: int = 50, distances: Sequence[float] = DISTANCES
) -> list[Evidence]:
    """Uncertainty exponents over the whole section, from pairs of starts.

    Starts on an even grid and those displaced along p are compared: do both lead to the same
    attractor (all basins together), or both to this one or not (one basin against the rest).

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    starts : int, optional
        Along p and along y.
    distances : sequence of float, optional
        Displacements.

    Returns
    -------
    list of dict
        First all basins together, then each: ``basin`` (period, 0: chaos, None: all), ``share`` of
        the starts, ``uncertain`` fractions over ``distances``, ``exponent`` and ``error``, None
        where fewer than three distances have ten uncertain pairs without being mixed throughout.

    Examples
    --------
    >>> rows = exponents_of_pairs(1.7, starts=20, distances=(0.01, 0.001))
    >>> [row["basin"] for row in rows]
    [None, 3, 9, 0]
    """
    grid = {
        name: np.linspace(*ends, starts, endpoint=False) + 0.5 * (ends[1] - ends[0]) / starts
        for name, ends in WINDOW.items()
    }
    displaced = np.unique(np.concatenate([grid["p"], *(grid["p"] + d for d in distances)]))
    found = basins_of_attraction(
        oscillator(omega), {"p": displaced, "y": grid["y"]}, completion=SECTION
    )
    label = found["label"].values
    here = label[:, np.searchsorted(displaced, grid["p"])]
    there = [label[:, np.searchsorted(displaced, grid["p"] + d)] for d in distances]
    together = np.stack([here != other for other in there])
    rows = [{"basin": None, "share": 1.0, **_law(together, distances, _strewn(here))}]
    for number, period in zip(found["attractor"].values, found["period"].values, strict=True):
        inside = here == number
        differ = np.stack([inside != (other == number) for other in there])
        of_one = {"basin": int(period), "share": float(inside.mean())}
        rows.append({**of_one, **_law(differ, distances, _strewn(inside))})
    return rows


def _strewn(labels: np.ndarray) -> float:
    """Fraction of pairs that differ when the same labels are strewn at random."""
    counts = np.unique(labels, return_counts=True)[1] / labels.size
    return float(1.0 - counts @ counts)


def _law(differ: np.ndarray, distances: Sequence[float], strewn: float) -> Evidence:
    """Power law through the fractions of pairs that differ, shape (distance, y, p)."""
    sizes = np.array(distances)
    counts = differ.sum(axis=(1, 2))
    fraction = counts / differ[0].size
    used = (fraction <= _MIXED * strewn) & (counts >= _COUNTED)
    law: Evidence = {
        "distances": sizes.tolist(), "uncertain": fraction.tolist(),
        "exponent": None, "error": None,
    }  # fmt: skip
    if used.sum() < _FEWEST:
        return law
    across, kept = np.log(sizes[used]), differ[used]
    slope, offset = np.polyfit(across, np.log(fraction[used]), 1)
    residuals = np.log(fraction[used]) - slope * across - offset
    scatter = np.sqrt(
        np.sum(residuals**2) / (used.sum() - 2) / np.sum((across - across.mean()) ** 2)
    )
    without = [np.polyfit(across, np.log(left), 1)[0] for left in _left_out(kept)]
    jackknife = np.sqrt((len(without) - 1) * np.var(without))
    return law | {"exponent": float(slope), "error": float(np.hypot(scatter, jackknife))}


def _left_out(differ: np.ndarray) -> list[np.ndarray]:
    """Counts over the distances without one block of the section after the other."""
    sums = np.array(
        [
            block.sum(axis=(1, 2))
            for band in np.array_split(differ, _BLOCKS, axis=1)
            for block in np.array_split(band, _BLOCKS, axis=2)
        ]
    )
    rest = sums.sum(axis=0) - sums
    return [left for left in rest if left.all()]
