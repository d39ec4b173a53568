"""At which crack length the strange attractor is born: followed as the crack grows, or from starts.

Followed, the motion is what a monitor would see; from many starts another attractor may be chaotic
earlier. Both are first crack lengths on a grid.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from nonsmooth import bifurcation_diagram, ensemble
from nonsmooth_chapter.fatigue.beam_data import beam
from nonsmooth_chapter.fatigue.crack_motions import largest_exponent, period_of
from nonsmooth_chapter.judgement import Evidence

__all__ = ["crack_grid", "followed_periods", "onset_along_growth", "onset_from_starts"]

STEP = 0.02  # mm
_FIRST, _LAST = 5.0, 19.8
_STARTS = {
    "u": [0.0, 1.0, -1.0, 0.3, -0.4, 2.0],
    "v": [0.0, 0.0, 1.0, -2.0, 0.5, 2.0],
}
_TRANSIENT, _RECORD = 400, 128


def crack_grid(first: float = _FIRST, last: float = _LAST, step: float = STEP) -> np.ndarray:
    """Crack lengths of a sweep.

    Parameters
    ----------
    first, last, step : float, optional
        In mm.

    Returns
    -------
    numpy.ndarray

    Examples
    --------
    >>> crack_grid(5.0, 5.1, 0.05).tolist()
    [5.0, 5.05, 5.1]
    """
    return np.round(np.arange(first, last + 0.5 * step, step), 6)


@lru_cache(maxsize=64)
def followed_periods(step: float = STEP, **parameters: float) -> Any:
    """Diagram over the crack length, followed up from rest at 5 mm.

    Parameters
    ----------
    step : float, optional
        Between columns [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    xarray.Dataset
        As from `bifurcation_diagram`, one lane.
    """
    return bifurcation_diagram(
        beam(_FIRST, **parameters), "crack", crack_grid(step=step), start="follow up",
        transient=_TRANSIENT, record=_RECORD,
    ).isel(lane=0)  # fmt: skip


@lru_cache(maxsize=64)
def onset_along_growth(step: float = STEP, **parameters: float) -> Evidence:
    """First crack length at which the followed motion is chaotic.

    Parameters
    ----------
    step : float, optional
        Between columns [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    dict
        ``crack`` (None without chaos up to 19.8 mm), ``exponent`` and ``error`` per period there,
        and ``other_than_one``, the first length at which the period is not one.

    Examples
    --------
    >>> 14.0 < onset_along_growth(0.1)["crack"] < 15.0
    True
    """
    found = followed_periods(step, **parameters)
    cracks, periods = found["parameter"].values, found["period"].values
    row: Evidence = {"crack": None, "exponent": None, "error": None}
    other = np.flatnonzero(periods != 1)
    row["other_than_one"] = float(cracks[other[0]]) if other.size else None
    for column in np.flatnonzero(periods == 0):
        there = beam(float(cracks[column]), **parameters)
        tried = largest_exponent(there, found.isel(parameter=column, point=-1), record=600)
        if tried["chaotic"]:
            return row | {
                "crack": float(cracks[column]),
                "exponent": tried["exponent"],
                "error": tried["error"],
            }
    return row


@lru_cache(maxsize=32)
def onset_from_starts(step: float = 0.05, **parameters: float) -> Evidence:
    """First crack length at which any of six starts leads to chaos.

    Parameters
    ----------
    step : float, optional
        Between lengths [mm].
    **parameters : float
        Changed parameters of the beam.

    Returns
    -------
    dict
        ``crack`` (None without chaos), ``exponent`` and ``error`` per period there, ``last``, the
        last length with a chaotic motion, and ``share`` of lengths in between that have one.
    """
    cracks = crack_grid(step=step)
    system = beam(_FIRST, **parameters)
    runs = ensemble(
        system, _STARTS, parameters={"crack": cracks.tolist()}, transient=1000, record=_RECORD
    )
    points = np.stack([runs["u"].values, runs["v"].values], axis=-1)
    found: dict[float, Evidence] = {}
    for lane in range(runs.sizes["lane"]):
        crack = float(runs["crack"][lane])
        if crack in found or period_of(points[lane]):
            continue
        there = beam(crack, **parameters)
        tried = largest_exponent(there, runs.isel(lane=lane, point=-1), record=600)
        if tried["chaotic"]:
            found[crack] = tried
    if not found:
        return {"crack": None, "exponent": None, "error": None, "last": None, "share": 0.0}
    first, last = min(found), max(found)
    between = int(np.sum((cracks >= first - 1e-9) & (cracks <= last + 1e-9)))
    return {
        "crack": first, "exponent": found[first]["exponent"], "error": found[first]["error"],
        "last": last, "share": len(found) / between,
    }  # fmt: skip
