"""Where the motions of set A change over eta: by restart, by following, and on the orbits."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import xarray as xr

from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.rotor.data import set_a
from nonsmooth_chapter.rotor.orbits import follow_orbit, orbit_near
from nonsmooth_chapter.rotor.speed_sweeps import (
    Sweep,
    even_values,
    last_strobe,
    speed_sweeps,
    stretches,
)

__all__ = ["branch_end", "orbit_at", "sweep_of_set_a", "transition"]

_COLUMNS, _FOLLOWED = 600, 300  # from 2 to 5
_ZOOM, _LONG = 20, 3000  # columns between two, and periods left out in them
_AGAIN = 0.2  # of eta, within which another stretch of the same period is told
_BETWEEN = 4  # columns at most that have not settled where one period becomes another


@lru_cache(maxsize=8)
def sweep_of_set_a(delta: float, start: str) -> Sweep:
    """Diagram of set A over eta from 2 to 5 by one protocol.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    start : str
        Protocol; 600 columns that restart, or 300 that follow.

    Returns
    -------
    Sweep
    """
    if start == "restart":
        return speed_sweeps(set_a(delta), even_values(2.0, 5.0, _COLUMNS), (start,))[0]
    both = ("follow up", "follow down")
    found = speed_sweeps(set_a(delta), even_values(2.0, 5.0, _FOLLOWED), both)
    return found[both.index(start)]


def transition(delta: float, before: int, after: int | None, near: str, start: str) -> Evidence:
    """Where one period becomes another as eta rises, nearest to a printed value.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    before : int
        Period below.
    after : int or None
        Period above, any other motion without it.
    near : str
        The printed value.
    start : str
        Protocol.

    Returns
    -------
    dict
        ``last`` eta with the period below, ``first`` with the motion above, ``becomes`` (its
        period, 0 for none); for columns that restart after a zoom in with longer transients.
        Both are None where there is no such change. ``others``: stretches of the period above,
        up to where that orbit could be meant, with ``from``, ``last`` and ``becomes``.
    """
    sweep = sweep_of_set_a(delta, start)
    place = _nearest(sweep, before, after, float(near))
    if place is None:
        return {"start": start, "last": None, "first": None, "becomes": None, "others": []}
    low, high = place
    others = [
        each for each in _ends_of(sweep, before)
        if sweep.eta[high] < each["last"] <= sweep.eta[high] + _AGAIN
    ]  # fmt: skip
    if start == "restart":
        inner = even_values(float(sweep.eta[low]), float(sweep.eta[high]), _ZOOM)
        (zoom,) = speed_sweeps(set_a(delta), inner, (start,), transient=_LONG)
        closer = _nearest(zoom, before, after, float(near))
        if closer is not None:
            sweep, (low, high) = zoom, closer
    return {
        "start": start,
        "last": float(sweep.eta[low]),
        "first": float(sweep.eta[high]),
        "becomes": max(int(sweep.labels[high]), 0),
        "others": others,
    }


def _ends_of(sweep: Sweep, period: int) -> list[Evidence]:
    """Stretches of a period, and what the column behind each shows (0: no period)."""
    parts = stretches(sweep)
    return [
        {"from": first, "last": last, "becomes": max(behind[0], 0)}
        for (label, first, last), behind in pairwise(parts)
        if label == period
    ]


def _nearest(sweep: Sweep, before: int, after: int | None, near: float) -> tuple[int, int] | None:
    """Last column with one period and first one with the other."""
    labels, found = sweep.labels, []
    for low in np.flatnonzero(labels[:-1] == before).tolist():
        for high in range(low + 1, min(low + 2 + _BETWEEN, labels.size)):
            if labels[high] == before:
                break
            if after is None or labels[high] == after:
                found.append((low, high))
                break
            if labels[high] > 0:
                break
    middle = [abs(0.5 * (sweep.eta[a] + sweep.eta[b]) - near) for a, b in found]
    return found[int(np.argmin(middle))] if found else None


@lru_cache(maxsize=16)
def orbit_at(delta: float, period: int, eta: float) -> xr.Dataset | None:
    """Orbit of set A that the start at zero leads to.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    period : int
        Its period.
    eta : float
        Ratio of frequencies.

    Returns
    -------
    xarray.Dataset or None
        As from `orbit_near`.
    """
    system = set_a(delta, eta)
    return orbit_near(system, last_strobe(system, 1500), period)


def branch_end(delta: float, period: int, begin: float, to: float) -> Evidence:
    """Where an orbit of set A stops being stable, followed from where zero leads to it.

    Parameters
    ----------
    delta : float
        Preload along both axes.
    period : int
        Its period.
    begin, to : float
        First and last eta.

    Returns
    -------
    dict
        As from `follow_orbit`.

    Examples
    --------
    >>> branch_end(0.0, 1, 2.05, 2.1)["kind"]
    'none'
    """
    orbit = orbit_at(delta, period, begin)
    if orbit is None:
        return {"eta": begin, "kind": "no orbit", "multiplier": [0.0, 0.0], "changes": []}
    return follow_orbit(set_a(delta, begin), orbit, to)
