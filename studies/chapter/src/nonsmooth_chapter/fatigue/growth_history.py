"""What the beam does while its crack grows: labels, chaotic stretches, and the way of its point."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth_chapter.fatigue.beam_data import D_RANGE, S_RANGE
from nonsmooth_chapter.fatigue.growing import (
    LATE_STARTS,
    Growth,
    growing_run,
    labelled_stretches,
    local_exponent,
    strobe_labels,
)
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "LATE",
    "MANY",
    "SCANNED",
    "convention_histories",
    "first_loss",
    "history",
    "label_share",
    "longest_retreat",
    "scanned_histories",
    "separators",
]

LATE = 820_000.0  # begin of further runs: 6.3 mm, where all starts settle to one motion
SCANNED = {
    "s": np.geomspace(*S_RANGE, 5).round(4).tolist(),
    "d": np.linspace(*D_RANGE, 5).round(4).tolist(),
}
_SETTLING = 200  # strobes left out at the beginning of each run
_SHORTEST = 20  # strobes of a stretch with an exponent of its own
MANY = 100  # strobes: a periodic stretch that counts, longer than the window of a label


@lru_cache(maxsize=64)
def history(
    grows: Growth = "frozen",
    start: tuple[float, float] = (0.0, 0.0),
    first: float = 0.0,
    **parameters: float,
) -> Evidence:
    """Stretches of one label of a run, those without a period with their exponents.

    Parameters
    ----------
    grows, start, first, **parameters
        As for `growing_run`.

    Returns
    -------
    dict
        ``grows``, ``start``, ``first`` and ``stretches``, rows as from `labelled_stretches` with
        ``exponent``, ``error`` and ``chaotic`` where there is no period.

    Examples
    --------
    >>> found = history("flow", first=935_000.0)
    >>> [row["period"] for row in found["stretches"]][:1]
    [2]
    """
    run = growing_run(grows, start, first, **parameters).isel(time=slice(_SETTLING, None))
    stretches = labelled_stretches(strobe_labels(run))
    for row in stretches:
        if row["period"]:
            continue
        row |= {"chaotic": False, "exponent": None, "error": None}
        if row["strobes"] >= _SHORTEST:
            row |= local_exponent(run, row["from_tau"], row["to_tau"], **parameters)
    return {"grows": grows, "start": list(start), "first": first, "stretches": stretches}


@lru_cache(maxsize=1)
def convention_histories() -> tuple[Evidence, ...]:
    """Runs with s = 1, d = 0: the whole of Fig. 30 from rest both ways, and others from 6.3 mm.

    Returns
    -------
    tuple of dict
        As from `history`: frozen and within the flow from rest at 5 mm, then frozen from each of
        the other starts at 6.3 mm.
    """
    whole = [history(grows) for grows in ("frozen", "flow")]
    return tuple(whole + [history("frozen", start, LATE) for start in LATE_STARTS[1:]])


@lru_cache(maxsize=1)
def scanned_histories() -> tuple[Evidence, ...]:
    """Runs from rest at 6.3 mm over s and d, with a crack that grows within the flow.

    Returns
    -------
    tuple of dict
        As from `history`, with ``s`` and ``d``, and ``retreat`` as from `longest_retreat`.
    """
    found = []
    for s in SCANNED["s"]:
        for d in SCANNED["d"]:
            row = history("flow", (0.0, 0.0), LATE, s=s, d=d)
            run = growing_run("flow", (0.0, 0.0), LATE, s=s, d=d)
            found.append(row | {"s": s, "d": d, "retreat": longest_retreat(run)})
    return tuple(found)


def first_loss(row: Evidence) -> tuple[float | None, str]:
    """Crack length at which period one first gives way to something else, and to what.

    Stretches without a period that are not chaotic and lead back to period one are jumps from
    one such motion to another, and do not count.

    Parameters
    ----------
    row : dict
        As from `history`.

    Returns
    -------
    length : float or None
        In mm; None where it never does.
    other : str
        "period 2", "chaos", or "no period".

    Examples
    --------
    >>> jump = {"period": 0, "chaotic": False, "from_crack": 7.6}
    >>> first_loss({"stretches": [{"period": 1}, jump, {"period": 1}]})
    (None, '')
    """
    stretches = row["stretches"]
    for k, each in enumerate(stretches):
        if each["period"] == 1:
            continue
        following = next((later["period"] for later in stretches[k:] if later["period"]), 0)
        if not each["period"] and not each["chaotic"] and following == 1:
            continue
        if each["period"]:
            return each["from_crack"], f"period {each['period']}"
        return each["from_crack"], "chaos" if each["chaotic"] else f"period {following}"
    return None, ""


def label_share(row: Evidence, low: float, high: float, label: Any) -> float:
    """Part of a span of time that has a label.

    Parameters
    ----------
    row : dict
        As from `history`.
    low, high : float
        Times.
    label : int or "chaos"
        Period, or chaos.

    Returns
    -------
    float

    Examples
    --------
    >>> stretch = {"period": 2, "from_tau": 0.0, "to_tau": 10.0}
    >>> label_share({"stretches": [stretch]}, 5.0, 15.0, 2)
    0.5
    """
    total = 0.0
    for each in row["stretches"]:
        same = each["period"] == label or (label == "chaos" and each.get("chaotic", False))
        if same:
            total += max(min(each["to_tau"], high) - max(each["from_tau"], low), 0.0)
    return total / (high - low)


def separators(row: Evidence, after: float) -> list[Evidence]:
    """What lies between long periodic stretches behind a crack length.

    Parameters
    ----------
    row : dict
        As from `history`.
    after : float
        Crack length [mm] from which on to look.

    Returns
    -------
    list of dict
        ``before`` and ``behind`` (periods), ``from_crack``, ``to_crack``, and whether chaos lies
        between (``chaotic``).
    """
    stretches = row["stretches"]
    long_ones = [
        k for k, each in enumerate(stretches) if each["period"] and each["strobes"] >= MANY
    ]
    rows = []
    for one, other in pairwise(long_ones):
        first, second = stretches[one], stretches[other]
        if second["from_crack"] < after:
            continue
        rows.append(
            {
                "before": first["period"],
                "behind": second["period"],
                "from_crack": first["to_crack"],
                "to_crack": second["from_crack"],
                "chaotic": any(each.get("chaotic", False) for each in stretches[one + 1 : other]),
            }
        )
    return rows


def longest_retreat(run: xr.Dataset, last: float = 10.7) -> Evidence:
    """How far the strobed point goes back on its way, while the crack is shorter than a length.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.
    last : float, optional
        Crack length [mm].

    Returns
    -------
    dict
        For ``u`` and ``v`` the largest fall against the way from the first to the last point,
        beside the range.
    """
    part = run.isel(time=slice(_SETTLING, None))
    part = part.isel(time=part["crack"].values < last)
    found: Evidence = {}
    for name in ("u", "v"):
        values = part[name].values
        values = values if values[-1] >= values[0] else -values
        back = np.maximum.accumulate(values) - values
        found[name] = float(back.max() / np.ptp(values))
    return found
