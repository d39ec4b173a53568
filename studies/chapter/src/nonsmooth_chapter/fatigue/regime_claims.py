"""Claims on the responses at four crack lengths of Fig. 29: period one, two chaotic, period four.

The chapter gives neither s nor d. What the convention gives is computed from many starts and by
following, and what the range of missing data gives from two; near 5 mm open and closed stiffness
are so close that the circle criterion decides for every d.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth import bifurcation_diagram
from nonsmooth_chapter.fatigue.beam_data import (
    D_RANGE,
    ETA,
    K_CLOSED,
    K_FACTOR,
    S_RANGE,
    WIDTH,
    XI,
    beam,
)
from nonsmooth_chapter.fatigue.crack_motions import (
    BOX_STARTS,
    DROPPED,
    largest_exponent,
    motions,
    motions_from,
    scan_of_missing_data,
    settling,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "circle_criterion", "regimes_at"]

_STARTS = {"u": [0.0, 1.0], "v": [0.0, 0.0]}
_FOLLOWED = {"follow up": 5.0, "follow down": 18.0}
_LASTS = 500  # periods: the linear motion settles within 100
_STEP = 0.02  # mm between columns that are followed
CHAOTIC = 0


def regimes_at(crack: float) -> Evidence:
    """Regimes of the beam with a crack of one length, by every route.

    Parameters
    ----------
    crack : float
        Length [mm].

    Returns
    -------
    dict
        ``attractors`` of a box of starts, ``starts`` (rest and (1, 0)), ``followed`` up from 5 and
        down from 18 mm, ``settling`` times and the ``scan`` over s and d.
    """
    system = beam(crack)
    scan = scan_of_missing_data(crack)
    return {
        "crack": crack,
        "attractors": list(motions(system)),
        "starts": motions_from(system, _STARTS),
        "followed": [_followed(crack, start) for start in _FOLLOWED],
        "settling": settling(system),
        "scan": {name: scan[name] for name in ("cases", "shares")},
    }


def _followed(crack: float, start: Any) -> Evidence:
    begin = _FOLLOWED[start]
    columns = max(round(abs(begin - crack) / _STEP), 1)
    values = np.unique(np.linspace(begin, crack, columns + 1))
    found = bifurcation_diagram(
        beam(crack), "crack", values, start=start, transient=300, record=128
    ).sel(parameter=crack, method="nearest").isel(lane=0)  # fmt: skip
    row: Evidence = {"start": start, "from": begin, "period": int(found["period"])}
    if not row["period"]:
        row |= largest_exponent(beam(crack), found.isel(point=-1))
    return row


def circle_criterion(crack: float, s: float, *, xi: float = XI) -> float:
    """Share of what the circle criterion allows by which open and closed stiffness differ.

    Below 1 any two motions approach each other, for every force: there is one motion with the
    period of the forcing, and all others settle to it.

    Parameters
    ----------
    crack : float
        Length [mm].
    s : float
        Scale of the stiffnesses.
    xi : float, optional
        Ratio of damping.

    Returns
    -------
    float
        (kappa_closed - kappa_open) / (4 xi (sqrt(k) - xi)), with k = 1 + kappa_closed.

    Examples
    --------
    >>> circle_criterion(5.05, 1.0) < 1.0 < circle_criterion(5.1, 1.0)
    True
    """
    difference = s * (K_CLOSED - K_FACTOR * (WIDTH - crack) ** 3)
    # Re 1/(k - w^2 + 2 i xi w) is largest where k - w^2 = 2 xi sqrt(k)
    return float(difference / (4.0 * xi * (np.sqrt(1.0 + s * K_CLOSED) - xi)))


def _near_five(cracks: tuple[float, ...] = (5.0, 5.05)) -> Evidence:
    scales = np.geomspace(*S_RANGE, 200)
    return {
        "rows": [regimes_at(crack) for crack in cracks],
        "criterion": [
            {
                "crack": crack,
                "worst": max(abs(circle_criterion(crack, s)) for s in scales),
                "convention": circle_criterion(crack, 1.0),
            }
            for crack in cracks
        ],
    }


def _regime(row: Evidence) -> str:
    if row["period"]:
        return f"period {row['period']}"
    return f"chaos ({row['exponent']:.3f} +- {row['error']:.3f} per period)" if row.get(
        "chaotic", row.get("kind") == "chaotic"
    ) else f"no period ({row['exponent']:.3f} +- {row['error']:.3f})"  # fmt: skip


def _text(evidence: Evidence) -> str:
    found = ", ".join(
        f"{_regime(row)} ({row['share']:.0%}"
        + (f", multiplier {row['multiplier']:.2f})" if row["period"] else ")")
        for row in evidence["attractors"]
    )
    starts = ", ".join(
        f"{_regime(row)} from ({row['u']:g}, {row['v']:g})" for row in evidence["starts"]
    )
    followed = ", ".join(
        f"{_regime(row)} by {row['start']} from {row['from']:g}" for row in evidence["followed"]
    )
    waits = evidence["settling"]
    settled = "" if waits["longest"] is None else (
        f"; cycles are reached within {waits['longest']} periods (median {waits['median']:.0f})"
        + (", no chaotic transient that lasts" if waits["longest"] < _LASTS else "")
    )  # fmt: skip
    shares = ", ".join(
        f"{name if name in ('chaotic', 'neither') else 'period ' + name} {share:.1%}"
        for name, share in sorted(evidence["scan"]["shares"].items(), key=lambda row: -row[1])[:6]
    )
    return (
        f"{evidence['crack']:g} mm, s = 1, d = 0: {found} of {BOX_STARTS} starts; {starts};"
        f" {followed}{settled}; over s and d ({evidence['scan']['cases']} cases): {shares}"
    )


def _judge(label: int) -> Any:
    def judge(evidence: Evidence) -> Finding:
        first = evidence["starts"][0]
        here = first["period"] == label and (label != CHAOTIC or first["chaotic"])
        return Finding(bool(here), _text(evidence))

    return judge


def _judge_five(evidence: Evidence) -> Finding:
    alone = all(
        [motion["period"] for motion in row["attractors"]] == [1] for row in evidence["rows"]
    )
    proven = all(row["worst"] < 1.0 for row in evidence["criterion"])
    scanned = all(row["scan"]["shares"] == {"1": 1.0} for row in evidence["rows"])
    bounds = ", ".join(
        f"{row['crack']:g} mm {row['worst']:.2g} (s = 1: {row['convention']:.2g})"
        for row in evidence["criterion"]
    )
    text = (
        f"{_text(evidence['rows'][0])}; difference of stiffness beside what the circle criterion"
        f" allows, at most over s: {bounds}; below 1 the motion of period one is the only one"
    )
    for_all = f"s {S_RANGE[0]:g} to {S_RANGE[1]:g}, every d" if proven and scanned else ""
    return Finding(alone, text, for_all)


_RANGE = (
    f"s {S_RANGE[0]:g} to {S_RANGE[1]:g}, d {D_RANGE[0]:.2f} to {D_RANGE[1]:.2f}, from rest and"
    " from (1, 0)"
)
_PROTOCOL = (
    f"xi {XI}, eta {ETA}, convention s = 1, d = 0; from rest decides, beside it (1, 0), attractors"
    f" of {BOX_STARTS} starts in |u|, |v| < 3, following up from 5 and down from 18 mm in steps of"
    f" {_STEP:g} mm; {DROPPED} periods dropped, exponent over 1000; settled: within 1 % of the"
    f" cycle; scan over {_RANGE}, 2000 dropped"
)


def _check(claim: str, crack: float, label: int) -> Check:
    return Check(claim, _PROTOCOL, lambda: regimes_at(crack), _judge(label))


CHECKS = (
    Check("F45", _PROTOCOL + "; near: 5.00 and 5.05 mm; for all forces by the circle criterion",
          _near_five, _judge_five),
    _check("F46", 12.09, CHAOTIC),
    _check("F47", 13.03, CHAOTIC),
    _check("F48", 13.4, 4),
)  # fmt: skip
